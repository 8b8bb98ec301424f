// SPDX-License-Identifier: MIT
#include "alidade/detect/detection_entry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

using nlohmann::json;

constexpr std::array kReasons = {
    DetectionReason::kFound,      DetectionReason::kPartial,       DetectionReason::kCut,
    DetectionReason::kNoBoard,    DetectionReason::kUnplaced,      DetectionReason::kLargerBoard,
    DetectionReason::kOtherBoard, DetectionReason::kSeveralBoards, DetectionReason::kIrregular,
    DetectionReason::kBlurred,    DetectionReason::kTooSmall};

// JSON has no NaN.
double numberOf(const json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

ImageOutcome outcomeOf(const json& entry, const Board& board) {
  ImageOutcome outcome;
  outcome.size = {entry.at("size").at(0).get<int>(), entry.at("size").at(1).get<int>()};
  outcome.exif_orientation = entry.at("orientation").get<int>();
  Detection& detection = outcome.detection;
  const std::string code = entry.at("reason").get<std::string>();
  const auto reason = std::find_if(kReasons.begin(), kReasons.end(),
                                   [&](DetectionReason known) { return reasonCode(known) == code; });
  if (reason == kReasons.end()) throw inputError({.found = "an unknown reason"});
  detection.reason = *reason;
  detection.detail = entry.at("detail").get<std::string>();
  for (const json& corner : entry.at("corners")) {
    detection.corners.push_back({.id = corner.at(0).get<int>(),
                                 .pixel = {corner.at(1).get<double>(), corner.at(2).get<double>()},
                                 .sigma_px = numberOf(corner.at(3))});
    const int id = detection.corners.back().id;
    if (id < 0 || id >= board.numCorners()) throw inputError({.found = "a corner that the board lacks"});
  }
  const json& measures = entry.at("measures");
  detection.measures = {.blur_px = numberOf(measures.at(0)),
                        .spacing_px = numberOf(measures.at(1)),
                        .area_share = numberOf(measures.at(2)),
                        .tilt_deg = numberOf(measures.at(3))};
  if (const json& seen = entry.at("seen"); !seen.is_null()) {
    detection.seen = {.columns = seen.at(0).get<int>(),
                      .rows = seen.at(1).get<int>(),
                      .num_corners = seen.at(2).get<int>(),
                      .is_closed = seen.at(3).get<bool>()};
  }
  return outcome;
}

}  // namespace

std::string entryKey(const std::string& image_identity, const Board& board) {
  // Changes with every source that corners depend on, and with the compiler.
  return "corners " ALIDADE_DETECTION_CODE " " + board.spec() + " " + image_identity;
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
