// SPDX-License-Identifier: MIT
#include "alidade/core/size_groups.h"

#include <algorithm>

namespace alidade {

SizeGroups groupBySize(std::span<const ImageSize> sizes) {
  SizeGroups groups;
  const auto count = [&](const ImageSize& size) { return std::count(sizes.begin(), sizes.end(), size); };
  const auto largest = std::ranges::max_element(sizes, {}, count);  // the first among equals
  if (largest != sizes.end()) groups.size = *largest;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    (sizes[i] == groups.size ? groups.in_group : groups.others).push_back(i);
  }
  return groups;
}

std::string sizeText(ImageSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace alidade
