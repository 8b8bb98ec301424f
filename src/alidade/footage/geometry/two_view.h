// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/footage/geometry/essential.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// The pixels at which two images of one camera show a point.
struct PixelMatch {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
  double sigma_px = 1;  ///< standard deviation of each coordinate
};

/// The kind of motion that two images of a scene show.
enum class TwoViewKind : std::uint8_t {
  kGeneral,   ///< a rotation and the direction of the translation
  kPlane,     ///< the same, but all points lie on a plane
  kRotation,  ///< the camera turned in place, or all points are far away: no translation can be seen
  kNone,      ///< too few points agree with one motion
};

struct TwoView {
  static constexpr std::size_t kFewestInliers = 12;

  TwoViewKind kind = TwoViewKind::kNone;
  SE3 b_from_a;                 ///< the translation has length 1; zero for kRotation
  std::vector<bool> is_inlier;  ///< one per match
  std::size_t num_inliers = 0;
  /// Median displacement of the inliers that no rotation explains, px.
  double parallax_px = 0;
  /// Homogeneous, in frame a; zero for outliers.
  std::vector<Eigen::Vector4d> points;
  /// Covariance of b_from_a, right perturbation [translation, rotation], with the length of the translation
  /// held. Scaled by the errors. Only for kGeneral and kPlane.
  Eigen::Matrix<double, 6, 6, Eigen::DontAlign> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// The motion between two images: five-point solutions of random samples, scored by the truncated squared
/// Sampson error in pixels (Torr and Zisserman 2000, MLESAC), the side of the camera by the depths of the
/// points, and the reprojection error of the inliers minimised over motion and points. Works on unit rays, so
/// for any lens and field of view.
/// @param size  of the images
[[nodiscard]] TwoView estimateTwoView(const AnyCamera& camera, std::span<const PixelMatch> matches,
                                      ImageSize size, std::uint64_t seed = 1);

/// The matches of two frames by the tracks that both show, in the order of commonTracks().
[[nodiscard]] std::vector<PixelMatch> matchesOf(const std::vector<TrackPixel>& a,
                                                const std::vector<TrackPixel>& b);

/// The error below which a pixel agrees with a motion: 2 px, or 0.2 % of the image's diagonal if that is
/// more. Wide enough for a camera that is a little wrong.
[[nodiscard]] double agreementPx(ImageSize size);

/// The rotation b_from_a that brings the rays of a nearest to those of b, of the larger part of the pairs.
[[nodiscard]] SO3 commonRotation(std::span<const RayPair> pairs);
/// Median angle that this rotation leaves between rays of a pair, radians if small. There must be a pair.
[[nodiscard]] double parallaxAngle(std::span<const RayPair> pairs);

/// The homogeneous point, of length 1, nearest to rays in the sense of least algebraic error, on the side
/// that the cameras see; the ray's end at infinity where they are parallel.
/// @param camera_from_world  of each ray
[[nodiscard]] Eigen::Vector4d pointOnRays(std::span<const SE3> camera_from_world,
                                          std::span<const Eigen::Vector3d> rays);

}  // namespace alidade
