// SPDX-License-Identifier: MIT
#include "alidade/files/formats/small_format.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>
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

std::string named(std::string_view part, const SmallPlace& place) {
  std::string key(part);
  for (const auto& [sign, name] : {std::pair('~', place.first), std::pair('*', place.name)})
    if (const std::size_t at = key.find(sign); at != std::string::npos) key.replace(at, 1, name);
  return key;
}

// A path without its prefix and '?'.
struct Path {
  std::string_view keys;
  std::string_view kind;  // "L=", "K=", "P=" or empty

  explicit Path(std::string_view text) : keys(text) {
    if (keys.ends_with('?')) keys.remove_suffix(1);
    if (keys.size() > 2 && keys[1] == '=') {
      kind = keys.substr(0, 2);
      keys.remove_prefix(2);
    }
  }
};

std::vector<std::string> alternativesOf(std::string_view paths) {
  std::vector<std::string> all;
  for (const std::string& path : words(paths))
    for (const std::string_view alternative : split(Path(path).keys, '|')) all.emplace_back(alternative);
  return all;
}

// The values of all alternatives that are there.
std::vector<YamlNode> findAll(const SmallPlace& place, const YamlNode& root, std::string_view path) {
  std::vector<YamlNode> all;
  for (const std::string& alternative : alternativesOf(path)) {
    const bool is_at_root = alternative.starts_with('/');
    std::optional<YamlNode> node = is_at_root ? root : place.map;
    for (const std::string_view part : split(std::string_view(alternative).substr(is_at_root ? 1 : 0), '.'))
      if (node) node = node->find(named(part, place));
    if (node && !node->isNull()) all.push_back(*node);
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
  if (kind.empty()) return {statedNumber(node)};
  if (kind == "K=") return readCameraMatrix(node);
  if (kind == "P=") return pinholeOf(node);
  if (!node.isScalar()) return statedNumbers(node);
  std::vector<StatedNumber> numbers;
  for (const std::string& text : words(node.text())) {
    const auto number = parseDouble(text);
    if (!number || !std::isfinite(*number)) throw node.error("'" + text + "'", "finite numbers");
    numbers.push_back({*number});
  }
  return numbers;
}

[[noreturn]] void refuseOther(const YamlNode& first, const YamlNode& other) {
  throw other.error("a value that differs from " + first.where(), "only one of them, or equal values",
                    "remove the wrong one");
}

// The value at a path, whose alternatives must agree.
std::optional<YamlNode> findPath(const SmallPlace& place, const YamlNode& root, std::string_view path) {
  const std::vector<YamlNode> all = findAll(place, root, path);
  if (all.empty()) return std::nullopt;
  const auto isSame = [&first = all.front()](const YamlNode& other) {
    if (first.isScalar() && other.isScalar() && first.text() == other.text()) return true;
    try {
      return isSameStated(numbersAt(first, "L="), numbersAt(other, "L="));
    } catch (const Error&) {
      return false;  // a text
    }
  };
  for (const YamlNode& other : std::span(all).subspan(1))
    if (!isSame(other)) refuseOther(all.front(), other);
  return all.front();
}

// The same; it only may be missing if the path ends in '?'.
std::optional<YamlNode> valueAt(const SmallPlace& place, const YamlNode& root, std::string_view path) {
  auto node = findPath(place, root, path);
  if (node || path.ends_with('?')) return node;
  const std::string key = "'" + named(alternativesOf(path).front(), place) + "'";
  throw place.map.error("no key " + key, key + " in addition to " + join(place.map.keys(), ", "), "add it");
}

bool isMarked(const SmallFormat& format, const SmallPlace& place, const YamlNode& root) {
  return std::ranges::all_of(words(format.marks), [&](const std::string& mark) {
    const bool is_absent = mark.starts_with('!');
    return findAll(place, root, std::string_view(mark).substr(is_absent ? 1 : 0)).empty() == is_absent;
  });
}

// Programs write zeros or nothing for a camera that is not calibrated.
bool isCalibrated(const SmallFormat& format, const SmallPlace& place, const YamlNode& root) {
  return std::ranges::none_of(words(format.lenses.front().paths), [&](const std::string& path) {
    const auto matrix = Path(path).kind == "K=" ? findPath(place, root, path) : std::nullopt;
    return matrix && saysNothing(*matrix);
  });
}

// Adds the places below one that a part of a pattern matches.
void addPlaces(const SmallFormat& format, const SmallPlace& place, std::string_view part,
               std::vector<SmallPlace>& next) {
  const auto add = [&](const std::string& name, const YamlNode& map) {
    if (next.size() == kMaxPlaces)
      throw map.error("more than " + std::to_string(kMaxPlaces) + " places for cameras", "fewer");
    next.push_back({name, map});
  };
  if (place.map.isSequence() && (part == "*" || part == "0")) {
    const std::vector<YamlNode> items = place.map.items(part == "0" ? 1 : kMaxPlaces + 1);
    const bool is_named = part == "*" && !items.empty() && items.front().isScalar();
    for (const YamlNode& item : items) add(is_named ? items.front().text() : "", item);
  } else if (part.ends_with('+')) {
    part.remove_suffix(1);
    const auto value = place.map.find(std::string(part));
    if (!value) return;
    std::vector<YamlNode> items = {*value};
    if (value->isSequence()) items = value->items(kMaxPlaces + 1);
    const auto isOther = [preferred = words(format.preferred)](const YamlNode& item) {
      const auto text = preferred.empty() ? std::nullopt : item.find(preferred[0]);
      return !text || !text->isScalar() || text->text() != preferred[1];
    };
    if (!std::ranges::all_of(items, isOther)) std::erase_if(items, isOther);
    for (const YamlNode& item : items) add(std::string(part), item);
  } else if (place.map.isMap()) {
    for (const std::string& key : place.map.keys())
      if (const auto match = matchOf(key, part)) add(format.is_flat ? *match : key, place.map.at(key));
  }
}

// The lens that the file names.
const SmallLens& lensOf(const SmallFormat& format, const SmallPlace& place, const YamlNode& root) {
  if (format.model.empty()) return format.lenses.front();
  std::string name;
  std::optional<YamlNode> stated;
  for (const std::string& path : words(format.model)) {
    const auto node = findPath(place, root, path);
    if (!node) continue;
    name += (stated ? "+" : "") + node->text();
    stated = node;
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

std::optional<ImageSize> sizeOf(const SmallFormat& format, const SmallPlace& place, const YamlNode& root) {
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
  const bool is_open = format.unit == SmallUnit::kSidesIfBelow1;
  const bool is_below_1 = p[2].value < 1 && p[3].value < 1;
  if (format.unit == SmallUnit::kPixels || (is_open && !is_below_1)) return takeOrigin(p, format.origin);
  if (is_open && (p[2].value <= 0 || p[3].value <= 0)) {
    throw place.error("the principal point " + exactText(p[2].value) + ", " + exactText(p[3].value),
                      "one in pixels, or relative to the image size, which is above 0", "correct it");
  }
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
std::vector<StatedNumber> parametersOf(const SmallLens& lens, std::vector<StatedNumber> listed,
                                       const YamlNode& last) {
  std::vector<std::string> order = words(lens.order);
  if (order.back() == "0") order.resize(std::max(order.size() - 1, listed.size()), "0");
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

// Numbers that the lens does not have are not dropped in silence.
void refuseOtherNumbers(const SmallFormat& format, const SmallLens& lens, const SmallPlace& place,
                        const YamlNode& root) {
  std::vector<std::string> own = alternativesOf(lens.paths);
  std::ranges::copy(words(format.known), std::back_inserter(own));
  std::vector<std::string> others = words(format.zero);
  for (const SmallLens& other : format.lenses)
    std::ranges::copy(alternativesOf(other.paths), std::back_inserter(others));
  for (const std::string& path : others) {
    const auto node = std::ranges::find(own, path) == own.end() ? findPath(place, root, path) : std::nullopt;
    if (!node || saysNothing(*node)) continue;
    const std::string name(split(lens.name, '|').front());
    throw UnsupportedCamera(node->error(
        node->isScalar() ? "'" + node->text() + "'" : "numbers",
        name.empty() ? "0: such lenses are not supported" : "0, because the lens '" + name + "' has none",
        name.empty() ? "calibrate again without this term" : "correct the name of the lens, or remove it"));
  }
}

StatedCamera readOne(const SmallFormat& format, const SmallPlace& place, const YamlNode& root,
                     const ReadOptions& options) {
  const SmallLens& lens = lensOf(format, place, root);
  std::vector<StatedNumber> listed;
  std::optional<YamlNode> last;
  std::size_t num_missing = 0;
  std::string_view kind;
  for (const std::string& text : words(lens.paths)) {
    kind = Path(text).kind;
    const auto node = valueAt(place, root, text);
    num_missing += node ? 0 : 1;
    if (!node) continue;
    listed.resize(listed.size() + std::exchange(num_missing, 0));
    append(listed, numbersAt(*node, kind));
    last = node;
  }
  refuseOtherNumbers(format, lens, place, root);
  const auto size = sizeOf(format, place, root);
  std::string_view model = lens.model;
  std::vector<StatedNumber> parameters;
  if (model.starts_with("opencv")) {
    constexpr std::size_t kRadtan = 9;  // of which each has its key
    if (kind.empty() && areZero(std::span(listed).subspan(std::min(listed.size(), kRadtan))))
      listed.resize(kRadtan);
    if (listed.size() < 4)
      throw last->error(std::to_string(listed.size()) + " numbers of the lens", std::string(lens.order));
    std::vector<StatedNumber> coefficients(listed.begin() + 4, listed.end());
    parameters.assign(listed.begin(), listed.begin() + 4);
    model = openCvModel(*last, parameters, coefficients, model == "opencv" ? "radtan" : options.model);
    append(parameters, coefficients);
  } else {
    if (lens.convert != nullptr) lens.convert(listed);
    parameters = parametersOf(lens, std::move(listed), *last);
  }
  takeUnit(format, *last, size ? size : options.image_size, parameters);
  return stateCamera(last->where(), model, parameters, size);
}

SO3 rotationAt(const YamlNode& node, std::vector<Remark>& remarks) {
  const std::vector<StatedNumber> r = statedNumbers(node);
  if (r.size() == 3) return SO3::exp(readVector(node));
  if (r.size() != 4) return readRotation(node, remarks);
  return withPlace(node.where(), [&r] {
    return SO3::fromQuaternion({r[3].value, r[0].value, r[1].value, r[2].value});
  });
}

// The pose, unless the file does not state it.
std::optional<SE3> poseAt(const SmallFormat& format, const SmallPlace& place, const YamlNode& root,
                          std::vector<Remark>& remarks) {
  const std::vector<std::string> paths = words(format.pose);
  const std::vector<YamlNode> first = findAll(place, root, paths.front());
  const auto last = findPath(place, root, paths.back());
  if (first.empty() || !last) return std::nullopt;
  SE3 pose;
  if (format.pose.starts_with("P=")) {
    pose.translation = translationOf(statedNumbers(*last, 12));
  } else if (paths.size() == 1) {
    pose = readMotion(*last, remarks);
  } else {
    pose = {rotationAt(first.front(), remarks), readVector(*last)};
    constexpr double kFewDigits = 1e-3;
    for (const YamlNode& other : std::span(first).subspan(1)) {
      const SO3 turn = rotationAt(other, remarks).inverse() * pose.rotation;
      if (!(turn.log().norm() < kFewDigits)) refuseOther(first.front(), other);
    }
  }
  return format.is_rig_from_camera ? pose.inverse() : pose;
}

// The poses, or none if a camera has none.
std::vector<SE3> posesOf(const SmallFormat& format, const std::vector<SmallPlace>& places,
                         const YamlNode& root, std::vector<Remark>& remarks) {
  std::vector<SE3> poses;
  std::string missing;
  for (const SmallPlace& place : places) {
    const auto pose = poseAt(format, place, root, remarks);
    if (!pose) missing = place.map.where() + ": camera '" + place.name + "' has no pose";
    if (!pose) continue;
    poses.push_back(*pose);
    const double length = (poses.back() * poses.front().inverse()).translation.norm();
    remarkLongBaseline(place.map.where(), length, remarks);
  }
  if (missing.empty() || poses.empty()) return poses;
  remarks.push_back({"not_carried", missing + ", so the poses of the others are not read"});
  return {};
}

// Adds remarks about keys of the map that no path or pattern begins with, and about others that are not read.
void remarkOthers(const SmallFormat& format, const YamlNode& root, const YamlNode& map,
                  StatedCamera& camera) {
  std::vector<std::string> paths;
  const auto add = [&paths](std::string_view more) {
    std::ranges::copy(alternativesOf(more), std::back_inserter(paths));
  };
  for (const std::string_view more :
       {format.size, format.model, format.pose, format.name, format.known, format.zero, format.not_carried})
    add(more);
  for (const SmallLens& lens : format.lenses) add(lens.paths);
  const auto remark = [&](const YamlNode& place) {
    std::vector<std::string> known = place.keys();
    std::erase_if(known, [&paths](const std::string& key) {
      return std::ranges::none_of(paths, [&key](std::string_view path) {
        if (path.starts_with('/')) path.remove_prefix(1);
        return matchOf(key, path.substr(0, path.find_first_of(".+"))).has_value();
      });
    });
    remarkUnknownKeys(place, known, camera);
    remarkNotCarried(place, words(format.not_carried), camera);
  };
  remark(map);
  if (camera.number != 0 || !root.isMap() || map.node().is(root.node())) return;
  add(format.cameras);
  remark(root);
}

}  // namespace small_format

std::vector<SmallPlace> placesOf(const SmallFormat& format, const YamlNode& root) {
  std::vector<SmallPlace> all;
  for (const std::string& pattern : words(format.cameras)) {
    std::vector<SmallPlace> places = {{"", root}};
    for (const std::string_view part : split(pattern, '.')) {
      if (pattern == ".") break;
      std::vector<SmallPlace> next;
      for (const SmallPlace& place : places) small_format::addPlaces(format, place, part, next);
      places = std::move(next);
    }
    for (const SmallPlace& place : places) all.push_back({place.name, format.is_flat ? root : place.map});
  }
  return all;
}

std::vector<std::string_view> modelsOf(const SmallLens& lens) {
  if (!lens.model.starts_with("opencv")) return {lens.model};
  std::vector<std::string_view> models(openCvModels().begin(), openCvModels().end());
  const std::size_t num_keys = words(lens.paths).size();
  if (lens.paths.find("L=") == std::string_view::npos)  // a list has any number of them
    std::erase_if(models, [&](std::string_view model) { return parameterNames(model).size() > num_keys; });
  return models;
}

bool recognisesSmall(const SmallFormat& format, const CameraDocument& document) {
  using namespace small_format;
  if (!document.isTree()) return false;
  try {
    const YamlNode& root = document.root();
    return std::ranges::any_of(placesOf(format, root), [&](const SmallPlace& place) {
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
  std::vector<SmallPlace> places = placesOf(format, root);
  std::vector<SmallPlace> others;
  std::erase_if(places, [&](const SmallPlace& place) {
    const bool is_camera = place.map.isMap() && isMarked(format, place, root);
    if (!is_camera) others.push_back(place);
    return !is_camera;
  });
  const auto isUsable = [&](const SmallPlace& place) { return isCalibrated(format, place, root); };
  if (const auto rest = std::stable_partition(places.begin(), places.end(), isUsable);
      rest != places.begin()) {
    others.insert(others.end(), rest, places.end());
    places.erase(rest, places.end());
  }
  for (SmallPlace& place : places) place.first = places.front().name;
  CameraSource all;
  for (const SmallPlace& place : places) {
    const auto named = format.name.empty() ? std::nullopt : findPath(place, root, format.name);
    all.add(named ? named->text() : place.name, [&] { return readOne(format, place, root, options); });
  }
  for (StatedCamera& camera : all.cameras) {
    // Cameras of a flat file share its map, whose keys are told once.
    if (!format.is_flat || &camera == &all.cameras.front())
      remarkOthers(format, root, places[camera.number].map, camera);
  }
  const std::vector<std::string> patterns = words(format.cameras);
  const bool is_any_map = std::ranges::find(patterns, "*") != patterns.end();
  for (const SmallPlace& other : others) {
    if (!all.cameras.empty() && !is_any_map && other.map.isMap())
      all.cameras.front().remarks.push_back(
          {"not_carried", other.map.where() + (format.is_flat ? ": " + other.name : "") +
                              ": not a calibrated camera, so it is ignored"});
  }
  if (!format.pose.empty())
    statePoses(all, [&](std::vector<Remark>& remarks) { return posesOf(format, places, root, remarks); });
  if (format.finish != nullptr) format.finish(root, options, all);
  return all;
}

}  // namespace alidade::detail
