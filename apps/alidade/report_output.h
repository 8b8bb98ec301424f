// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/figures/page_pictures.h"
#include "board_views.h"

namespace alidade {

/// The images in which boards were found, by their names in the evidence, in which bytes that are not UTF-8
/// are replaced. An image that cannot be read has no picture.
/// @param passing  pictures made while these images were searched; must outlive the source
[[nodiscard]] PictureSource picturesOf(const GivenViews& given, const PassingPictures& passing);

/// The same for images given again, by names in an evidence document.
/// @param paths  of images and videos
[[nodiscard]] PictureSource picturesFrom(const nlohmann::json& evidence,
                                         const std::vector<std::string>& paths);

}  // namespace alidade
