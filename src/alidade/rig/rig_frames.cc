// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_frames.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// One for each image of each camera.
using Keys = std::vector<std::vector<std::string>>;

std::string stemOf(const std::string& image) {
  return std::filesystem::path(image).stem().string();
}

// All images of a camera that are known, each once.
std::vector<std::string> imagesOf(const RigViews& camera) {
  std::set<std::string> all(camera.images.begin(), camera.images.end());
  for (const View& view : camera.views) all.insert(view.image);
  return {all.begin(), all.end()};
}

// The numbers in a name, the last one first, without leading zeros.
std::vector<std::string> numbersIn(const std::string& name) {
  const auto isDigit = [&](std::size_t i) {
    return i < name.size() && std::isdigit(static_cast<unsigned char>(name[i])) != 0;
  };
  std::vector<std::string> numbers;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (!isDigit(i)) continue;
    std::size_t end = i;
    while (isDigit(end)) ++end;
    if (name[std::min(end, name.size() - 1)] == '.' && isDigit(end + 1)) {
      ++end;
      while (isDigit(end)) ++end;
    }
    std::size_t first = i;
    while (first + 1 < end && name[first] == '0' && isDigit(first + 1)) ++first;
    numbers.insert(numbers.begin(), name.substr(first, end - first));
    i = end;
  }
  return numbers;
}

bool areUnique(const Keys& keys) {
  return std::ranges::all_of(keys, [](const std::vector<std::string>& of_camera) {
    return std::set(of_camera.begin(), of_camera.end()).size() == of_camera.size();
  });
}

// How many images have a key that an image of another camera has.
std::size_t numShared(const Keys& keys) {
  std::map<std::string, std::set<std::size_t>> cameras_of;
  for (std::size_t c = 0; c < keys.size(); ++c) {
    for (const std::string& key : keys[c]) cameras_of[key].insert(c);
  }
  std::size_t count = 0;
  for (const auto& [key, cameras] : cameras_of) count += cameras.size() > 1 ? cameras.size() : 0;
  return count;
}

// The last number of the names that differs between all images of each camera, and relates most images. An
// image without one has a key of its own.
std::optional<Keys> numberKeys(const std::vector<std::vector<std::string>>& images) {
  constexpr std::size_t kMost = 4;  // a date and a time have more, of which one number says nothing
  std::optional<Keys> best;
  for (std::size_t k = 0; k < kMost; ++k) {
    Keys keys;
    bool is_any = false;
    for (std::size_t c = 0; c < images.size(); ++c) {
      std::vector<std::string>& own = keys.emplace_back();
      for (const std::string& image : images[c]) {
        const std::vector<std::string> numbers = numbersIn(stemOf(image));
        is_any = is_any || numbers.size() > k;
        own.push_back(numbers.size() > k ? numbers[k] : std::to_string(c) + "/" + image);
      }
    }
    if (is_any && areUnique(keys) && (!best || numShared(keys) > numShared(*best))) best = std::move(keys);
  }
  return best;
}

bool isTime(const std::string& key) {
  constexpr std::size_t kDigits = 9;
  constexpr std::size_t kMostDigits = 30;  // more are no time
  if (key.size() > kMostDigits) return false;
  if (key.find_first_not_of("0123456789.") != std::string::npos) return false;
  return key.size() >= kDigits || key.find('.') != std::string::npos;
}

struct TimedKeys {
  Keys keys;
  double spread = 0;
};

// Times next to each other as one key, the first of them.
TimedKeys byNearestTime(const Keys& times) {
  struct Shot {
    long double time;  // nanoseconds since 1970 have 19 digits
    std::size_t camera;
    std::size_t image;
  };
  std::vector<Shot> shots;
  std::optional<double> interval;  // the shortest of the cameras' usual ones
  for (std::size_t c = 0; c < times.size(); ++c) {
    std::vector<long double> own;
    for (std::size_t i = 0; i < times[c].size(); ++i) {
      own.push_back(std::stold(times[c][i]));
      shots.push_back({.time = own.back(), .camera = c, .image = i});
    }
    std::ranges::sort(own);
    std::vector<double> steps;
    for (std::size_t i = 1; i < own.size(); ++i) steps.push_back(static_cast<double>(own[i] - own[i - 1]));
    if (steps.empty()) continue;
    const double usual = medianOf(std::move(steps));
    interval = std::min(interval.value_or(usual), usual);
  }
  std::ranges::stable_sort(shots, {}, &Shot::time);
  TimedKeys result{.keys = times};
  constexpr double kNear = 0.25;
  const double most = kNear * interval.value_or(0);
  for (std::size_t i = 0; i < shots.size();) {
    std::set<std::size_t> cameras;
    const Shot& first = shots[i];
    for (; i < shots.size() && static_cast<double>(shots[i].time - first.time) <= most &&
           cameras.insert(shots[i].camera).second;
         ++i) {
      result.keys[shots[i].camera][shots[i].image] = times[first.camera][first.image];
      result.spread = std::max(result.spread, static_cast<double>(shots[i].time - first.time));
    }
  }
  return result;
}

// Whether all images are known, those without a board too.
bool areKnown(std::span<const RigViews> cameras) {
  return std::ranges::none_of(cameras, [](const RigViews& camera) { return camera.images.empty(); });
}

RigFrames framesByKeys(std::span<const RigViews> cameras, const std::vector<std::vector<std::string>>& images,
                       const Keys& keys) {
  std::map<std::string, std::size_t> num_of;  // images of a key
  for (const std::vector<std::string>& of_camera : keys) {
    for (const std::string& key : of_camera) ++num_of[key];
  }
  RigFrames frames{.names = mapped(num_of, [](const auto& entry) { return entry.first; }),
                   .frame_of = {},
                   .unmatched = {}};
  std::sort(frames.names.begin(), frames.names.end(), naturalLess);
  std::map<std::string, std::size_t> index_of;
  for (std::size_t f = 0; f < frames.names.size(); ++f) index_of[frames.names[f]] = f;
  const bool are_known = areKnown(cameras);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    std::map<std::string, std::size_t> frame_of_image;
    for (std::size_t i = 0; i < images[c].size(); ++i) {
      frame_of_image[images[c][i]] = index_of[keys[c][i]];
      if (are_known && num_of[keys[c][i]] == 1)
        frames.unmatched.push_back({.camera = c, .image = images[c][i], .frame = keys[c][i]});
    }
    frames.frame_of.push_back(
        mapped(cameras[c].views, [&](const View& view) { return frame_of_image.at(view.image); }));
  }
  return frames;
}

[[noreturn]] void throwUnmatchable(std::span<const RigViews> cameras,
                                   const std::vector<std::vector<std::string>>& images) {
  const auto example = [&](std::size_t c) {
    return images[c].empty() ? cameras[c].name : cameras[c].name + "/" + images[c].front();
  };
  throw inputError({.where = "rig",
                    .found = "no two images with the same name or number in it, for example " + example(0) +
                             " and " + example(1),
                    .expected = "images taken together have the same name or the same number",
                    .next_step = "rename the images, or say which belong together with --match FRAMES.csv"});
}

// A path or its last parts.
bool isSameImage(const std::string& image, const std::string& named) {
  const auto endsWith = [](const std::string& whole, const std::string& end) {
    return whole == end || whole.ends_with("/" + end);
  };
  return endsWith(image, named) || endsWith(named, image);
}

}  // namespace

RigFrames matchFrames(std::span<const RigViews> cameras) {
  std::vector<std::vector<std::string>> images;
  for (const RigViews& camera : cameras) images.push_back(imagesOf(camera));
  Keys stems;
  std::size_t num_images = 0;
  for (const std::vector<std::string>& of_camera : images) {
    stems.push_back(mapped(of_camera, stemOf));
    num_images += of_camera.size();
  }
  const std::size_t num_by_stem = areUnique(stems) ? numShared(stems) : 0;
  const std::optional<Keys> numbers = numberKeys(images);
  const std::size_t num_by_number = numbers ? numShared(*numbers) : 0;
  const bool is_by_stem = num_by_stem > 0 && num_by_stem >= num_by_number;
  const bool are_times = numbers && std::ranges::all_of(*numbers, [](const std::vector<std::string>& own) {
                           return std::ranges::all_of(own, isTime);
                         });
  if (are_times && 2 * std::max(num_by_stem, num_by_number) < num_images) {
    const TimedKeys timed = byNearestTime(*numbers);
    RigFrames frames = framesByKeys(cameras, images, timed.keys);
    frames.time_spread = timed.spread;
    return frames;
  }
  if (num_by_stem == 0 && num_by_number == 0 && (!numbers || areKnown(cameras)))
    throwUnmatchable(cameras, images);
  return framesByKeys(cameras, images, is_by_stem ? stems : *numbers);
}

RigFrames framesOf(const FrameTable& table, std::span<const RigViews> cameras) {
  std::vector<std::vector<std::string>> images;
  Keys keys;
  for (const RigViews& camera : cameras) {
    const auto column = std::ranges::find(table.cameras, camera.name);
    if (column == table.cameras.end()) {
      throw inputError({.where = "--match",
                        .found = "no column '" + camera.name + "'",
                        .expected = "a column for each camera; there are " + join(table.cameras, ", ")});
    }
    const auto at = static_cast<std::size_t>(column - table.cameras.begin());
    images.push_back(imagesOf(camera));
    std::vector<std::string>& own = keys.emplace_back();
    std::set<std::size_t> used;
    for (const std::string& image : images.back()) {
      std::string key = camera.name + "/" + image;  // of an image that is in no row
      bool is_listed = false;
      for (std::size_t r = 0; r < table.rows.size(); ++r) {
        const std::string& named = table.rows[r][at];
        if (named.empty() || !isSameImage(image, named)) continue;
        if (used.contains(r) || is_listed) {
          throw inputError({.where = "--match: " + camera.name,
                            .found = "'" + named + "' stands for several images, or stands in several rows",
                            .expected = "each image once",
                            .next_step = "name images with their folders"});
        }
        used.insert(r);
        is_listed = true;
        key = "row " + std::to_string(r + 1);
      }
      own.push_back(key);
    }
    for (std::size_t r = 0; r < table.rows.size() && !camera.images.empty(); ++r) {
      if (table.rows[r][at].empty() || used.contains(r)) continue;
      throw inputError({.where = "--match: row " + std::to_string(r + 1),
                        .found = "'" + table.rows[r][at] + "', which is no image of " + camera.name,
                        .expected = "an image that was given"});
    }
  }
  return framesByKeys(cameras, images, keys);
}

}  // namespace alidade
