// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// Pixels a radian on the axis, by x and y.
[[nodiscard]] Eigen::Vector2d axisFocal(const AnyCamera& camera);

/// Its change by the parameters, 2 x N. In models whose shape bends the middle of the image too (ucm, omni,
/// double_sphere, fov) it is not fx and fy alone that set it.
[[nodiscard]] Eigen::MatrixXd axisFocalJacobian(const AnyCamera& camera);

/// The parameters that `model_id` shares with the camera's model, by name; its further ones are zero. The
/// same camera where the one model contains the other.
[[nodiscard]] std::vector<double> parametersByName(std::string_view from_id, std::span<const double> params,
                                                   std::string_view model_id);

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
                                                          std::span<const double> named);

/// Parameters of the model's initial guess, with the principal point at the image centre and the given focal
/// length (positive) in pixels per radian on the axis. In some models, fx and fy differ from this focal
/// length.
[[nodiscard]] std::vector<double> startParameters(std::string_view model_id, double focal_px, ImageSize size);

/// Least squares of projected minus given pixels, from one start, by Levenberg and Marquardt's method with
/// the model's own Jacobians. A ray for which the formula has no value counts as far off; parameters stay in
/// the model's ranges, and those that are named in `absent` at 0.
[[nodiscard]] LensFit fitLens(std::string_view model_id, const std::vector<RaySample>& samples,
                              std::vector<double> start, std::span<const std::string_view> absent = {});

/// The best of fitLens() from all starts that look like the camera of the samples, `like`.
[[nodiscard]] LensFit bestLens(std::string_view model_id, const AnyCamera& like,
                               const std::vector<RaySample>& samples,
                               std::span<const std::string_view> absent = {});

/// A camera that looks roughly like a given camera.
struct LensShape {
  std::vector<double> params;  ///< in storage order
  /// Index of the parameter that gives this shape its character: held at first, the others adapt to it.
  std::optional<int> character = std::nullopt;
};

/// Cameras of one model that all look like a given camera. There may be several, because some models bend the
/// same way by different shapes, each with an optimum of its own: a double sphere with xi above and below
/// zero, Mei's model with another xi and the distortion that makes up for it, a quotient of polynomials with
/// and without a denominator. First the best fit, then those that differ from it on purpose.
/// @param pixels  where the likeness matters; those without a ray do not count
[[nodiscard]] std::vector<LensShape> lensShapes(std::string_view model_id, const AnyCamera& like,
                                                std::span<const Eigen::Vector2d> pixels);

}  // namespace alidade
