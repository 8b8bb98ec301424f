// SPDX-License-Identifier: MIT
#include "report_output.h"

#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/imagery/image_list.h"
#include "alidade/imagery/image_set.h"
#include "alidade/report/data/utf8.h"

namespace alidade {
namespace {

using nlohmann::json;

std::optional<GrayImage> readOrNone(const ImageSet& set, std::size_t i) {
  try {
    return set.read(i).decode().image;
  } catch (const Error&) {
    return std::nullopt;  // the page shows the corners instead
  }
}

// The images of an evidence document, each once; none for any other document, which is refused later.
std::set<std::string> viewNames(const json& evidence) {
  std::set<std::string> names;
  if (!evidence.is_object() || !evidence.contains("views") || !evidence["views"].is_array()) return names;
  for (const json& view : evidence["views"]) {
    if (view.is_object() && view.contains("image") && view["image"].is_string())
      names.insert(view["image"].get<std::string>());
  }
  return names;
}

}  // namespace

PictureSource picturesOf(const GivenViews& given, const PassingPictures& passing) {
  if (!given.image_set) return {};
  std::map<std::string, std::size_t> index_of;
  for (std::size_t i = 0; i < given.images.size(); ++i) index_of[validUtf8(given.images[i])] = i;
  const auto pathOf = [index_of, paths = given.paths](const std::string& name) -> std::string {
    const auto found = index_of.find(name);
    return found == index_of.end() ? "" : paths[found->second];
  };
  const ImageOfView image_of = [=, &passing,
                                set = *given.image_set](const std::string& name) -> std::optional<GrayImage> {
    if (std::optional<GrayImage> kept = passing.imageOf(pathOf(name))) return kept;
    const auto found = index_of.find(name);
    return found == index_of.end() ? std::nullopt : readOrNone(set, found->second);
  };
  return {.image_of = image_of,
          .picture_of = [=, &passing](const std::string& name) { return passing.pictureOf(pathOf(name)); }};
}

PictureSource picturesFrom(const json& evidence, const std::vector<std::string>& paths) {
  const std::vector<std::string> names = shortNames(paths);
  std::map<std::string, std::string> path_of;
  for (std::size_t i = 0; i < names.size(); ++i) path_of[validUtf8(names[i])] = paths[i];
  std::vector<std::string> images;
  std::map<std::string, std::size_t> index_of;
  for (const std::string& name : viewNames(evidence)) {
    const auto frame = parseFrameName(name);
    if (const auto file = path_of.find(name); file != path_of.end()) {
      index_of[name] = images.size();
      images.push_back(file->second);
    } else if (frame && path_of.contains(frame->video)) {
      index_of[name] = images.size();
      images.push_back(path_of[frame->video] + "@" + std::to_string(frame->number));
    }
  }
  return {
      .image_of = [index_of, set = openNamed(images)](const std::string& name) -> std::optional<GrayImage> {
        const auto found = index_of.find(name);
        return found == index_of.end() ? std::nullopt : readOrNone(set, found->second);
      },
      .picture_of = {}};
}

}  // namespace alidade
