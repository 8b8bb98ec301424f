// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/board/reduced.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/camera/correction_field.h"
#include "alidade/core/cancel.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// A correction field of the only camera of a fit. The fit itself knows no field: its corners are those that
/// the camera would see without it.
using CorrectionPointer = std::shared_ptr<const CorrectionField>;

/// The views as a camera would see them without the field. Corners that have no such place are left out.
/// @throws Error (kInput) for a field that moves pixels by more than noise and detectors can
[[nodiscard]] std::vector<View> freeOf(const CorrectionField& field, std::vector<View> views);

/// Moves all corners from where the camera would see them without `from` to where it would without `to`;
/// null: no field. Corners that have no such place stay.
void moveCorners(Fit& fit, const CorrectionField* from, const CorrectionField* to);

/// A field that is estimated together with the camera, all poses and its own strength.
///
/// The control points are normally distributed about zero, with the precision (1 + L)^2 over their variance,
/// where L is the Laplacian of the grid: bending costs, and a field falls back to zero where no corner was
/// seen (Lindgren, Rue and Lindstroem 2011, An explicit link between Gaussian fields and Gaussian Markov
/// random fields, JRSS B 73(4)). Directions of the parameters and poses that act like a field are free, so
/// they take all that they can, and parameters keep their meaning. The variance maximises the likelihood of
/// the corners.
class CorrectionEquations {
 public:
  /// @param fit      solved, of one camera, with corners free of `present`
  /// @param present  the field so far; null: none
  CorrectionEquations(const Fit& fit, const CorrectionGrid& grid, const CorrectionField* present);

  /// The variance of control points over that of a coordinate of a corner of weight 1, and twice the
  /// logarithm of the likelihood that it gains over no field.
  struct Strength {
    double ratio = 0;
    double gain = 0;
  };
  [[nodiscard]] Strength likeliest() const;

  /// The field of this strength from all views, or from those outside one fold of foldOf(); null if it would
  /// fold.
  [[nodiscard]] CorrectionPointer field(double ratio, std::optional<int> without_fold = {}) const;

  /// The covariance of the parameters and of the field's points, in this order, for corners of this variance.
  [[nodiscard]] Eigen::MatrixXd covariance(double ratio, double variance) const;
  /// The covariance of the parameters if the field were known.
  [[nodiscard]] Eigen::MatrixXd covarianceWithout(double variance) const;

 private:
  struct Sums {
    Eigen::MatrixXd information;  // of parameters, then points; poses eliminated
    Eigen::VectorXd gradient;
  };
  // With the parameters eliminated: minimises c^T information c / 2 - c^T pull over points c without a prior.
  struct OfField {
    Eigen::MatrixXd information;
    Eigen::VectorXd pull;
  };
  [[nodiscard]] OfField ofField(const Sums& sums) const;

  CorrectionGrid grid_;
  Eigen::MatrixXd directions_;  // of free parameters
  Eigen::VectorXd present_;
  Eigen::MatrixXd precision_;  // of points with the variance 1
  Sums all_;
  std::vector<Sums> of_fold_;
  double cost_ = 0;     // sum of squares without a field
  double freedom_ = 0;  // degrees of freedom without a field
};

/// A fit with a field.
struct CorrectedFit {
  Fit fit;                  ///< corners free of the field
  CorrectionPointer field;  ///< null: the corners show none
  CorrectionEquations::Strength strength;
};

/// Estimates a field of this grid together with the fit.
/// @param fit      solved, of one camera, with corners free of `present`
[[nodiscard]] CorrectedFit withCorrection(Fit fit, const CorrectionGrid& grid, CorrectionPointer present,
                                          const CancelFlag* cancel);

/// heldOutErrors() where each fold has the field from the other views.
[[nodiscard]] std::optional<HeldOutErrors> heldOutErrors(const CorrectedFit& corrected, int jobs,
                                                         const CancelFlag* cancel);

}  // namespace alidade
