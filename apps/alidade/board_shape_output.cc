// SPDX-License-Identifier: MIT
#include "board_shape_output.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include "command.h"

namespace alidade {
namespace {

using nlohmann::json;

// "1.02 +- 0.01"
std::string millimetres(double value_m, double std_m) {
  const double std = 1e3 * std_m;
  const int decimals = std > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 6) : 6;
  return fmt::format("{:.{}f} +- {:.{}f}", 1e3 * value_m, decimals, std, decimals);
}

// What the two tests for a bend say.
std::string bendTests(const ShapeReport& shape) {
  if (!shape.by_views) return fmt::format("F = {:.3g}", shape.f);
  return fmt::format("F = {:.3g} from corner noise, {:.3g} between views, p-value {:.2g} %", shape.f,
                     shape.by_views->f, 100 * shape.by_views->chance);
}

}  // namespace

std::string boardShapeText(const Calibration& result) {
  const ShapeReport& shape = result.choice.shape;
  const Eigen::Vector2d& std_m = result.uncertainty.bend_std_m;
  if (!shape.is_determined) return "Board    assumed flat: these views cannot show whether it is bent\n";
  if (!isShapeEstimated(result.fit)) {
    if (!std::isfinite(shape.f)) return "Board    assumed flat\n";
    return fmt::format("Board    flat: {} ({}; standard deviation {:.2g} and {:.2g} mm)\n",
                       shape.f > kBendF ? "the views do not agree on a bend" : "no bend detected",
                       bendTests(shape), 1e3 * std_m.x(), 1e3 * std_m.y());
  }
  const BoardShape& bend = onlyBoard(result.fit).shape;
  return fmt::format(
      "Board    bent ({}): its centre is {} mm behind its left and right edges and {} mm behind its top and "
      "bottom edges;\n         assuming a flat board, RMS would be {:.4g} px and fx {:.2f} instead of {:.2f} "
      "px\n",
      bendTests(shape), millimetres(bend.bend_x_m, std_m.x()), millimetres(bend.bend_y_m, std_m.y()),
      shape.flat_rms_px, shape.flat_params[0], onlyCamera(result.fit).params[0]);
}

json boardShapeJson(const Calibration& result) {
  const ShapeReport& shape = result.choice.shape;
  const bool is_estimated = isShapeEstimated(result.fit);
  const BoardShape bend = is_estimated ? onlyBoard(result.fit).shape : BoardShape{};
  const Eigen::Vector2d& std_m = result.uncertainty.bend_std_m;
  json by_views = nullptr;
  if (shape.by_views) {
    by_views = {{"f", shape.by_views->f},
                {"freedom", shape.by_views->freedom},
                {"chance", shape.by_views->chance},
                {"bend_x_std_m", orNull(shape.by_views->std_m.x())},
                {"bend_y_std_m", orNull(shape.by_views->std_m.y())}};
  }
  return {{"estimated", is_estimated},
          {"determined", shape.is_determined},
          {"f", orNull(shape.f)},
          {"by_views", std::move(by_views)},
          {"bend_x_m", bend.bend_x_m},
          {"bend_y_m", bend.bend_y_m},
          {"bend_x_std_m", orNull(std_m.x())},
          {"bend_y_std_m", orNull(std_m.y())},
          {"flat_rms_px", orNull(shape.flat_rms_px)},
          {"flat_parameters", shape.flat_params}};
}

}  // namespace alidade
