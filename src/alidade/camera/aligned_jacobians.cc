// SPDX-License-Identifier: MIT
#include "alidade/camera/aligned_jacobians.h"

#include <cmath>
#include <cstddef>

#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/so3.h"

namespace alidade {

AlignedJacobians alignedJacobians(const AnyCamera& camera, std::span<const Eigen::Vector2d> pixels,
                                  std::span<const Eigen::Vector2d> others, std::optional<Freed> freed,
                                  std::span<const double> weights) {
  const auto num_fitted = static_cast<Eigen::Index>(2 * pixels.size());
  const auto num_rows = num_fitted + static_cast<Eigen::Index>(2 * others.size());
  const auto num_params = static_cast<Eigen::Index>(camera.parameters().size());
  const Eigen::Index num_freed = !freed ? 0 : *freed == Freed::kRotation ? 3 : 6;
  // Two rows a pixel: its change by the parameters, and by the rotation and, in units of the distance, by the
  // position of the points.
  Eigen::MatrixXd by_params = Eigen::MatrixXd::Zero(num_rows, num_params);
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(num_rows, num_freed);
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_point;
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_params(2, num_params);
  AlignedJacobians result;
  for (const auto& list : {pixels, others}) {
    for (const Eigen::Vector2d& pixel : list) {
      const auto row = static_cast<Eigen::Index>(2 * result.has_ray.size());
      const auto ray = camera.unproject(pixel);
      result.has_ray.push_back(ray && camera.project(*ray, J_point.data(), J_params.data()).ok());
      if (!result.has_ray.back()) continue;
      by_params.middleRows<2>(row) = J_params;
      if (num_freed > 0) by_pose.block<2, 3>(row, 0) = -J_point * hat(*ray);
      if (num_freed > 3) by_pose.block<2, 3>(row, 3) = J_point;
    }
  }
  if (num_freed == 0) {
    result.transposed = by_params.transpose();
    return result;
  }
  Eigen::MatrixXd fitted_pose = by_pose.topRows(num_fitted);
  Eigen::MatrixXd fitted_params = by_params.topRows(num_fitted);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double root = std::sqrt(weights[i]);
    fitted_pose.middleRows<2>(2 * static_cast<Eigen::Index>(i)) *= root;
    fitted_params.middleRows<2>(2 * static_cast<Eigen::Index>(i)) *= root;
  }
  // Through a long lens a shift of the camera looks nearly like a turn. Any of the solutions will do, since
  // only what they leave over counts.
  const Eigen::MatrixXd W = leastSquares(fitted_pose, fitted_params);
  result.transposed = (by_params - by_pose * W).transpose();
  return result;
}

}  // namespace alidade
