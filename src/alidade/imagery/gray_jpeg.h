// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace alidade {

// Grey JPEG images by libjpeg alone, with the same pixels and bytes as cv::imdecode() and cv::imencode().

/// The grey levels of a JPEG file that is grey or in YCbCr, as nearly all are. Empty for any other file, and
/// if libjpeg has an error or a warning.
/// @param encoded  the file's bytes, as one row
/// @throws std::bad_alloc
[[nodiscard]] cv::Mat decodeGrayJpeg(const cv::Mat& encoded);

/// Encodes an image of one 8-bit channel. Returns false on an error.
/// @throws std::bad_alloc
[[nodiscard]] bool encodeGrayJpeg(const cv::Mat& image, int quality, std::vector<std::uint8_t>& encoded);

}  // namespace alidade
