// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_frames.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

std::string stemOf(const std::string& image) {
  return std::filesystem::path(image).stem().string();
}

// The last run of digits without leading zeros; empty without digits.
std::string numberOf(const std::string& image) {
  constexpr const char* kDigits = "0123456789";
  const std::string stem = stemOf(image);
  const std::size_t last = stem.find_last_of(kDigits);
  if (last == std::string::npos) return {};
  const std::size_t before = stem.find_last_not_of(kDigits, last);
  const std::string digits = stem.substr(before == std::string::npos ? 0 : before + 1, last - before);
  const std::size_t first = digits.find_first_not_of('0');
  return first == std::string::npos ? "0" : digits.substr(first);
}

bool shareStems(std::span<const RigViews> cameras) {
  std::map<std::string, std::size_t> camera_of;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (const View& view : cameras[c].views) {
      const auto [entry, is_new] = camera_of.try_emplace(stemOf(view.image), c);
      if (!is_new && entry->second != c) return true;
    }
  }
  return false;
}

}  // namespace

RigFrames matchFrames(std::span<const RigViews> cameras) {
  const bool by_stem = shareStems(cameras);
  std::vector<std::vector<std::string>> keys(cameras.size());
  std::set<std::string> all;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    std::map<std::string, std::string> image_of;
    for (const View& view : cameras[c].views) {
      const std::string key = by_stem ? stemOf(view.image) : numberOf(view.image);
      if (key.empty()) {
        throw inputError({.where = cameras[c].name + ": " + view.image,
                          .found = "no number in the name, and no other camera has an image of this name",
                          .expected = "images taken together have the same name or the same number"});
      }
      const auto [entry, is_new] = image_of.try_emplace(key, view.image);
      if (!is_new && entry->second != view.image) {
        throw inputError(
            {.where = cameras[c].name + ": " + view.image,
             .found = "the same " + std::string(by_stem ? "name" : "number") + " as " + entry->second,
             .expected = "one image of a camera for each frame"});
      }
      keys[c].push_back(key);
      all.insert(key);
    }
  }
  RigFrames frames{.names = {all.begin(), all.end()}, .frame_of = {}};
  std::sort(frames.names.begin(), frames.names.end(), naturalLess);
  std::map<std::string, std::size_t> index_of;
  for (std::size_t f = 0; f < frames.names.size(); ++f) index_of[frames.names[f]] = f;
  for (const std::vector<std::string>& of_camera : keys) {
    std::vector<std::size_t>& indices = frames.frame_of.emplace_back();
    for (const std::string& key : of_camera) indices.push_back(index_of[key]);
  }
  return frames;
}

}  // namespace alidade
