// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// Pixels per radian on the axis, in x and y.
[[nodiscard]] Eigen::Vector2d axisFocal(const AnyCamera& camera);

/// Derivative of axisFocal() by the parameters, 2 x N. In models whose shape also bends the image centre
/// (ucm, omni, double_sphere, fov), fx and fy alone do not determine it.
[[nodiscard]] Eigen::MatrixXd axisFocalJacobian(const AnyCamera& camera);

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
/// fx and fy such that the lens has `focal_px` pixels per radian on the axis and the principal point is at
/// `axis_px`.
[[nodiscard]] std::vector<std::vector<double>> lensStarts(std::string_view model_id,
                                                          const Eigen::Vector2d& focal_px,
                                                          const Eigen::Vector2d& axis_px,
                                                          std::span<const double> named);

/// Parameters of the model's initial guess, with the principal point at the image centre and the given focal
/// length (positive) in pixels per radian on the axis. In some models, fx and fy differ from this focal
/// length.
[[nodiscard]] std::vector<double> startParameters(std::string_view model_id, double focal_px, ImageSize size);

/// Least squares of projected minus given pixels, from one start, by Levenberg and Marquardt's method with
/// the model's own Jacobians. A ray without a value counts as a large error. Parameters stay in the model's
/// ranges; those named in `absent` stay 0.
[[nodiscard]] LensFit fitLens(std::string_view model_id, const std::vector<RaySample>& samples,
                              std::vector<double> start, std::span<const std::string_view> absent = {});

/// The best of fitLens() from all lensStarts() for the camera of the samples, `like`.
[[nodiscard]] LensFit bestLens(std::string_view model_id, const AnyCamera& like,
                               const std::vector<RaySample>& samples,
                               std::span<const std::string_view> absent = {});

/// A camera that looks roughly like a given camera.
struct LensShape {
  std::vector<double> params;  ///< in storage order
  /// Index of the parameter that characterises this shape: held at first, while the others adapt to it.
  std::optional<int> character = std::nullopt;
};

/// Cameras of one model that all look like a given camera. There may be several, because some models reach
/// the same distortion by different shapes, each with its own optimum: a double sphere with xi above and
/// below zero, Mei's model with a different xi and distortion that compensates, a quotient of polynomials
/// with and without a denominator. The best fit comes first, then deliberate variations of it.
/// @param pixels  to fit; those without a ray are ignored
[[nodiscard]] std::vector<LensShape> lensShapes(std::string_view model_id, const AnyCamera& like,
                                                std::span<const Eigen::Vector2d> pixels);

}  // namespace alidade
