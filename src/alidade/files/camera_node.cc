// SPDX-License-Identifier: MIT
#include "alidade/files/camera_node.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "alidade/core/text.h"

namespace alidade::detail {

ImageSize readImageSize(const YamlNode& node) {
  node.allowKeys({"width", "height"});
  const auto side = [&](const char* key) {
    const YamlNode value = node.at(key);
    constexpr int kMaxSide = 1'000'000;
    const int pixels = value.integer();
    if (pixels < 1 || pixels > kMaxSide) throw value.error(std::to_string(pixels), "1 to 1000000 pixels");
    return pixels;
  };
  const ImageSize size{.width = side("width"), .height = side("height")};
  constexpr std::int64_t kMaxPixels = std::int64_t{1} << 30U;
  if (std::int64_t{size.width} * size.height > kMaxPixels) {
    throw node.error(std::to_string(size.width) + "x" + std::to_string(size.height) + " pixels",
                     "at most " + std::to_string(kMaxPixels) + " pixels in total");
  }
  return size;
}

void allowParameters(const YamlNode& map, std::span<const std::string_view> names) {
  const std::set<std::string> keys = [&map] {
    if (!map.isMap()) return std::set<std::string>{};
    const std::vector<std::string> all = map.keys();
    return std::set<std::string>(all.begin(), all.end());
  }();
  std::string own;
  std::string other;
  for (const std::string& id : modelIds()) {
    const auto theirs = parameterNames(id);
    if (std::equal(theirs.begin(), theirs.end(), names.begin(), names.end())) {
      own = id;
    } else if (std::set<std::string>(theirs.begin(), theirs.end()) == keys) {
      other = id;
    }
  }
  if (!other.empty()) {
    throw map.error(
        "the keys of the model " + other + ": " +
            join(std::vector<std::string>(keys.begin(), keys.end()), ", "),
        "the keys of " + own + ": " + join(std::vector<std::string>(names.begin(), names.end()), ", "),
        "if only the model name was changed, change it back to " + other +
            "; to fit another model, run: alidade convert --model " + own);
  }
  map.allowKeys({names.begin(), names.end()});
}

AnyCamera readCamera(const YamlNode& root) {
  const YamlNode model = root.at("model");
  const std::string id = model.text();
  if (std::find(modelIds().begin(), modelIds().end(), id) == modelIds().end()) {
    throw model.error("unknown camera model '" + id + "'", "one of " + join(modelIds(), ", "),
                      didYouMean(id, modelIds()));
  }
  const YamlNode parameters = root.at("parameters");
  allowParameters(parameters, parameterNames(id));
  const std::vector<std::string> names = [&] {
    const auto all = parameterNames(id);
    return std::vector<std::string>(all.begin(), all.end());
  }();
  std::vector<double> values;
  for (const std::string& name : names) values.push_back(parameters.at(name).number());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (const auto complaint = parameterComplaint(id, i, values[i]))
      throw parameters.at(names[i]).error(exactText(values[i]), *complaint);
  }
  return AnyCamera::make(id, values);
}

}  // namespace alidade::detail
