// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// A pixel of a camera and the unit ray that leads to it.
struct RaySample {
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;
};

/// Parameters found for a model, in storage order.
struct LensFit {
  std::vector<double> params;
  double cost = 0;  ///< sum over the samples of dx^2 + dy^2, pixels^2
  int num_iterations = 0;
};

/// Starts for the model `model_id`: its own (CameraModel::kStartLens), one with `named` (any values for its
/// lens parameters by storage order; empty = none), and others within the ranges of its parameters, each with
/// fx and fy such that the axis has `focal_px` pixels a radian and the principal point at `axis_px`.
[[nodiscard]] std::vector<std::vector<double>> lensStarts(std::string_view model_id,
                                                          const Eigen::Vector2d& focal_px,
                                                          const Eigen::Vector2d& axis_px,
                                                          const std::vector<double>& named);

/// Least squares of projected minus given pixels, from one start, by Levenberg and Marquardt's method with
/// the model's own Jacobians. A ray for which the formula has no value counts as far off; parameters stay in
/// the model's ranges, and those that are named in `absent` at 0.
[[nodiscard]] LensFit fitLens(std::string_view model_id, const std::vector<RaySample>& samples,
                              std::vector<double> start, std::span<const std::string_view> absent = {});

/// The cost of parameters as they are.
[[nodiscard]] double lensCost(std::string_view model_id, const std::vector<RaySample>& samples,
                              const std::vector<double>& params);

}  // namespace alidade
