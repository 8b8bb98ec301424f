// SPDX-License-Identifier: MIT
#include "board_shape_output.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace alidade {
namespace {

using nlohmann::json;

json orNull(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

// "1.02 +- 0.01"
std::string millimetres(double value_m, double std_m) {
  const double std = 1e3 * std_m;
  const int decimals = std > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 6) : 6;
  return fmt::format("{:.{}f} +- {:.{}f}", 1e3 * value_m, decimals, std, decimals);
}

// What the two tests for a bend say.
std::string bendTests(const EstimatedShape& shape) {
  if (!shape.by_views) return fmt::format("F = {:.3g}", shape.f);
  return fmt::format("F = {:.3g} from corner noise, {:.3g} between views, p-value {:.2g} %", shape.f,
                     shape.by_views->f, 100 * shape.by_views->chance);
}

}  // namespace

std::string boardShapeText(const CalibrationResult& result) {
  const EstimatedShape& shape = result.shape;
  if (!shape.is_determined) return "Board    assumed flat: these views cannot show whether it is bent\n";
  if (!shape.is_estimated) {
    if (!std::isfinite(shape.f)) return "Board    assumed flat\n";
    return fmt::format("Board    flat: {} ({}; standard deviation {:.2g} and {:.2g} mm)\n",
                       shape.f > kBendF ? "the views do not agree on a bend" : "no bend detected",
                       bendTests(shape), 1e3 * shape.std_m.x(), 1e3 * shape.std_m.y());
  }
  const auto parameters = result.camera.parameters();
  return fmt::format(
      "Board    bent ({}): its centre is {} mm behind its left and right edges and {} mm behind its top and "
      "bottom edges;\n         assuming a flat board, RMS would be {:.4g} px and fx {:.2f} instead of {:.2f} "
      "px\n",
      bendTests(shape), millimetres(shape.shape.bend_x_m, shape.std_m.x()),
      millimetres(shape.shape.bend_y_m, shape.std_m.y()), shape.flat_rms_px, shape.flat_params[0],
      parameters[0]);
}

json boardShapeJson(const EstimatedShape& shape) {
  json by_views = nullptr;
  if (shape.by_views) {
    by_views = {{"f", shape.by_views->f},
                {"freedom", shape.by_views->freedom},
                {"chance", shape.by_views->chance},
                {"bend_x_std_m", orNull(shape.by_views->std_m.x())},
                {"bend_y_std_m", orNull(shape.by_views->std_m.y())}};
  }
  return {{"estimated", shape.is_estimated},
          {"determined", shape.is_determined},
          {"f", orNull(shape.f)},
          {"by_views", std::move(by_views)},
          {"bend_x_m", shape.shape.bend_x_m},
          {"bend_y_m", shape.shape.bend_y_m},
          {"bend_x_std_m", orNull(shape.std_m.x())},
          {"bend_y_std_m", orNull(shape.std_m.y())},
          {"flat_rms_px", orNull(shape.flat_rms_px)},
          {"flat_parameters", shape.flat_params}};
}

}  // namespace alidade
