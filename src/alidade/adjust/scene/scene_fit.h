// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A scene point in one image.
struct SceneSighting {
  std::uint32_t frame = 0;  ///< index into SceneFit::camera_from_world
  std::uint32_t point = 0;  ///< index into SceneFit::points
  Eigen::Vector2d pixel{0, 0};
  double sigma_px = 1;  ///< standard deviation of each coordinate, positive
  /// Change of the pixel per unit of SceneFit::readout: its velocity in px per frame, times its row's
  /// distance from the middle row as a share of the height.
  Eigen::Vector2d readout_px{0, 0};
};

/// Position errors shared by the points of one image, smooth over the image: for each coordinate a polynomial
/// of degree 3 in the pixel, scaled to -1 to 1 over the image. The first ten numbers are those of x, in px: 1
/// x y xx xy yy xxx xxy xyy yyy.
struct ErrorField {
  static constexpr int kTerms = 10;
  static constexpr int kSize = 2 * kTerms;
  using Basis = Eigen::Matrix<double, kTerms, 1>;
  using Coefficients = Eigen::Matrix<double, kSize, 1>;

  [[nodiscard]] static Basis basisAt(const Eigen::Vector2d& pixel, const ImageSize& size);
};

/// Images of a rigid scene of unknown points by one moving camera. World and points have no known scale.
struct SceneFit {
  AnyCamera camera;
  std::vector<SE3> camera_from_world;
  /// Homogeneous, of length 1: (x, y, z, w) is the point (x, y, z) / w, at infinity for w = 0.
  std::vector<Eigen::Vector4d> points;
  std::vector<SceneSighting> sightings;  ///< sorted by point, those of a point by frame
  std::size_t num_held_frames = 1;       ///< number of first frames whose poses are held; at least one
  /// Time from the exposure of the first row to that of the last, in frames: a rolling shutter.
  double readout = 0;
  HuberLoss loss = kNoLoss;  ///< of errors in units of sigma_px
  ImageSize size = {};
  /// Standard deviation of the coefficients of each image's error field, px; 0: there are none.
  double field_px = 0;
  std::vector<ErrorField::Coefficients> fields = {};  ///< one per frame if field_px is above 0
  SolveSummary summary = {};

  /// The displacement by a frame's error field, px. @pre there are fields
  [[nodiscard]] Eigen::Vector2d fieldAt(std::uint32_t frame, const ErrorField::Basis& basis) const;
};

/// A homogeneous point in the camera's frame, and its derivatives by the pose (right perturbation) and the
/// point.
struct PointInCamera {
  Eigen::Vector3d at;
  Eigen::Matrix<double, 3, 6> J_pose;
  Eigen::Matrix<double, 3, 4> J_point;
};
[[nodiscard]] PointInCamera inCamera(const SE3& camera_from_world, const Eigen::Vector4d& point);

/// Projection of a sighting's point by the camera of a fit, and the derivatives.
struct SceneProjection {
  bool ok = false;
  Eigen::Vector2d error{0, 0};  ///< projected minus observed, px
  Eigen::Matrix<double, 2, 6> J_pose;
  Eigen::Matrix<double, 2, 4> J_point;
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 24> J_params;
  ErrorField::Basis field;  ///< derivatives by each coordinate's coefficients
};
[[nodiscard]] SceneProjection projectSighting(const SceneFit& fit, const SceneSighting& sighting);

/// The error of a sighting, px; NaN if the point has no pixel.
[[nodiscard]] Eigen::Vector2d sightingError(const SceneFit& fit, const SceneSighting& sighting);

}  // namespace alidade
