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

/// The pixels of a point in two images of one camera.
struct PixelMatch {
  Eigen::Vector2d a;
  Eigen::Vector2d b;
  double sigma_px = 1;  ///< standard deviation of each coordinate
};

/// The kind of motion between two images of a scene.
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
  /// fixed. Scaled by the errors. Only for kGeneral and kPlane.
  Eigen::Matrix<double, 6, 6, Eigen::DontAlign> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// The motion between two images: five-point solutions of random samples, scored by the truncated squared
/// Sampson error in pixels (Torr and Zisserman 2000, MLESAC). The depths of the points select the side of the
/// camera, and the reprojection error of the inliers is minimised over motion and points. Works on unit rays,
/// and so for any lens and field of view.
/// @param size  of the images
[[nodiscard]] TwoView estimateTwoView(const AnyCamera& camera, std::span<const PixelMatch> matches,
                                      ImageSize size, std::uint64_t seed = 1);

/// The matches of two frames by the tracks that both show, in the order of commonTracks().
[[nodiscard]] std::vector<PixelMatch> matchesOf(const std::vector<TrackPixel>& a,
                                                const std::vector<TrackPixel>& b);

/// Largest error of a match that agrees with a motion: 2 px, or 0.2 % of the image's diagonal if that is
/// more; wide enough for a slightly wrong camera.
[[nodiscard]] double agreementPx(ImageSize size);

/// The rotation b_from_a that best aligns the rays of a with those of b, for the larger part of the pairs.
[[nodiscard]] SO3 commonRotation(std::span<const RayPair> pairs);
/// Median angle between the rays of a pair after this rotation, radians if small. @pre at least one pair
[[nodiscard]] double parallaxAngle(std::span<const RayPair> pairs);

/// The homogeneous point, of length 1, with the least algebraic distance from the rays, on the side that the
/// cameras see; for parallel rays, their end at infinity.
/// @param camera_from_world  of each ray
[[nodiscard]] Eigen::Vector4d pointOnRays(std::span<const SE3> camera_from_world,
                                          std::span<const Eigen::Vector3d> rays);

}  // namespace alidade
