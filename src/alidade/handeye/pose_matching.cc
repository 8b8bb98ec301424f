// SPDX-License-Identifier: MIT
#include "alidade/handeye/pose_matching.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/median.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

bool isDigit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// Without folder and, unless it is the fraction of a time, extension.
std::string stemOf(const std::string& image) {
  const std::filesystem::path name = std::filesystem::path(image).filename();
  const std::string extension = name.extension().string();
  const bool is_fraction = extension.size() > 1 && isDigit(extension[1]);
  return (is_fraction ? name : name.stem()).string();
}

// The last run of digits, without leading zeros; empty without digits.
std::string numberOf(const std::string& image) {
  const std::string stem = stemOf(image);
  if (stem.find('.') != std::string::npos) return "";  // a time
  const auto last = std::find_if(stem.rbegin(), stem.rend(), isDigit);
  const auto first = std::find_if_not(last, stem.rend(), isDigit);
  std::string digits(first.base(), last.base());
  digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size() - (digits.empty() ? 0 : 1)));
  return digits;
}

// The time in a name, seconds.
std::optional<double> timeOf(const std::string& image) {
  const std::string stem = stemOf(image);
  const auto last = std::find_if(stem.rbegin(), stem.rend(), isDigit);
  const auto first = std::find_if_not(last, stem.rend(), [](char c) { return isDigit(c) || c == '.'; });
  const std::string digits(first.base(), last.base());
  const auto value = parseDouble(digits);
  if (!value) return std::nullopt;
  if (digits.find('.') != std::string::npos) return value;
  const std::map<std::size_t, double> kUnits = {{13, 1e-3}, {16, 1e-6}, {19, 1e-9}};
  const auto unit = kUnits.find(digits.size());
  return unit == kUnits.end() ? std::nullopt : std::optional(*value * unit->second);
}

// Between which rows of a log, and where, a time is.
struct Between {
  std::size_t before, after;
  double share;  // of the way to `after`
};

std::optional<Between> betweenRows(const std::vector<std::pair<double, std::size_t>>& log, double usual,
                                   double time) {
  constexpr double kMostGap = 2.5;
  const auto after = std::ranges::lower_bound(log, std::pair(time, std::size_t{0}));
  if (after != log.begin() && after != log.end()) {
    const auto before = std::prev(after);
    const double gap = after->first - before->first;
    if (gap <= kMostGap * usual) return Between{before->second, after->second, (time - before->first) / gap};
  }
  for (const auto& near : {after, after == log.begin() ? after : std::prev(after)}) {
    if (near != log.end() && std::abs(near->first - time) <= usual / 2)
      return Between{near->second, near->second, 0};
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::optional<std::size_t>> matchedRows(const std::vector<std::string>& images,
                                                    std::span<const std::string> all,
                                                    const std::vector<RobotPose>& poses,
                                                    std::vector<Diagnosis>& diagnoses) {
  std::vector<std::optional<std::size_t>> best(images.size());
  std::size_t num_best = 0;
  for (const auto key : {+[](const std::string& image) { return image; }, stemOf, numberOf}) {
    std::map<std::string, std::vector<std::size_t>> rows;
    for (std::size_t i = 0; i < poses.size(); ++i) rows[key(poses[i].image)].push_back(i);
    std::map<std::string, int> counts;
    for (const std::string& image : images) ++counts[key(image)];
    std::vector<std::optional<std::size_t>> found(images.size());
    std::size_t num_found = 0;
    for (std::size_t i = 0; i < images.size(); ++i) {
      const auto row = rows.find(key(images[i]));
      if (row == rows.end() || row->first.empty() || row->second.size() != 1) continue;
      if (counts.at(row->first) != 1) continue;
      found[i] = row->second.front();
      ++num_found;
    }
    if (num_found > num_best) best = found, num_best = num_found;
    if (2 * num_best > images.size()) return best;
  }
  const std::span<const std::string> in_order = all.size() == poses.size() ? all : std::span(images);
  const auto placeOf = [&](const std::string& image) {
    return static_cast<std::size_t>(std::ranges::find(in_order, image) - in_order.begin());
  };
  const bool are_known =
      std::ranges::all_of(images, [&](const std::string& image) { return placeOf(image) < in_order.size(); });
  if (poses.size() == in_order.size() && are_known && num_best == 0) {
    for (std::size_t i = 0; i < images.size(); ++i) best[i] = placeOf(images[i]);
    diagnoses.push_back(
        {.id = "robot_poses_by_order",
         .cause = "images and robot poses have no common names, so they were matched by order",
         .next_step = "name the images in the table's first column"});
    return best;
  }
  if (num_best >= kFewestPoses) return best;
  throw inputError(
      {.where = "robot poses",
       .found = fmt::format("{} poses, the first of '{}', for {} images with the board, the first '{}'",
                            poses.size(), poses.empty() ? "" : poses.front().image, images.size(),
                            images.empty() ? "" : images.front()),
       .expected = "a pose for each image, with the image's name or number",
       .next_step = "name the images in the table's first column"});
}

std::optional<RobotTable> tableAtTimes(const std::vector<std::string>& images, const RobotTable& log,
                                       std::vector<Diagnosis>& diagnoses) {
  std::vector<std::pair<double, std::size_t>> times;
  std::set<std::string> names;
  for (std::size_t i = 0; i < log.poses.size(); ++i) {
    const auto time = timeOf(log.poses[i].image);
    if (!time) return std::nullopt;
    times.emplace_back(*time, i);
    names.insert(stemOf(log.poses[i].image));
  }
  if (times.size() < kFewestPoses) return std::nullopt;
  std::ranges::sort(times);
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i].first - times[i - 1].first);
  const double usual = medianOf(steps);
  std::vector<std::pair<std::string, Between>> found;
  std::size_t num_named = 0;
  for (const std::string& image : std::set(images.begin(), images.end())) {
    num_named += names.contains(stemOf(image)) ? 1 : 0;
    const auto time = timeOf(image);
    const auto at = time ? betweenRows(times, usual, *time) : std::nullopt;
    if (at) found.emplace_back(image, *at);
  }
  if (found.size() < kFewestPoses || 2 * num_named > found.size()) return std::nullopt;
  RobotTable table;
  const auto interpolated = [&](const std::vector<RobotPose>& poses) {
    std::vector<RobotPose> at_images;
    for (const auto& [image, at] : found) {
      const SE3& before = poses[at.before].base_from_gripper;
      const SE3 step = before.inverse() * poses[at.after].base_from_gripper;
      at_images.push_back({image, before * SE3::exp(at.share * step.log())});
    }
    return at_images;
  };
  table.poses = interpolated(log.poses);
  for (const RobotReading& other : log.others) table.others.push_back({other.how, interpolated(other.poses)});
  diagnoses.push_back(
      {.id = "robot_poses_by_time",
       .cause = fmt::format("robot poses were taken at the times of {} images, between rows {:.3g} s apart",
                            found.size(), usual)});
  return table;
}

}  // namespace alidade
