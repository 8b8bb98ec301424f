// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>

#include "alidade/camera/any_rig.h"
#include "alidade/core/cancel.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"

namespace alidade {

/// One of the two views of a rectified pair.
struct RectifiedView {
  SO3 rectified_from_camera;                          ///< turns rays of the original camera frame
  Eigen::Vector2d axis_px = Eigen::Vector2d::Zero();  ///< where the z axis of the rectified frame appears
};

/// Two views of a rig, turned to a common orientation and laid out so that a point has the same row in both.
///
/// The x axis of the rectified frame is the baseline; if that is closer to the y axis of the cameras, the
/// frame has the baseline as its y axis, and a point has the same column instead (`is_vertical`). Images stay
/// upright either way, as with cv::stereoRectify.
///
/// The projections are those of OutputView with the baseline as their axis: rectilinear views have (x / z, y
/// / z) on their plane; cylindrical ones (x / hypot(y, z), atan2(y, z)), and equirectangular ones (atan2(x,
/// hypot(y, z)), atan2(y, z)). Each row of the last two is a plane through the baseline, so they also show
/// more than half of all directions. With `is_vertical`, x and y are swapped.
struct Rectification {
  ViewProjection projection = ViewProjection::kRectilinear;
  bool is_vertical = false;
  ImageSize size;       ///< of both views
  double scale_px = 1;  ///< pixels per unit of the plane: the focal length, or pixels per radian
  std::array<RectifiedView, 2> views;
  /// Position of the second camera along the axis of the baseline, as seen from the first, metres. Negative
  /// if the second camera is to the left of the first, or above it.
  double baseline_m = 0;
  /// ViewExtent::kAll: share of source pixels with a ray that are not shown, for the camera with the larger
  /// share.
  double cut_share = 0;

  /// The ray of a pixel of view `i` in the rectified frame, of any length; nothing outside the projection.
  [[nodiscard]] std::optional<Eigen::Vector3d> rayFromPixel(std::size_t i,
                                                            const Eigen::Vector2d& pixel) const;
  [[nodiscard]] std::optional<Eigen::Vector2d> pixelFromRay(std::size_t i, const Eigen::Vector3d& ray) const;
  /// The coordinate in which matches differ: u, or v if is_vertical.
  [[nodiscard]] Eigen::Index alongIndex() const { return is_vertical ? 1 : 0; }
  /// Disparity of a point at infinity: first minus second pixel, along the baseline; on the axis for
  /// equirectangular views.
  [[nodiscard]] double disparityAtInfinity() const {
    return views[0].axis_px[alongIndex()] - views[1].axis_px[alongIndex()];
  }
  /// The point, in the rectified frame of the first camera (metres), that the first view shows at a pixel and
  /// the second at pixel - disparity along the baseline. Nothing if the pixel has no ray or the point is at
  /// or beyond infinity.
  [[nodiscard]] std::optional<Eigen::Vector3d> pointFromDisparity(const Eigen::Vector2d& pixel,
                                                                  double disparity) const;

  /// 3x4 as OpenCV's P1 and P2: pixels of view `i` of points in the rectified frame at the first camera.
  /// @pre rectilinear
  [[nodiscard]] Eigen::Matrix<double, 3, 4> projectionMatrix(std::size_t i) const;
  /// 4x4 as OpenCV's Q: Q (u, v, disparity, 1) = w (x, y, z, 1). @pre rectilinear
  [[nodiscard]] Eigen::Matrix4d disparityToDepth() const;
  /// The camera of view `i`. @pre rectilinear
  [[nodiscard]] AnyCamera pinhole(std::size_t i) const;
};

struct RectificationRequest {
  ViewProjection projection = ViewProjection::kRectilinear;
  ViewExtent extent = ViewExtent::kSameScale;
  double horizontal_field_rad = 0;  ///< kFieldOfView: between the outer edges of the outer pixels
  std::optional<ImageSize> size = std::nullopt;  ///< of the output; empty: as the first camera
  /// Each view is centred on its own camera along the baseline, and a point at infinity has a disparity; for
  /// cameras that look towards each other. Otherwise, both have the same axis_px, and points at infinity have
  /// no disparity.
  bool has_own_centres = false;
};

/// Chooses the common orientation and the views of two cameras of a rig.
///
/// About the baseline, the orientation is the mean of both cameras (the least sum of squared changes of their
/// rotation matrices). kSameScale takes the mean focal length of both on their axes.
/// @throws Error (kUsage) as chooseView(), and for the same camera twice; Error (kInput) for cameras at one
/// place, if one camera would be turned too far (the rectified axis is more than kMaxTangentAngleRad from its
/// own in a rectilinear view: one camera in front of the other, or back to back), and as chooseView()
[[nodiscard]] Rectification rectify(const AnyRig& rig, std::size_t first, std::size_t second,
                                    const RectificationRequest& request);

/// Source pixels of view `i` in the camera's original images.
[[nodiscard]] RemapTable makeRemapTable(const Rectification& rectification, std::size_t i,
                                        const MountedCamera& camera, int num_jobs = 1,
                                        const CancelFlag* cancel = nullptr);

/// Distances of pixels of the same points from each other's epipolar curves.
struct EpipolarErrors {
  std::size_t num_pairs = 0;  ///< number of pairs in which both pixels have a ray
  /// RMS distance from the epipolar curve in the original images, px: to first order, the mean square of both
  /// images.
  double curve_rms_px = 0;
  std::size_t num_shown = 0;  ///< pairs that both rectified images show; the others have no row
  /// Difference of the rows (columns if is_vertical) in the rectified images, first minus second, px.
  double row_rms_px = 0;
  double row_mean_px = 0;
  double row_max_px = 0;  ///< of the absolute values
};

/// Pixels of one point in the original images of both cameras.
using EpipolarPair = std::array<Eigen::Vector2d, 2>;
[[nodiscard]] EpipolarErrors epipolarErrors(const Rectification& rectification, const MountedCamera& first,
                                            const MountedCamera& second, std::span<const EpipolarPair> pairs);

/// Text for cv::FileStorage (YAML): R1, R2, P1, P2, Q as cv::stereoRectify() returns them (the last three
/// only for rectilinear views), and projection, direction, image_width, image_height, scale_px, axis1, axis2,
/// baseline_m. Pixel (0, 0) is the centre of the top-left pixel.
[[nodiscard]] std::string rectificationFileText(const Rectification& rectification);

/// Writes the table for cv::remap(): TIFF files of 32-bit floats, one for x and one for y, in the pixels of
/// the original image; -10 where there is no source. @throws Error (kInput)
void writeRemapTable(const RemapTable& table, const std::string& x_path, const std::string& y_path);

}  // namespace alidade
