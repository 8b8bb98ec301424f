// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "alidade/core/image.h"

namespace alidade {

/// An image for OpenCV, without a copy. It must not be written to: OpenCV has no read-only view.
[[nodiscard]] inline cv::Mat viewOf(const GrayImage& image) {
  return {image.size.height, image.size.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data())};
}

}  // namespace alidade
