// SPDX-License-Identifier: MIT
#include "alidade/core/size_groups.h"

#include <algorithm>
#include <map>
#include <utility>

#include "alidade/core/error.h"

namespace alidade {

SizeGroups groupBySize(std::span<const ImageSize> sizes) {
  SizeGroups groups;
  std::map<std::pair<int, int>, std::size_t> counts;
  for (const ImageSize& size : sizes) ++counts[{size.width, size.height}];
  const auto count = [&](const ImageSize& size) { return counts.at({size.width, size.height}); };
  const auto largest = std::ranges::max_element(sizes, {}, count);  // the first of equal groups
  if (largest != sizes.end()) groups.size = *largest;
  for (const auto& [side, number] : counts) {
    const ImageSize other{.width = side.first, .height = side.second};
    if (number < 2 || number < count(groups.size) || other == groups.size) continue;
    throw inputError({.where = "images of two sizes",
                      .found = std::to_string(number) + " of " + sizeText(groups.size) + " and " +
                               std::to_string(number) + " of " + sizeText(other),
                      .expected = "images of one camera, most of which have one size",
                      .next_step = "give the images of each size separately"});
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
