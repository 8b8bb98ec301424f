// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/report/report_data.h"

namespace alidade {

/// The image of a view by the name that the evidence has for it; nothing if there is none. Called from
/// several threads.
using ImageOfView = std::function<std::optional<GrayImage>(const std::string& image)>;

/// An image as a JPEG file of about at most this many bytes, smaller where that needs it, in a data URI.
[[nodiscard]] std::string pictureUri(const GrayImage& image, double most_bytes);

/// Each view's image as a small JPEG file in a data URI; empty for views without one, and for images of
/// another size than the camera's. The more views, the smaller the pictures: those of 50 views take 1.5 MB,
/// those of 1000 views 7 MB.
/// @param num_jobs  threads; 0: one per processor. The pictures do not depend on it.
[[nodiscard]] std::vector<std::string> viewPictures(const ReportData& data, const ImageOfView& image_of,
                                                    int num_jobs);

}  // namespace alidade
