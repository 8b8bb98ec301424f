// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include <Eigen/Core>

#include "alidade/adjust/corner_groups.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// Normal equations [J r]^T [J r] in the columns that all views share: parameters, then the error.
struct SharedSums {
  explicit SharedSums(int num_params)
      : gram(Eigen::MatrixXd::Zero(num_params + 1, num_params + 1)),
        diagonal(Eigen::VectorXd::Zero(num_params)) {}
  /// Schur complement of the poses, lower triangle; its last element is what they leave of the sum of rho.
  Eigen::MatrixXd gram;
  Eigen::VectorXd diagonal;  ///< sums of squares of the parameters' columns, with the poses in place
};

/// Rows that hold a pose's part of its view's normal equations: a column each for the pose's tangent, the
/// parameters and the error.
using PoseRows = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;

enum class Unseen {
  kRefuse,   ///< a view with a corner that cannot be projected is no view
  kLeaveOut  ///< without such corners
};

/// What a view's corners add to the robust fit of one camera model. All sums run in an order of their own, so
/// that results depend on the arguments alone and on whether the processor has AVX2.
class ViewKernel {
 public:
  virtual ~ViewKernel() = default;

  [[nodiscard]] virtual int numParams() const = 0;

  // The normal equations [J r]^T [J r] of a view: columns of the pose's tangent, the parameters and the
  // error. Corners' rows are scaled by the root of their weight times that of the loss, so that J^T r and J^T
  // J are those of iteratively reweighted least squares; the sum of rho stands in for r^T r.

  /// The triangular factor of the normal equations: writes as many rows as there are columns, numParams() +
  /// 7, with rows^T rows = the normal equations, in some order of their own; the last has only the error.
  /// False if a corner cannot be projected.
  [[nodiscard]] virtual bool factor(const double* params, const SE3& camera_from_board,
                                    std::span<const CornerGroup> corners, HuberLoss loss,
                                    double* rows) const = 0;

  /// Sum of rho over the corners, px^2; NaN if a corner cannot be projected.
  [[nodiscard]] virtual double sumOfRho(const double* params, const SE3& camera_from_board,
                                        std::span<const CornerGroup> corners, HuberLoss loss) const = 0;

  /// Eliminates the pose from the normal equations. Adds what is left to `sums`, and writes to `rows` six
  /// rows that hold the rest: rows^T rows + what is left = the view's normal equations. False if a corner is
  /// behind the camera, beyond a pole, or where the lens has folded, unless it is left out; then nothing is
  /// added.
  [[nodiscard]] virtual bool reduce(const double* params, const SE3& camera_from_board,
                                    std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen,
                                    PoseRows& rows, SharedSums& sums) const = 0;

  /// Projected minus observed, px, not weighted; NaN for a corner that cannot be projected.
  virtual void errors(const double* params, const SE3& camera_from_board,
                      std::span<const CornerGroup> corners, std::span<Eigen::Vector2d> errors) const = 0;

  /// Two rows a corner, of u and v: pose's tangent, parameters, error; each times the root of the corner's
  /// weight. Zero for a corner that cannot be projected.
  /// @param rows  row by row, 2 (numParams() + 7) numbers a corner
  virtual void rows(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
                    std::span<double> rows) const = 0;

  /// weight trace(J K J^T) of each corner, J by pose and parameters; 0 for one that cannot be projected.
  virtual void quadraticForms(const double* params, const SE3& camera_from_board,
                              std::span<const CornerGroup> corners, const Eigen::MatrixXd& K,
                              std::span<double> forms) const = 0;
};

/// The kernel of a model that is known.
[[nodiscard]] const ViewKernel& viewKernel(std::string_view model_id);

}  // namespace alidade
