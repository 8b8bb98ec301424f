// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/footage/follow/tracks.h"

namespace alidade {

/// Methods of tracking points from image to image.
enum class FrontEndKind : std::uint8_t {
  kFlow,       ///< optical flow: for videos, whose points move little from frame to frame
  kKeyPoints,  ///< descriptors: for photographs
};

/// Tracks points through a sequence of images.
class FrontEnd {
 public:
  virtual ~FrontEnd() = default;
  /// The points in an image, in ascending order of track. All images have one size.
  [[nodiscard]] virtual std::vector<TrackPixel> follow(const GrayImage& image) = 0;
};

inline constexpr std::size_t kUsualNumPoints = 400;

/// @param num_points  tracked at a time, spread over the image; up to twice as many key points are described
[[nodiscard]] std::unique_ptr<FrontEnd> makeFrontEnd(FrontEndKind kind,
                                                     std::size_t num_points = kUsualNumPoints);

namespace detail {

/// Optical flow: pyramidal Lucas-Kanade (Bouguet 2000) from frame to frame, then alignment with the patch of
/// the first frame that showed the point, in its current deformation, so that errors do not accumulate. A
/// point is dropped if its patch no longer matches. Cells of the image with too few points get new ones: the
/// best corners of the cell (Shi and Tomasi 1994).
[[nodiscard]] std::unique_ptr<FrontEnd> makeFlowTracker(std::size_t num_points);

/// Key points with descriptors (SIFT, Lowe 2004), matched between an image and those before it: the nearest
/// descriptor in either direction, clearly nearer than the second nearest. Motion between images may be
/// large. A matched point is then aligned with its patch in the first image of its track, with size and
/// direction as a first guess of the deformation. If that fails, it stays at its descriptor's position.
[[nodiscard]] std::unique_ptr<FrontEnd> makeKeyPointMatcher(std::size_t num_points);

}  // namespace detail
}  // namespace alidade
