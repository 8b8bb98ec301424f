// SPDX-License-Identifier: MIT
#include "advice_output.h"

#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/guide/image_region.h"
#include "command.h"

namespace alidade {
namespace {

using nlohmann::json;

// The first line behind a label, the others under it.
std::string labelled(std::string_view label, std::string_view lines) {
  std::string text;
  for (const std::string_view line : split(lines, '\n')) {
    if (line.empty()) continue;
    text += fmt::format("{:<9}{}\n", text.empty() ? label : "", line);
  }
  return text;
}

json tiltJson(const BoardTilt& tilt) {
  return {{"right_nearer_rad", tilt.right_rad}, {"lower_nearer_rad", tilt.lower_rad}};
}

json pixelJson(const Eigen::Vector2d& pixel) {
  return {{"u", orNull(pixel.x())}, {"v", orNull(pixel.y())}};
}

json coverageJson(const CoverageReport& coverage) {
  json regions = json::array();
  for (const ImageRegion& region : coverage.empty_regions) regions.push_back(regionName(region));
  json views = json::array();
  for (const ViewCoverage& view : coverage.views) {
    views.push_back({{"image", view.image},
                     {"middle_px", pixelJson(view.sighting.middle_px)},
                     {"distance_m", view.sighting.distance_m},
                     {"tilt", tiltJson(view.sighting.tilt)},
                     {"fill", view.fill}});
  }
  return {{"grid",
           {{"columns", coverage.columns}, {"rows", coverage.rows}, {"num_corners", coverage.num_corners}}},
          {"share", coverage.share},
          {"border_share", coverage.border_share},
          {"num_image_corners", coverage.num_image_corners},
          {"empty_regions", regions},
          {"num_tilted_15_degrees", coverage.num_tilted},
          {"num_tilted_30_degrees", coverage.num_steep},
          {"num_tilted_to",
           {{"left", coverage.tilts.left},
            {"right", coverage.tilts.right},
            {"upper", coverage.tilts.upper},
            {"lower", coverage.tilts.lower}}},
          {"nearest_m", coverage.nearest_m},
          {"farthest_m", coverage.farthest_m},
          {"smallest_fill", coverage.smallest_fill},
          {"largest_fill", coverage.largest_fill},
          {"views", views}};
}

json nextViewJson(const Guidance& guidance) {
  if (!guidance.next) return nullptr;
  const NextView& next = *guidance.next;
  const Eigen::Quaterniond& q = next.camera_from_board.rotation.quaternion();
  const Eigen::Vector3d& t = next.camera_from_board.translation;
  return {{"determined", guidance.is_determined},
          {"worst_now_px", orNull(guidance.worst_px)},
          {"worst_then_px", guidance.is_determined ? orNull(next.worst_px) : json(nullptr)},
          {"middle_px", pixelJson(next.sighting.middle_px)},
          {"distance_m", next.sighting.distance_m},
          {"fill", next.fill},
          {"whole_board", next.is_whole},
          {"tilt", tiltJson(next.sighting.tilt)},
          {"camera_from_board",
           {{"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}, {"translation_m", {t.x(), t.y(), t.z()}}}}};
}

json targetJson(const Guidance& guidance) {
  if (!guidance.target) return nullptr;
  const TargetReport& target = *guidance.target;
  return {{"target_px", target.target_px},
          {"worst_px", orNull(guidance.worst_px)},
          {"reached", target.is_reached},
          {"num_more_views", target.num_more_views ? json(*target.num_more_views) : json(nullptr)},
          {"forecast_px", orNull(target.forecast_px)}};
}

}  // namespace

std::string adviceText(const Advice& advice, ImageSize size) {
  return labelled("Coverage", coverageText(advice.coverage)) +
         labelled("Next", nextViewText(advice.guidance, size)) +
         labelled("Target", targetText(advice.guidance));
}

void addAdvice(const Advice& advice, json& document) {
  document["coverage"] = coverageJson(advice.coverage);
  document["next_view"] = nextViewJson(advice.guidance);
  document["target"] = targetJson(advice.guidance);
}

double parsePixels(const std::string& text, const std::string& where) {
  std::string_view number = trim(text);
  if (number.ends_with("px")) number = trim(number.substr(0, number.size() - 2));
  const auto value = parseDouble(number);
  if (value && std::isfinite(*value) && *value > 0) return *value;
  throw usageError({.where = where,
                    .found = "'" + text + "'",
                    .expected = "a positive number of pixels",
                    .next_step = "for example: 0.1px"});
}

}  // namespace alidade
