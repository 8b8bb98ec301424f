// SPDX-License-Identifier: MIT
#include "alidade/core/size_groups.h"

#include <algorithm>

namespace alidade {

SizeGroups groupBySize(std::span<const ImageSize> sizes) {
  SizeGroups groups;
  std::ptrdiff_t best = 0;
  for (const ImageSize& size : sizes) {
    const auto count = std::count(sizes.begin(), sizes.end(), size);
    if (count > best) {
      best = count;
      groups.size = size;
    }
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    (sizes[i] == groups.size ? groups.in_group : groups.others).push_back(i);
  }
  return groups;
}

std::string sizeText(ImageSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace alidade
