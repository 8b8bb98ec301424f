// SPDX-License-Identifier: MIT
#include "alidade/files/formats/small_format.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade::detail {
namespace small_format {

constexpr std::size_t kMaxPlaces = 1000;

// A camera of a file: its name, and the map where its paths start.
struct Place {
  std::string name;
  YamlNode map;
};

// The text that the pattern's '*' or '#' stands for ("" if it has none), or nothing if the key does not
// match.
std::optional<std::string> matchOf(std::string_view key, std::string_view pattern) {
  const std::size_t at = pattern.find_first_of("*#");
  if (at == std::string_view::npos) return key == pattern ? std::optional<std::string>("") : std::nullopt;
  const std::string_view after = pattern.substr(at + 1);
  if (key.size() <= at + after.size() || !key.starts_with(pattern.substr(0, at)) || !key.ends_with(after))
    return std::nullopt;
  const std::string_view match = key.substr(at, key.size() - at - after.size());
  const bool is_allowed =
      pattern[at] == '*' || match.find_first_not_of("0123456789") == std::string_view::npos;
  return is_allowed ? std::optional<std::string>(match) : std::nullopt;
}

std::string named(std::string_view part, const std::string& name) {
  std::string key(part);
  if (const std::size_t at = key.find('*'); at != std::string::npos) key.replace(at, 1, name);
  return key;
}

// The value of a key of which '~' at the end stands for any text.
std::optional<YamlNode> findKey(const YamlNode& map, std::string key) {
  if (!key.ends_with('~') || !map.isMap()) return map.find(key);
  key.pop_back();
  for (const std::string& other : map.keys())
    if (other.starts_with(key)) return map.at(other);
  return std::nullopt;
}

std::optional<YamlNode> findPath(const Place& place, const YamlNode& root, std::string_view path) {
  for (std::string_view alternative : split(path, '|')) {
    const bool is_at_root = alternative.starts_with('/');
    std::optional<YamlNode> node = is_at_root ? root : place.map;
    for (const std::string_view part : split(is_at_root ? alternative.substr(1) : alternative, '.')) {
      if (node) node = findKey(*node, named(part, place.name));
    }
    if (node && !node->isNull()) return node;
  }
  return std::nullopt;
}

// A path without its prefix and '?'.
struct Path {
  std::string_view keys;
  std::string_view kind;  // "K=", "P=" or empty

  explicit Path(std::string_view text) : keys(text) {
    if (keys.ends_with('?')) keys.remove_suffix(1);
    if (keys.size() > 2 && keys[1] == '=') {
      kind = keys.substr(0, 2);
      keys.remove_prefix(2);
    }
  }
};

// The value at a path, which only may be missing if it ends in '?'.
std::optional<YamlNode> valueAt(const Place& place, const YamlNode& root, std::string_view path) {
  const std::string_view keys = Path(path).keys;
  auto node = findPath(place, root, keys);
  if (node || path.ends_with('?')) return node;
  const std::string key = "'" + named(keys.substr(0, keys.find('|')), place.name) + "'";
  throw place.map.error("no key " + key, key + " in addition to " + join(place.map.keys(), ", "), "add it");
}

bool isMarked(const SmallFormat& format, const Place& place, const YamlNode& root) {
  return std::ranges::all_of(words(format.marks), [&](const std::string& mark) {
    const bool is_absent = mark.starts_with('!');
    return findPath(place, root, std::string_view(mark).substr(is_absent ? 1 : 0)).has_value() != is_absent;
  });
}

// All places that the patterns match.
std::vector<Place> placesOf(const SmallFormat& format, const YamlNode& root) {
  std::vector<Place> all;
  for (const std::string& pattern : words(format.cameras)) {
    std::vector<Place> places = {{"", root}};
    const std::string_view keys = pattern == "." ? std::string_view() : std::string_view(pattern);
    for (const std::string_view part : split(keys, '.')) {
      std::vector<Place> next;
      for (const Place& place : places) {
        if (place.map.isSequence() && (part == "*" || part == "0")) {
          for (const YamlNode& item : place.map.items())
            if (part == "*" || next.empty()) next.push_back({"", item});
        } else if (place.map.isMap()) {
          for (const std::string& key : place.map.keys())
            if (const auto match = matchOf(key, part))
              next.push_back({format.is_flat ? *match : key, place.map.at(key)});
        }
      }
      if (next.size() + all.size() > kMaxPlaces)
        throw root.error("more than " + std::to_string(kMaxPlaces) + " places for cameras", "fewer");
      if (!part.empty()) places = std::move(next);
    }
    for (const Place& place : places) all.push_back({place.name, format.is_flat ? root : place.map});
  }
  return all;
}

// A pinhole's fx fy cx cy from the left of a 3x4 matrix K [R t] whose R is the identity.
std::vector<StatedNumber> pinholeOf(const YamlNode& projection) {
  const std::vector<StatedNumber> P = statedNumbers(projection, 12);
  if (P[1].value != 0 || P[4].value != 0 || P[8].value != 0 || P[9].value != 0 || P[10].value != 1)
    throw projection.error("a projection with skew or a rotation", "fx 0 cx tx, 0 fy cy ty, 0 0 1 tz");
  return {P[0], P[5], P[2], P[6]};
}

std::vector<StatedNumber> numbersAt(const YamlNode& node, std::string_view kind) {
  if (kind == "K=") return readCameraMatrix(node);
  if (kind == "P=") return pinholeOf(node);
  if (!node.isScalar()) return statedNumbers(node);
  const std::vector<std::string> texts = words(node.text());
  if (texts.size() < 2) return {statedNumber(node)};
  std::vector<StatedNumber> numbers;
  for (const std::string& text : texts) {
    const auto number = parseDouble(text);
    if (!number || !std::isfinite(*number)) throw node.error("'" + text + "'", "finite numbers");
    numbers.push_back({*number});
  }
  return numbers;
}

// The lens that the file names.
const SmallLens& lensOf(const SmallFormat& format, const Place& place, const YamlNode& root) {
  if (format.model.empty()) return format.lenses.front();
  std::string name;
  std::optional<YamlNode> stated;
  for (const std::string& path : words(format.model)) {
    const auto node = findPath(place, root, path);
    if (!name.empty() || stated) name += "+";
    if (node) name += node->text();
    if (node) stated = node;
  }
  std::vector<std::string> all;
  for (const SmallLens& lens : format.lenses) {
    for (const std::string_view known : split(lens.name, '|')) {
      if (known == name) return lens;
      if (!known.empty()) all.emplace_back(known);
    }
  }
  if (!stated) stated = valueAt(place, root, words(format.model).front());  // reports that it is missing
  throw UnsupportedCamera(
      stated->error("the lens '" + name + "'", join(all, ", "),
                    didYouMean(name, all, "use one of these lenses in the program that wrote it")));
}

std::optional<ImageSize> sizeOf(const SmallFormat& format, const Place& place, const YamlNode& root) {
  std::vector<YamlNode> sides;
  for (const std::string& path : words(format.size)) {
    const auto node = valueAt(place, root, path);
    if (!node) return std::nullopt;
    sides.push_back(*node);
  }
  if (sides.empty()) return std::nullopt;
  return sides.size() == 1 ? readSize(sides[0]) : readSize(sides[0], sides[1]);
}

// Converts the focal lengths and the principal point to pixels.
void takeUnit(const SmallFormat& format, const YamlNode& place, const std::optional<ImageSize>& size,
              std::span<StatedNumber> p) {
  const bool is_below_1 = p[2].value < 1 && p[3].value < 1;
  if (format.unit == SmallUnit::kPixels || (format.unit == SmallUnit::kSidesIfBelow1 && !is_below_1))
    return takeOrigin(p, format.origin);
  if (!size) {
    throw place.error("numbers relative to the image size, which the file does not state", "the image size",
                      "add --image-size WIDTHxHEIGHT");
  }
  const bool is_long = format.unit == SmallUnit::kLongSide;
  const bool is_central = is_long || format.unit == SmallUnit::kFromCentre;
  const std::array<double, 2> sides = {static_cast<double>(size->width), static_cast<double>(size->height)};
  const double longest = std::max(sides[0], sides[1]);
  for (std::size_t i = 0; i < 2; ++i) {
    const double unit = is_long ? longest : is_central ? 1 : sides[i];
    p[i].value *= unit;
    p[i + 2].value = p[i + 2].value * unit + (is_central ? 0.5 * sides[i] : 0) - 0.5;
  }
}

// The parameters that the file lists, in Alidade's order.
std::vector<StatedNumber> parametersOf(const SmallLens& lens, const std::vector<std::string>& order,
                                       std::vector<StatedNumber> listed, const YamlNode& last) {
  const bool may_end_early = lens.paths.ends_with('?');
  if (listed.size() > order.size() || (listed.size() < order.size() && !may_end_early)) {
    throw last.error(std::to_string(listed.size()) + " numbers of the lens",
                     std::to_string(order.size()) + ": " + join(order, " "));
  }
  listed.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i] == "0" && listed[i].value != 0)
      throw UnsupportedCamera(last.error(exactText(listed[i].value) + " as number " + std::to_string(i + 1) +
                                             " of the lens '" + std::string(lens.name) + "'",
                                         "0: such lenses are not supported",
                                         "calibrate again without this term"));
  }
  return storageOrder({.name = lens.name, .model = lens.model, .order = lens.order}, listed);
}

StatedCamera readOne(const SmallFormat& format, const Place& place, const YamlNode& root,
                     const ReadOptions& options) {
  const SmallLens& lens = lensOf(format, place, root);
  const auto size = sizeOf(format, place, root);
  std::vector<StatedNumber> listed;
  std::optional<YamlNode> last;
  for (const std::string& text : words(lens.paths)) {
    const auto node = valueAt(place, root, text);
    if (node) {
      append(listed, numbersAt(*node, Path(text).kind));
      last = node;
    } else if (!lens.model.starts_with("opencv") && !lens.paths.ends_with(text)) {
      listed.push_back({});
    }
  }
  const std::vector<std::string> order = words(lens.order);
  std::string model(lens.model);
  std::vector<StatedNumber> parameters;
  if (model.starts_with("opencv")) {
    if (listed.size() < order.size())
      throw last->error(std::to_string(listed.size()) + " numbers of the lens", join(order, " "));
    const auto end = listed.begin() + static_cast<std::ptrdiff_t>(order.size());
    std::vector<StatedNumber> coefficients(end, listed.end());
    const std::string stated = model == "opencv" ? "radtan" : options.model;
    listed.erase(end, listed.end());
    parameters = parametersOf({.name = "", .model = "pinhole", .order = lens.order, .paths = ""}, order,
                              listed, *last);
    model = openCvModel(*last, parameters, coefficients, stated);
    append(parameters, coefficients);
  } else {
    if (lens.convert != nullptr) lens.convert(listed);
    parameters = parametersOf(lens, order, std::move(listed), *last);
  }
  takeUnit(format, *last, size ? size : options.image_size, parameters);
  return stateCamera(last->where(), model, parameters, size);
}

SE3 poseAt(const SmallFormat& format, const std::vector<YamlNode>& nodes, std::vector<Remark>& remarks) {
  SE3 pose;
  if (format.pose.starts_with("P=")) {
    const std::vector<StatedNumber> P = statedNumbers(nodes[0], 12);
    const double z = P[11].value;
    pose.translation = {(P[3].value - P[2].value * z) / P[0].value,
                        (P[7].value - P[6].value * z) / P[5].value, z};
  } else if (nodes.size() == 1) {
    pose = readMotion(nodes[0], remarks);
  } else {
    const std::vector<StatedNumber> r = statedNumbers(nodes[0]);
    const auto quaternion = [&] {
      return withPlace(nodes[0].where(), [&r] {
        return SO3::fromQuaternion({r[3].value, r[0].value, r[1].value, r[2].value});
      });
    };
    pose = {r.size() == 3   ? SO3::exp(readVector(nodes[0]))
            : r.size() == 4 ? quaternion()
                            : readRotation(nodes[0], remarks),
            readVector(nodes[1])};
  }
  return format.is_rig_from_camera ? pose.inverse() : pose;
}

// The poses, or none if a camera has none.
std::vector<SE3> posesOf(const SmallFormat& format, const std::vector<Place>& places, const YamlNode& root,
                         std::vector<Remark>& remarks) {
  std::vector<SE3> poses;
  for (const Place& place : places) {
    std::vector<YamlNode> nodes;
    for (const std::string& path : words(format.pose)) {
      const auto node = findPath(place, root, Path(path).keys);
      if (!node) return {};
      nodes.push_back(*node);
    }
    poses.push_back(poseAt(format, nodes, remarks));
    constexpr double kLongBaseline = 5;  // m
    const double length = (poses.back() * poses.front().inverse()).translation.norm();
    if (length > kLongBaseline) {
      remarks.push_back(
          {"assumed", nodes.back().where() + ": taken as metres, " + numberText("%.4g", length) +
                          " m from the first camera; many programs write the unit of their board"});
    }
  }
  return poses;
}

// Adds remarks about keys of the map that no path or pattern begins with, and about others that are not read.
void remarkKeys(const SmallFormat& format, const YamlNode& map, const std::vector<std::string>& paths,
                StatedCamera& camera) {
  std::vector<std::string> known = map.keys();
  std::erase_if(known, [&paths](const std::string& key) {
    return std::ranges::none_of(paths, [&key](const std::string& path) {
      return std::ranges::any_of(split(Path(path).keys, '|'), [&key](std::string_view alternative) {
        if (alternative.starts_with('/')) alternative.remove_prefix(1);
        return matchOf(key, alternative.substr(0, alternative.find('.'))).has_value();
      });
    });
  });
  remarkUnknownKeys(map, known, camera);
  remarkNotCarried(map, words(format.not_carried), camera);
}

void remarkOthers(const SmallFormat& format, const YamlNode& root, const YamlNode& map,
                  StatedCamera& camera) {
  std::vector<std::string> paths;
  for (const std::string_view more :
       {format.size, format.model, format.pose, format.name, format.known, format.not_carried})
    for (std::string& path : words(more)) paths.push_back(std::move(path));
  for (const SmallLens& lens : format.lenses)
    for (std::string& path : words(lens.paths)) paths.push_back(std::move(path));
  remarkKeys(format, map, paths, camera);
  if (camera.number != 0 || !root.isMap() || map.node().is(root.node())) return;
  for (std::string& pattern : words(format.cameras)) paths.push_back(std::move(pattern));
  remarkKeys(format, root, paths, camera);
}

}  // namespace small_format

std::vector<std::string_view> modelsOf(const SmallLens& lens) {
  if (!lens.model.starts_with("opencv")) return {lens.model};
  return {openCvModels().begin(), openCvModels().end()};
}

bool recognisesSmall(const SmallFormat& format, const CameraDocument& document) {
  using namespace small_format;
  if (!document.isTree()) return false;
  try {
    const YamlNode& root = document.root();
    return std::ranges::any_of(placesOf(format, root), [&](const Place& place) {
      return place.map.isMap() && isMarked(format, place, root);
    });
  } catch (const Error&) {
    return false;  // too many, or a key that is no text
  }
}

CameraSource readSmall(const SmallFormat& format, const CameraDocument& document,
                       const ReadOptions& options) {
  using namespace small_format;
  const YamlNode& root = document.root();
  std::vector<Place> places = placesOf(format, root);
  std::vector<Place> others;
  std::erase_if(places, [&](const Place& place) {
    const bool is_camera = place.map.isMap() && isMarked(format, place, root);
    if (!is_camera) others.push_back(place);
    return !is_camera;
  });
  CameraSource all;
  for (const Place& place : places) {
    const auto named = format.name.empty() ? std::nullopt : findPath(place, root, format.name);
    all.add(named ? named->text() : place.name, [&] { return readOne(format, place, root, options); });
  }
  for (StatedCamera& camera : all.cameras) remarkOthers(format, root, places[camera.number].map, camera);
  const std::vector<std::string> patterns = words(format.cameras);
  const bool is_any_map = std::ranges::find(patterns, "*") != patterns.end();
  for (const Place& other : others) {
    if (!all.cameras.empty() && !is_any_map && other.map.isMap())
      all.cameras.front().remarks.push_back(
          {"not_carried", other.map.where() + ": not a calibrated camera, so it is ignored"});
  }
  if (!format.pose.empty())
    statePoses(all, [&](std::vector<Remark>& remarks) { return posesOf(format, places, root, remarks); });
  if (format.finish != nullptr) format.finish(root, options, all);
  return all;
}

}  // namespace alidade::detail
