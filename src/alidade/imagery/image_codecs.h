// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/imgcodecs.hpp>

namespace alidade {

// OpenCV's image codecs. Their library depends on GDAL and a hundred others, which take longer to load than
// the rest of the program, so it is loaded with the first image that gray_jpeg.h cannot read or write.

/// Flags of cv::imdecode(): one channel, converted to grey if necessary, as deep as stored, and not turned.
inline constexpr int kGrayFlags = cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION;

/// cv::imdecode(). @throws cv::Exception; Error (kInput) if the library cannot be loaded
[[nodiscard]] cv::Mat decodeImage(const cv::Mat& encoded, int flags);

/// cv::imencode(): `extension` with its dot. @throws as decodeImage()
bool encodeImage(const std::string& extension, const cv::Mat& image, std::vector<std::uint8_t>& encoded,
                 const std::vector<int>& options = {});

}  // namespace alidade
