// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/corner_groups.h"
#include "alidade/adjust/board/observation.h"
#include "alidade/core/lanes.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// The corners of a view in groups. The last group is padded with copies of the first corner with weight 0,
/// which project whenever the view does.
[[nodiscard]] std::vector<CornerGroup> groupsOf(std::span<const Observation> view);

/// The triangular factor of the normal equations [J r]^T [J r] of a view, with rows^T rows equal to the
/// equations. It has columns for the pose's tangent, the parameters and the error, and as many rows. Corners'
/// rows are scaled by the root of their weight times that of the loss, so that J^T r and J^T J are those of
/// iteratively reweighted least squares; the sum of rho replaces r^T r.
///
/// Only the first six rows involve the pose, and the last has only the error. The rows between contain the
/// view's information on the parameters with a free pose: rest^T rest is the Schur complement.
using ViewFactor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

enum class Unseen {
  kRefuse,   ///< a view with a corner that cannot be projected is rejected
  kLeaveOut  ///< corners like these are left out
};

/// The contribution of a view's corners to the robust fit of one camera model. The order of all sums is
/// fixed, so that results depend only on the arguments and on whether the processor has AVX2.
class ViewKernel {
 public:
  virtual ~ViewKernel() = default;

  [[nodiscard]] int numParams() const;

  /// Writes a ViewFactor row by row, (numParams() + 7)^2 numbers. False if a corner is behind the camera,
  /// beyond a pole or beyond a fold of the lens, unless it is left out.
  [[nodiscard]] bool factor(const double* params, const SE3& camera_from_board,
                            std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen,
                            double* rows) const;

  /// Sum of rho over the corners, px^2; NaN if a corner cannot be projected.
  [[nodiscard]] double sumOfRho(const double* params, const SE3& camera_from_board,
                                std::span<const CornerGroup> corners, HuberLoss loss) const;

  /// Projected minus observed, px, not weighted; NaN for a corner that cannot be projected.
  void errors(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
              std::span<Eigen::Vector2d> errors) const;

  /// Two rows per corner, for u and v: pose tangent, parameters, error, each times the square root of the
  /// corner's weight. Zero for a corner that cannot be projected.
  /// @param rows  row by row, 2 (numParams() + 7) numbers per corner
  void rows(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> corners,
            std::span<double> rows) const;

  /// The columns of write().
  [[nodiscard]] virtual const RowLayout& layout() const = 0;

  /// Writes both rows of each corner, taken as a point, u first, 2 layout().width lanes per group, times the
  /// square roots of its weight and of the loss weight, and adds its rho. Corners that do not project (behind
  /// the camera, beyond a pole, or beyond a fold of the lens) get zeros; false if there are any.
  virtual bool write(const double* params, const SE3& camera_from_board, std::span<const CornerGroup> groups,
                     HuberLoss loss, Lanes* rows, Lanes& sum_rho) const = 0;

  /// Writes the errors in u and v of each group of points, px, not weighted; NaN for a corner that does not
  /// project.
  virtual void writeErrors(const double* params, const SE3& camera_from_board,
                           std::span<const CornerGroup> groups, Lanes* errors) const = 0;
};

/// The kernel of a known model.
/// @param num_params  of the model, and those of EntrancePupil if the camera has one, see FitCamera
[[nodiscard]] const ViewKernel& viewKernel(std::string_view model_id, std::size_t num_params);

/// The factor of a view; nothing if a corner is rejected.
[[nodiscard]] std::optional<ViewFactor> viewFactor(const ViewKernel& kernel, std::span<const double> params,
                                                   const SE3& camera_from_board,
                                                   std::span<const CornerGroup> corners, HuberLoss loss,
                                                   Unseen unseen);

/// Information of a view on the parameters with a free pose: J^T W J minus the part that the pose absorbs, N
/// x N, per px^2.
[[nodiscard]] Eigen::MatrixXd paramsInformation(const ViewFactor& factor);

}  // namespace alidade
