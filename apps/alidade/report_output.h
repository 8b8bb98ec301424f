// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/figures/page_pictures.h"
#include "board_views.h"

namespace alidade {

/// The images that boards were found in, by the names that the evidence has for them, in which bytes that are
/// not UTF-8 are replaced. An image that cannot be read has no picture.
/// @param passing  pictures made while these images were searched; outlives the source
[[nodiscard]] PictureSource picturesOf(const GivenViews& given, const PassingPictures& passing);

/// The same for images that are given again, by names of an evidence document.
/// @param paths  of images and videos
[[nodiscard]] PictureSource picturesFrom(const nlohmann::json& evidence,
                                         const std::vector<std::string>& paths);

}  // namespace alidade
