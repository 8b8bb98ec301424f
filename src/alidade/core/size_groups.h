// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "alidade/core/image.h"

namespace alidade {

/// Division of images into those of the most frequent size and the rest; one camera has one image size.
struct SizeGroups {
  ImageSize size;                     ///< of the largest group
  std::vector<std::size_t> in_group;  ///< indices of the images of that size, rising
  std::vector<std::size_t> others;    ///< the rest, rising
};

/// @throws Error (kInput) if two sizes are equally frequent, with two or more images each
[[nodiscard]] SizeGroups groupBySize(std::span<const ImageSize> sizes);

/// For messages: "1280x720".
[[nodiscard]] std::string sizeText(ImageSize size);

}  // namespace alidade
