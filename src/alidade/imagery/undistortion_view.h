// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/camera/any_camera.h"
#include "alidade/imagery/output_view.h"

namespace alidade {

/// Part of the source that a view shows.
enum class ViewExtent {
  kSameScale,    ///< the focal length on the axis and the position of the axis in the image, as in the source
  kFieldOfView,  ///< a given horizontal field, with the axis in the centre
  kValid,        ///< as much as fits without a pixel that has no source
  kAll,          ///< every source pixel that has a ray, as large as fits
};

struct ViewRequest {
  ViewProjection projection = ViewProjection::kRectilinear;
  ViewExtent extent = ViewExtent::kSameScale;
  double horizontal_field_rad = 0;  ///< kFieldOfView: between the outer edges of the outer pixels
  std::optional<ImageSize> size = std::nullopt;  ///< of the output; none: as the source, or the first of two
  /// Only rectify(): each view is centred on its own camera along the baseline, and a point at infinity has a
  /// disparity; for cameras that look towards each other. Otherwise, both have the same axis_px, and points
  /// at infinity have no disparity.
  bool has_own_centres = false;
};

struct ViewChoice {
  OutputView view;
  /// kAll: share of the source pixels with a ray that lie beyond kMaxTangentAngleRad and are not shown, in
  /// [0, 1].
  double cut_share = 0;
  /// kValid: kMaxTangentAngleRad or the end of the projection limits the view, not the source.
  bool is_limited_by_projection = false;
};

/// Chooses the view of a camera's images without distortion.
///
/// Only kSameScale keeps unequal focal lengths, and only in a rectilinear view; everything else has square
/// pixels. With a different size, it keeps the horizontal field, and height is added or cut equally at top
/// and bottom. kValid looks for the largest window, wherever its centre is, whose pixels all lie between the
/// centres of the source's outer pixels, along the lines from its centre to its border pixels. kAll shows the
/// centres of pixels.
///
/// @throws Error (kUsage) for a field or size out of range: at most 150 degrees for a rectilinear view, 360
/// otherwise, sides of 2 to kMaxRemapSide pixels; Error (kInput) if the source has longer sides, the camera
/// does not see its own axis (kSameScale, with no focal length there) or the middle of its image (kValid), or
/// no pixel has a ray (kAll).
[[nodiscard]] ViewChoice chooseView(const AnyCamera& camera, ImageSize source_size,
                                    const ViewRequest& request);

/// The camera of a rectilinear view: a pinhole camera.
[[nodiscard]] AnyCamera pinholeOf(const OutputView& view);

}  // namespace alidade
