// SPDX-License-Identifier: MIT
#include "uncertainty_output.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/record/camera_record.h"

namespace alidade {
namespace {

using nlohmann::json;

json orNull(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

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

std::string parameterTable(const CalibrationResult& result) {
  std::string text = result.by_views
                         ? "Parameters (value, one sigma by the corners' noise, one by the views)\n"
                         : "Parameters (value, one sigma)\n";
  const auto names = result.camera.parameterNames();
  const auto values = result.camera.parameters();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int index = static_cast<int>(i);
    const double std = result.parameterStd(index);
    // Two digits of the sigma decide how many of the value are worth reading.
    const bool is_held = std::find(result.held.begin(), result.held.end(), index) != result.held.end();
    const bool has_sigma = std::isfinite(std) && std > 0;
    const int decimals = has_sigma ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 9) : 6;
    text += fmt::format("  {:<4} {:>14.{}f}", names[i], values[i], decimals);
    text += has_sigma ? fmt::format("  +- {:.{}f}", std, decimals) : is_held ? "  held" : "  sigma unknown";
    if (has_sigma && result.by_views)
      text += fmt::format("  +- {:.{}f}", result.by_views->effectiveStd(index), decimals);
    text += has_sigma && i < 4 ? " px\n" : "\n";
  }
  if (const auto correlation = result.strongestCorrelation()) {
    text += fmt::format(
        "         {0} and {1} are known better together than alone (correlation {2:.3f}): where {0} is too "
        "large, {1} is too {3}\n",
        names[static_cast<std::size_t>(correlation->first)],
        names[static_cast<std::size_t>(correlation->second)], correlation->value,
        correlation->value < 0 ? "small" : "large");
  }
  return text;
}

// What no sigma says.
std::string spreadText(const CalibrationResult& result) {
  if (!result.model_spread) return "";
  const ModelSpread& spread = *result.model_spread;
  std::string text = fmt::format(
      "  {:<14} {}, which predicts corners as well, differs by up to {:.2g} px, at pixel ({:.0f}, {:.0f})",
      "by the model", spread.id, spread.worst_px, spread.worst_pixel.x(), spread.worst_pixel.y());
  if (spread.share_apart > 0) {
    text +=
        fmt::format("; by more than {:.0f} px in {:.2g} % of the image", kApartPx, 100 * spread.share_apart);
  }
  return text + "\n";
}

std::string projectionText(const CalibrationResult& result) {
  if (!result.projection_far) return "";
  std::string text = "Projection, one sigma: how far a point's pixel may be off for the parameters' sake\n";
  text += fmt::format("  {:<14} {}\n", "far away", gridText(*result.projection_far));
  text += fmt::format("  {:<14} {}\n", "pose fitted", gridText(*result.projection_near));
  return text + spreadText(result);
}

void addUncertainty(const CalibrationResult& result, nlohmann::json& document) {
  json parameters = json::object();
  json sigmas = json::object();
  json by_view = json::object();
  const auto names = result.camera.parameterNames();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string name(names[i]);
    const int index = static_cast<int>(i);
    parameters[name] = result.camera.parameters()[i];
    sigmas[name] = orNull(result.parameterStd(index));
    if (result.by_views) by_view[name] = orNull(result.by_views->effectiveStd(index));
  }
  document["parameters"] = std::move(parameters);
  document["parameter_order"] = names;  // that of the covariances; an object has none
  document["parameter_std"] = std::move(sigmas);
  document["parameter_std_by_view"] = result.by_views ? std::move(by_view) : json(nullptr);
  document["view_excess"] = result.by_views ? json({{"variance_ratio", result.by_views->excess},
                                                    {"sigmas", result.by_views->excess_sigmas},
                                                    {"exceeded", result.isNoiseExceeded()}})
                                            : json(nullptr);
  document["covariance"] = result.covariance ? json(lowerTriangle(*result.covariance)) : json(nullptr);
  document["stated_covariance"] =
      result.covariance ? json(lowerTriangle(result.statedCovariance())) : json(nullptr);
  json correlation = nullptr;
  if (const auto strongest = result.strongestCorrelation()) {
    correlation = {{"parameters",
                    {names[static_cast<std::size_t>(strongest->first)],
                     names[static_cast<std::size_t>(strongest->second)]}},
                   {"value", strongest->value}};
  }
  document["strongest_correlation"] = std::move(correlation);
  json projection = nullptr;
  if (result.projection_far) {
    projection = {{"infinity", gridJson(*result.projection_far)},
                  {"board_distance", gridJson(*result.projection_near)},
                  {"board_distance_m", result.board_distance_m}};
  }
  document["projection_std"] = std::move(projection);
  json spread = nullptr;
  if (result.model_spread) {
    spread = {{"model", result.model_spread->id},
              {"share_apart", result.model_spread->share_apart},
              {"apart_px", kApartPx},
              {"worst_px", result.model_spread->worst_px},
              {"worst_pixel", {result.model_spread->worst_pixel.x(), result.model_spread->worst_pixel.y()}}};
  }
  document["model_spread"] = std::move(spread);
}

}  // namespace alidade
