// SPDX-License-Identifier: MIT
#include "alidade/files/formats/lens_layout.h"

#include <algorithm>

#include "alidade/core/text.h"

namespace alidade::detail {

std::vector<std::string> listedNames(const LensLayout& layout) {
  const auto parts = split(layout.order, ' ');
  return {parts.begin(), parts.end()};
}

const LensLayout* findLayout(std::span<const LensLayout> layouts, std::string_view name) {
  const auto found = std::find_if(layouts.begin(), layouts.end(),
                                  [name](const LensLayout& layout) { return layout.name == name; });
  return found == layouts.end() ? nullptr : &*found;
}

const LensLayout& layoutOf(std::span<const LensLayout> layouts, std::string_view model) {
  const auto found = std::find_if(layouts.begin(), layouts.end(),
                                  [model](const LensLayout& layout) { return layout.model == model; });
  expect(found != layouts.end(), "the format has a layout for each of its models");
  return *found;
}

std::vector<StatedNumber> storageOrder(const LensLayout& layout, std::span<const StatedNumber> listed) {
  const auto names = split(layout.order, ' ');
  std::vector<StatedNumber> parameters;
  for (const std::string_view name : parameterNames(layout.model)) {
    const auto found = std::find_if(names.begin(), names.end(), [name](std::string_view listed_name) {
      return listed_name == name || (listed_name == "f" && (name == "fx" || name == "fy"));
    });
    parameters.push_back(found == names.end() ? StatedNumber{}
                                              : listed[static_cast<std::size_t>(found - names.begin())]);
  }
  return parameters;
}

std::vector<double> listedOrder(const LensLayout& layout, const AnyCamera& camera, double origin) {
  const auto names = camera.parameterNames();
  std::vector<double> listed;
  for (const std::string_view name : split(layout.order, ' ')) {
    const auto index = std::find(names.begin(), names.end(), name) - names.begin();
    listed.push_back(camera.parameters()[static_cast<std::size_t>(index)]);
    if (name == "cx" || name == "cy") listed.back() += origin;
  }
  return listed;
}

void takeOrigin(std::span<StatedNumber> parameters, double origin) {
  parameters[2].value -= origin;
  parameters[3].value -= origin;
}

}  // namespace alidade::detail
