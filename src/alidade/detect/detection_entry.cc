// SPDX-License-Identifier: MIT
#include "alidade/detect/detection_entry.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

using nlohmann::json;

// To be raised when corners, measures or reasons change, so that results of older versions are computed
// again.
constexpr int kDetectionVersion = 4;

Error foreignEntry(const char* what) {
  return inputError({.found = what});
}

// Unlike get<int>(), rejects numbers that are not integers or too large.
int intOf(const json& value) {
  constexpr std::int64_t kMax = std::numeric_limits<int>::max();
  if (!value.is_number_integer()) throw foreignEntry("no whole number");
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > static_cast<std::uint64_t>(kMax))
    throw foreignEntry("a large number");
  const auto number = value.get<std::int64_t>();
  if (number < 0 || number > kMax) throw foreignEntry("a negative number");
  return static_cast<int>(number);
}

double finiteOf(const json& value) {
  if (!value.is_number()) throw foreignEntry("no number");
  const auto number = value.get<double>();
  if (!std::isfinite(number)) throw foreignEntry("no finite number");
  return number;
}

// A sigma or a measure; JSON has no NaN.
double measureOf(const json& value) {
  if (value.is_null()) return std::numeric_limits<double>::quiet_NaN();
  const double number = finiteOf(value);
  if (number < 0) throw foreignEntry("a negative measure");
  return number;
}

std::vector<Corner> cornersOf(const json& entry, const ImageSize& size, const Board& board) {
  std::vector<Corner> corners;
  for (const json& corner : entry) {
    corners.push_back({.id = intOf(corner.at(0)),
                       .pixel = {finiteOf(corner.at(1)), finiteOf(corner.at(2))},
                       .sigma_px = measureOf(corner.at(3))});
    if (corners.back().id >= board.numCorners()) throw foreignEntry("a corner that the board lacks");
    if (!isInOrNearImage(corners.back().pixel, size)) throw foreignEntry("a corner outside the image");
  }
  const auto isInOrder = [](const Corner& a, const Corner& b) { return a.id < b.id; };
  if (std::ranges::adjacent_find(corners, std::not_fn(isInOrder)) != corners.end())
    throw foreignEntry("corners out of order");
  return corners;
}

ImageOutcome outcomeOf(const json& entry, const Board& board) {
  ImageOutcome outcome;
  outcome.size = {intOf(entry.at("size").at(0)), intOf(entry.at("size").at(1))};
  if (outcome.size.width == 0 || outcome.size.height == 0) throw foreignEntry("an empty image");
  outcome.exif_orientation = intOf(entry.at("orientation"));
  constexpr int kMaxOrientation = 8;
  if (outcome.exif_orientation < 1 || outcome.exif_orientation > kMaxOrientation)
    throw foreignEntry("an unknown orientation");
  Detection& detection = outcome.detection;
  const std::string code = entry.at("reason").get<std::string>();
  // Reasons that a search gives come first in the enumeration.
  for (detection.reason = DetectionReason::kFound; reasonCode(detection.reason) != code;
       detection.reason = static_cast<DetectionReason>(static_cast<int>(detection.reason) + 1)) {
    if (detection.reason == DetectionReason::kTooSmall) throw foreignEntry("an unknown reason");
  }
  detection.detail = entry.at("detail").get<std::string>();
  detection.corners = cornersOf(entry.at("corners"), outcome.size, board);
  const int num_corners = static_cast<int>(detection.corners.size());
  if (detection.hasCorners() != (num_corners > 0) || (detection.found() && num_corners != board.numCorners()))
    throw foreignEntry("another number of corners than the reason says");
  const json& measures = entry.at("measures");
  detection.measures = {.blur_px = measureOf(measures.at(0)),
                        .spacing_px = measureOf(measures.at(1)),
                        .area_share = measureOf(measures.at(2)),
                        .tilt_deg = measureOf(measures.at(3))};
  if (const json& seen = entry.at("seen"); !seen.is_null()) {
    detection.seen = {.columns = intOf(seen.at(0)),
                      .rows = intOf(seen.at(1)),
                      .num_corners = intOf(seen.at(2)),
                      .is_closed = seen.at(3).get<bool>()};
  }
  return outcome;
}

}  // namespace

std::string entryKey(const std::string& image_identity, const Board& board) {
  return fmt::format("corners {} {} {} {}", kDetectionVersion, CV_VERSION, board.spec(), image_identity);
}

std::string entryText(const ImageOutcome& outcome) {
  const Detection& detection = outcome.detection;
  const ViewMeasures& measures = detection.measures;
  const json corners = mapped(detection.corners, [](const Corner& corner) -> json {
    return {corner.id, corner.pixel.x(), corner.pixel.y(), corner.sigma_px};
  });
  json seen;
  if (detection.seen)
    seen = {detection.seen->columns, detection.seen->rows, detection.seen->num_corners,
            detection.seen->is_closed};
  const json entry = {
      {"size", {outcome.size.width, outcome.size.height}},
      {"orientation", outcome.exif_orientation},
      {"reason", reasonCode(detection.reason)},
      {"detail", detection.detail},
      {"corners", corners},
      {"measures", {measures.blur_px, measures.spacing_px, measures.area_share, measures.tilt_deg}},
      {"seen", seen}};
  return entry.dump();
}

std::optional<ImageOutcome> parseEntry(std::string_view text, const Board& board) {
  try {
    return outcomeOf(json::parse(text), board);
  } catch (const json::exception&) {
    return std::nullopt;
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace alidade
