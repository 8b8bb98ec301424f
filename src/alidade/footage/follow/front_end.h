// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/footage/follow/tracks.h"

namespace alidade {

/// Methods of tracking points from image to image.
enum class FrontEndKind : std::uint8_t {
  kFlow,       ///< optical flow: for videos, whose points move little from frame to frame
  kKeyPoints,  ///< descriptors: for photographs
};

struct FrontEndOptions {
  FrontEndKind kind = FrontEndKind::kFlow;
  std::size_t num_points =
      400;  ///< tracked at a time, spread over the image; up to twice as many key points are described
};

/// Tracks points through a sequence of images.
class FrontEnd {
 public:
  virtual ~FrontEnd() = default;
  /// The points in an image, in ascending order of track. All images have one size.
  [[nodiscard]] virtual std::vector<TrackPixel> follow(const GrayImage& image) = 0;
};

[[nodiscard]] std::unique_ptr<FrontEnd> makeFrontEnd(const FrontEndOptions& options);

}  // namespace alidade
