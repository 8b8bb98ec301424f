// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_frames.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <regex>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// One key per image of each camera.
using Keys = std::vector<std::vector<std::string>>;

// "day1/000" of "day1/000.png"; "day1/clip@120" of "day1/clip.mp4@120", a frame of a video.
std::string withoutExtension(const std::string& image) {
  const std::size_t at = image.rfind('@');
  const bool is_frame = at != std::string::npos && at + 1 < image.size() &&
                        image.find_first_not_of("0123456789", at + 1) == std::string::npos;
  const std::string frame = is_frame ? image.substr(at) : "";
  return std::filesystem::path(is_frame ? image.substr(0, at) : image).replace_extension().string() + frame;
}

std::string stemOf(const std::string& image) {
  return std::filesystem::path(withoutExtension(image)).filename().string();
}

// All known images of a camera, each once.
std::vector<std::string> imagesOf(const RigViews& camera) {
  std::set<std::string> all(camera.images.begin(), camera.images.end());
  for (const View& view : camera.views) all.insert(view.image);
  return {all.begin(), all.end()};
}

// The numbers in a name, the last one first, without leading zeros.
std::vector<std::string> numbersIn(const std::string& name) {
  static const std::regex kNumber(R"(0*([0-9]+(?:\.[0-9]+)?))");
  std::vector<std::string> numbers(std::sregex_token_iterator(name.begin(), name.end(), kNumber, 1), {});
  std::ranges::reverse(numbers);
  return numbers;
}

bool areUnique(const Keys& keys) {
  return std::ranges::all_of(keys, [](const std::vector<std::string>& of_camera) {
    return std::set(of_camera.begin(), of_camera.end()).size() == of_camera.size();
  });
}

// For each camera, the number of images whose key also occurs in a different camera.
std::vector<std::size_t> numSharedByCamera(const Keys& keys) {
  std::map<std::string, std::set<std::size_t>> cameras_of;
  for (std::size_t c = 0; c < keys.size(); ++c) {
    for (const std::string& key : keys[c]) cameras_of[key].insert(c);
  }
  std::vector<std::size_t> counts(keys.size());
  for (const auto& [key, cameras] : cameras_of) {
    if (cameras.size() < 2) continue;
    for (const std::size_t c : cameras) ++counts[c];
  }
  return counts;
}

// The sum over all cameras; 0 if keys are not unique within a camera.
std::size_t numShared(const Keys& keys) {
  if (!areUnique(keys)) return 0;
  const std::vector<std::size_t> counts = numSharedByCamera(keys);
  return std::accumulate(counts.begin(), counts.end(), std::size_t{0});
}

// True if fewer than half of the images of some camera have an equal key elsewhere.
bool isAnyMostlyAlone(const Keys& keys) {
  const std::vector<std::size_t> counts = numSharedByCamera(keys);
  for (std::size_t c = 0; c < keys.size(); ++c) {
    if (2 * counts[c] < keys[c].size()) return true;
  }
  return false;
}

// The last number of the names that is unique among all images of each camera and relates most images. An
// image without one has its own key.
std::optional<Keys> numberKeys(const std::vector<std::vector<std::string>>& images) {
  constexpr std::size_t kMost = 4;  // a date and time have more, of which a single number is meaningless
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

constexpr std::size_t kMostDigits = 30;  // longer numbers are not times

bool isTime(const std::string& key) {
  constexpr std::size_t kDigits = 9;
  if (key.size() > kMostDigits) return false;
  if (key.find_first_not_of("0123456789.") != std::string::npos) return false;
  return key.size() >= kDigits || key.find('.') != std::string::npos;
}

struct Shot {
  long double time;  // nanoseconds since 1970 have 19 digits
  std::size_t camera;
  std::size_t image;
};

// Largest time difference within one frame: a quarter of the shortest of the cameras' usual intervals.
double farthestApart(const std::vector<Shot>& shots, std::size_t num_cameras) {
  constexpr double kNear = 0.25;
  std::vector<std::vector<double>> steps(num_cameras);
  std::vector<std::optional<long double>> last(num_cameras);
  for (const Shot& shot : shots) {
    std::optional<long double>& before = last[shot.camera];
    if (before) steps[shot.camera].push_back(static_cast<double>(shot.time - *before));
    before = shot.time;
  }
  std::optional<double> interval;
  for (std::vector<double>& of_camera : steps) {
    if (of_camera.empty()) continue;
    const double usual = medianOf(std::move(of_camera));
    interval = std::min(interval.value_or(usual), usual);
  }
  return kNear * interval.value_or(0);
}

// Two shots of different cameras: the difference of their times, true if these differ as texts, and their
// indices in order of time.
using NearShots = std::tuple<double, bool, std::size_t, std::size_t>;

// Pairs of shots within this time difference, the nearest first.
std::vector<NearShots> nearShots(const std::vector<Shot>& shots, const Keys& times, double most) {
  std::vector<NearShots> pairs;
  const auto textOf = [&](const Shot& shot) { return times[shot.camera][shot.image]; };
  for (std::size_t i = 0; i < shots.size(); ++i) {
    for (std::size_t k = i + 1; k < shots.size(); ++k) {
      const auto apart = static_cast<double>(shots[k].time - shots[i].time);
      if (apart > most) break;
      if (shots[i].camera != shots[k].camera)
        pairs.emplace_back(apart, textOf(shots[i]) != textOf(shots[k]), i, k);
    }
  }
  std::ranges::sort(pairs);
  return pairs;
}

// Replaces times near each other by one key, the first of them. The nearest shots are joined first, as long
// as a frame has one shot per camera and is short enough.
// @param spread  the largest difference between the times of one frame
Keys byNearestTime(const Keys& times, double& spread) {
  std::vector<Shot> shots;
  for (std::size_t c = 0; c < times.size(); ++c) {
    for (std::size_t i = 0; i < times[c].size(); ++i)
      shots.push_back({.time = std::stold(times[c][i]), .camera = c, .image = i});
  }
  std::ranges::stable_sort(shots, {}, &Shot::time);
  const double most = farthestApart(shots, times.size());
  std::vector<std::size_t> group_of(shots.size());
  std::vector<std::vector<std::size_t>> groups(shots.size());  // of shots, in the order of time
  for (std::size_t s = 0; s < shots.size(); ++s) {
    group_of[s] = s;
    groups[s] = {s};
  }
  for (const auto& [apart, is_other_text, earlier, later] : nearShots(shots, times, most)) {
    const std::size_t into = group_of[earlier];
    const std::size_t from = group_of[later];
    if (into == from) continue;
    std::vector<std::size_t> joined;
    std::ranges::merge(groups[into], groups[from], std::back_inserter(joined));
    std::set<std::size_t> cameras;
    for (const std::size_t s : joined) cameras.insert(shots[s].camera);
    const auto length = static_cast<double>(shots[joined.back()].time - shots[joined.front()].time);
    if (cameras.size() < joined.size() || length > most) continue;
    for (const std::size_t s : groups[from]) group_of[s] = into;
    groups[from].clear();
    groups[into] = std::move(joined);
  }
  Keys result = times;
  for (const std::vector<std::size_t>& group : groups) {
    for (const std::size_t s : group) {
      const Shot& first = shots[group.front()];
      result[shots[s].camera][shots[s].image] = times[first.camera][first.image];
      spread = std::max(spread, static_cast<double>(shots[s].time - first.time));
    }
  }
  return result;
}

// True if all images are known, including those without a board.
bool areKnown(std::span<const RigViews> cameras) {
  return std::ranges::none_of(cameras, [](const RigViews& camera) { return camera.images.empty(); });
}

// The last number in each name; nothing if they do not rise.
std::vector<long double> risingNumbers(const std::vector<std::string>& names) {
  std::vector<long double> result;
  for (const std::string& name : names) {
    const std::vector<std::string> numbers = numbersIn(std::filesystem::path(name).filename().string());
    if (numbers.empty() || numbers.front().size() > kMostDigits) return {};
    result.push_back(std::stold(numbers.front()));
  }
  const bool is_rising = std::ranges::adjacent_find(result, std::greater_equal<>()) == result.end();
  return is_rising ? result : std::vector<long double>();
}

// Seconds in a unit of times since 1970; 0 for other numbers.
double unitOf(long double number) {
  constexpr double kEarliest = 1e9;  // 2001
  constexpr double kLatest = 4e9;    // 2096
  for (const double unit : {1.0, 1e-3, 1e-6, 1e-9}) {
    const double seconds = static_cast<double>(number) * unit;
    if (seconds > kEarliest && seconds < kLatest) return unit;
  }
  return 0;
}

void addTimes(RigFrames& frames) {
  const std::vector<long double> numbers = risingNumbers(frames.names);
  std::vector<double> steps;
  for (std::size_t f = 1; f < numbers.size(); ++f)
    steps.push_back(static_cast<double>(numbers[f] - numbers[f - 1]));
  if (!steps.empty()) {
    frames.step = medianOf(std::move(steps));
    frames.interval_s = frames.step * unitOf(numbers.front());
  }
  for (std::size_t f = 0; f < frames.names.size(); ++f) {
    frames.times.push_back(frames.step > 0 ? static_cast<double>(numbers[f] - numbers.front()) / frames.step
                                           : static_cast<double>(f));
  }
}

// The keys less the leads, as in the camera with the largest one, so that none is negative; nothing if a key
// is no number.
std::optional<Keys> withoutLeads(std::span<const RigViews> cameras, Keys keys) {
  const double most = std::ranges::max(cameras, {}, &RigViews::lead).lead;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (std::string& key : keys[c]) {
      if (key.size() > kMostDigits || key.find_first_not_of("0123456789.") != std::string::npos)
        return std::nullopt;
      const long double number = std::stold(key) + static_cast<long double>(most - cameras[c].lead);
      key = fmt::format("{:.{}f}", number, std::trunc(number) == number ? 0 : 6);
    }
  }
  return keys;
}

RigFrames framesByKeys(std::span<const RigViews> cameras, const std::vector<std::vector<std::string>>& images,
                       const Keys& keys) {
  std::map<std::string, std::size_t> num_of;  // number of images per key
  for (const std::vector<std::string>& of_camera : keys) {
    for (const std::string& key : of_camera) ++num_of[key];
  }
  RigFrames frames{.names = mapped(num_of, [](const auto& entry) { return entry.first; }),
                   .frame_of = {},
                   .unmatched = {},
                   .leads = mapped(cameras, &RigViews::lead)};
  std::ranges::sort(frames.names, naturalLess);
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
  addTimes(frames);
  return frames;
}

// Two images of one camera with the same name in different folders, "day1/000.png and day2/000.png of left".
std::string repeatedName(std::span<const RigViews> cameras,
                         const std::vector<std::vector<std::string>>& images) {
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    std::map<std::string, std::string> first;
    for (const std::string& image : images[c]) {
      const auto [at, is_new] = first.emplace(stemOf(image), image);
      if (!is_new) return at->second + " and " + image + " of " + cameras[c].name;
    }
  }
  return "";
}

[[noreturn]] void throwUnmatchable(std::span<const RigViews> cameras,
                                   const std::vector<std::vector<std::string>>& images) {
  const std::string next_step = "rename the images, or say which belong together with --match FRAMES.csv";
  const std::string repeated = repeatedName(cameras, images);
  if (!repeated.empty()) {
    throw inputError({.where = "rig",
                      .found = "a name that occurs twice in one camera: " + repeated,
                      .expected = "different names, or the same sub-folders for all cameras",
                      .next_step = next_step});
  }
  const auto example = [&](std::size_t c) {
    return images[c].empty() ? cameras[c].name : cameras[c].name + "/" + images[c].front();
  };
  throw inputError({.where = "rig",
                    .found = "no two images with the same name or number in it, for example " + example(0) +
                             " and " + example(1),
                    .expected = "images taken together have the same name or the same number",
                    .next_step = next_step});
}

// True if `tail` is the path or its last parts.
bool isTail(const std::string& whole, const std::string& tail) {
  return whole == tail || whole.ends_with("/" + tail);
}

// The path of each image of a camera, or its name if the path is unknown.
std::map<std::string, std::string> placesOfImages(const RigViews& camera,
                                                  const std::vector<std::string>& images) {
  std::map<std::string, std::string> places;
  for (const std::string& image : images) places[image] = image;
  for (std::size_t i = 0; i < std::min(camera.images.size(), camera.paths.size()); ++i) {
    places[camera.images[i]] = std::filesystem::absolute(camera.paths[i]).lexically_normal().generic_string();
  }
  return places;
}

std::size_t columnOf(const FrameTable& table, const std::string& camera) {
  const auto column = std::ranges::find(table.cameras, camera);
  if (column == table.cameras.end()) {
    throw inputError({.where = table.path.empty() ? "--match" : table.path,
                      .found = "no column '" + camera + "'",
                      .expected = "a column for each camera; there are " + join(table.cameras, ", ")});
  }
  return static_cast<std::size_t>(column - table.cameras.begin());
}

// "line 8" of the table's file; "row 7" if it has none.
std::string nameOfRow(const FrameTable& table, std::size_t row) {
  return table.lines.empty() ? "row " + std::to_string(row + 1) : "line " + std::to_string(table.lines[row]);
}

// "frames.csv:8".
std::string placeOfRow(const FrameTable& table, std::size_t row) {
  return table.lines.empty() ? "--match: " + nameOfRow(table, row)
                             : table.path + ":" + std::to_string(table.lines[row]);
}

// The row that names each image of a camera, and the rows that name missing images.
struct ColumnMatch {
  std::vector<std::optional<std::size_t>> row_of;
  std::vector<std::size_t> absent;
};

ColumnMatch matchColumn(const FrameTable& table, const RigViews& camera,
                        const std::vector<std::string>& images) {
  const std::size_t at = columnOf(table, camera.name);
  const std::map<std::string, std::string> places = placesOfImages(camera, images);
  const std::vector<std::string> named_places = mapped(table.rows, [&](const std::vector<std::string>& row) {
    return std::filesystem::path(row[at]).lexically_normal().generic_string();
  });
  ColumnMatch match;
  std::map<std::size_t, std::string> image_of;  // by row
  for (const std::string& image : images) {
    std::optional<std::size_t>& row = match.row_of.emplace_back();
    const std::string& place = places.at(image);
    for (std::size_t r = 0; r < table.rows.size(); ++r) {
      const std::string& named = table.rows[r][at];
      // Folders in the table must match those of the image.
      if (named.empty() || (!isTail(image, named) && !isTail(place, named_places[r]))) continue;
      if (row || image_of.contains(r)) {
        throw inputError({.where = placeOfRow(table, r),
                          .found = row ? "'" + named + "' of " + camera.name + ", which stands in " +
                                             nameOfRow(table, *row) + " too"
                                       : "'" + named + "', which may be " + image_of[r] + " or " + image +
                                             " of " + camera.name,
                          .expected = "each image once",
                          .next_step = "name images with their folders"});
      }
      row = r;
      image_of[r] = image;
    }
  }
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    if (!table.rows[r][at].empty() && !image_of.contains(r)) match.absent.push_back(r);
  }
  return match;
}

// A table must not name unknown images of a camera whose images are all known, and must name some known ones
// of the others.
void requireImages(const FrameTable& table, const RigViews& camera, const std::vector<std::string>& images,
                   const ColumnMatch& match) {
  if (match.absent.empty()) return;
  const bool is_any_named =
      std::ranges::any_of(match.row_of, [](const auto& row) { return row.has_value(); });
  if (camera.images.empty() && (is_any_named || images.empty())) return;
  const std::size_t row = match.absent.front();
  throw inputError(
      {.where = placeOfRow(table, row),
       .found =
           "'" + table.rows[row][columnOf(table, camera.name)] + "', which is no image of " + camera.name,
       .expected = "an image that was given" + (images.empty() ? "" : ", such as '" + images.front() + "'")});
}

}  // namespace

bool RigFrames::areShifted() const {
  return std::ranges::any_of(leads, [&](double lead) { return lead != leads.front(); });
}

RigFrames matchFrames(std::span<const RigViews> cameras) {
  std::vector<std::vector<std::string>> images;
  for (const RigViews& camera : cameras) images.push_back(imagesOf(camera));
  const auto byTime = [&](const Keys& times) {
    double spread = 0;
    RigFrames frames = framesByKeys(cameras, images, byNearestTime(times, spread));
    frames.time_spread = spread;
    return frames;
  };
  Keys best;
  std::size_t num_shared = 0;
  const auto prefer = [&](Keys keys) {
    const std::size_t count = numShared(keys);
    if (count <= num_shared) return;
    num_shared = count;
    best = std::move(keys);
  };
  const std::optional<Keys> numbers = numberKeys(images);
  if (std::ranges::any_of(cameras, [](const RigViews& camera) { return camera.lead != 0; })) {
    const std::optional<Keys> times = numbers ? withoutLeads(cameras, *numbers) : std::nullopt;
    if (!times) throwUnmatchable(cameras, images);
    return byTime(*times);
  }
  prefer(mapped(images, [](const auto& of_camera) { return mapped(of_camera, withoutExtension); }));
  prefer(mapped(images, [](const auto& of_camera) { return mapped(of_camera, stemOf); }));
  if (numbers) prefer(*numbers);
  const bool are_times = numbers && std::ranges::all_of(*numbers, [](const std::vector<std::string>& own) {
                           return std::ranges::all_of(own, isTime);
                         });
  if (are_times && (num_shared == 0 || isAnyMostlyAlone(best))) return byTime(*numbers);
  if (num_shared == 0 && (!numbers || areKnown(cameras))) throwUnmatchable(cameras, images);
  return framesByKeys(cameras, images, num_shared == 0 ? *numbers : best);
}

RigFrames framesOf(const FrameTable& table, std::span<const RigViews> cameras) {
  std::vector<std::vector<std::string>> images;
  Keys keys;
  std::vector<RigImage> unmatched;
  std::vector<std::size_t> num_named(table.rows.size());  // of the cameras that were given
  for (const RigViews& camera : cameras) {
    const std::size_t at = columnOf(table, camera.name);
    for (std::size_t r = 0; r < table.rows.size(); ++r) num_named[r] += table.rows[r][at].empty() ? 0 : 1;
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    images.push_back(imagesOf(cameras[c]));
    const ColumnMatch match = matchColumn(table, cameras[c], images.back());
    requireImages(table, cameras[c], images.back(), match);
    std::vector<std::string>& own = keys.emplace_back();
    for (std::size_t i = 0; i < images[c].size(); ++i) {
      const std::optional<std::size_t> row = match.row_of[i];
      own.push_back(row ? nameOfRow(table, *row) : cameras[c].name + "/" + images[c][i]);
      // The table lists a partner, even if that shows no board.
      if (row && num_named[*row] > 1) continue;
      unmatched.push_back({.camera = c, .image = images[c][i], .frame = own.back()});
    }
  }
  RigFrames frames = framesByKeys(cameras, images, keys);
  frames.unmatched = std::move(unmatched);
  frames.step = 0;
  return frames;
}

std::vector<RigImage> namedWithoutViews(const FrameTable& table, std::span<const RigViews> cameras) {
  std::vector<RigImage> result;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (!cameras[c].images.empty()) continue;
    for (const std::size_t row : matchColumn(table, cameras[c], imagesOf(cameras[c])).absent) {
      result.push_back({.camera = c,
                        .image = table.rows[row][columnOf(table, cameras[c].name)],
                        .frame = placeOfRow(table, row)});
    }
  }
  return result;
}

}  // namespace alidade
