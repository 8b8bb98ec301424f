// SPDX-License-Identifier: MIT
#include "uncertainty_output.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/record/camera_record.h"
#include "command.h"

namespace alidade {
namespace {

using nlohmann::json;

// "0.012 px at the image's centre, at worst 0.31 px at pixel (0, 0)"
std::string gridText(const UncertaintyGrid& grid) {
  const std::string center = std::isfinite(grid.center_px)
                                 ? fmt::format("{:.2g} px at the image's centre", grid.center_px)
                                 : "no ray at the image's centre";
  if (!std::isfinite(grid.worst_px)) return center + ", unknown elsewhere";
  return fmt::format("{}, at worst {:.2g} px at pixel ({:.0f}, {:.0f})", center, grid.worst_px,
                     grid.worst_pixel.x(), grid.worst_pixel.y());
}

json gridJson(const UncertaintyGrid& grid) {
  json rows = json::array();
  for (int row = 0; row < grid.rows; ++row) {
    json values = json::array();
    for (int column = 0; column < grid.columns; ++column)
      values.push_back(orNull(grid.std_px[static_cast<std::size_t>(row * grid.columns + column)]));
    rows.push_back(std::move(values));
  }
  return {{"columns", grid.columns},
          {"rows", grid.rows},
          {"center_px", orNull(grid.center_px)},
          {"worst_px", orNull(grid.worst_px)},
          {"worst_pixel", {orNull(grid.worst_pixel.x()), orNull(grid.worst_pixel.y())}},
          {"std_px", std::move(rows)}};
}

}  // namespace

std::string projectionText(const Calibration& result) {
  if (!result.uncertainty.projection_far) return "";
  std::string text = "Projection, one sigma: how far a point's pixel may be off for the parameters' sake\n";
  text += fmt::format("  {:<14} {}\n", "far away", gridText(*result.uncertainty.projection_far));
  text += fmt::format("  {:<14} {}\n", "pose fitted", gridText(*result.uncertainty.projection_near));
  return text;
}

void addUncertainty(const Calibration& result, nlohmann::json& document) {
  json parameters = json::object();
  json sigmas = json::object();
  json by_view = json::object();
  const auto names = parameterNames(onlyCamera(result.fit).model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name(names[i]);
    const int index = static_cast<int>(i);
    parameters[name] = onlyCamera(result.fit).params[i];
    sigmas[name] = orNull(result.uncertainty.parameterStd(index));
    if (result.uncertainty.by_views) by_view[name] = orNull(result.uncertainty.by_views->effectiveStd(index));
  }
  document["parameters"] = std::move(parameters);
  document["parameter_order"] = names;  // that of the covariances; an object has none
  document["parameter_std"] = std::move(sigmas);
  document["parameter_std_by_view"] = result.uncertainty.by_views ? std::move(by_view) : json(nullptr);
  document["view_excess"] = result.uncertainty.by_views
                                ? json({{"variance_ratio", result.uncertainty.by_views->excess},
                                        {"sigmas", result.uncertainty.by_views->excess_sigmas},
                                        {"exceeded", result.uncertainty.isNoiseExceeded()}})
                                : json(nullptr);
  document["covariance"] =
      result.uncertainty.covariance ? json(lowerTriangle(*result.uncertainty.covariance)) : json(nullptr);
  document["stated_covariance"] = result.uncertainty.covariance
                                      ? json(lowerTriangle(result.uncertainty.statedCovariance()))
                                      : json(nullptr);
  json correlation = nullptr;
  if (const auto strongest = result.uncertainty.strongestCorrelation()) {
    correlation = {{"parameters",
                    {names[static_cast<std::size_t>(strongest->first)],
                     names[static_cast<std::size_t>(strongest->second)]}},
                   {"value", strongest->value}};
  }
  document["strongest_correlation"] = std::move(correlation);
  json projection = nullptr;
  if (result.uncertainty.projection_far) {
    projection = {{"infinity", gridJson(*result.uncertainty.projection_far)},
                  {"board_distance", gridJson(*result.uncertainty.projection_near)},
                  {"board_distance_m", result.uncertainty.board_distance_m}};
  }
  document["projection_std"] = std::move(projection);
}

}  // namespace alidade
