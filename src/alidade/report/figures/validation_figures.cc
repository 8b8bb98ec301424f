// SPDX-License-Identifier: MIT
#include "alidade/report/figures/validation_figures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/data/distinct_parts.h"
#include "alidade/report/figures/camera_figures.h"

namespace alidade {

Figure fixedFreedFigure(const JudgedCamera& camera) {
  const ReportData& data = *camera.data;
  const HeldOutJudgement& held_out = *camera.heldOut();
  double most = 0;
  for (const HeldOutView* view : camera.tested)
    for (const double value : {view->fixed_rms_px, view->freed_rms_px})
      if (std::isfinite(value)) most = std::max(most, value);
  if (!(most > 0)) most = 1;
  const auto count = static_cast<double>(data.views.size());
  FigureCanvas canvas(Eigen::Vector2d(0.5, 0), Eigen::Vector2d(count + 0.5, 1.06 * most));
  canvas.addNamedAxes(distinctParts(mapped(data.views, &ReportedView::image)), "image", "error, px");
  const double gap = count <= 120 ? 0.12 : 0;
  std::size_t num_better = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const double x = static_cast<double>(v) + 1;
    const double fixed = camera.tested[v]->fixed_rms_px;
    const double freed = camera.tested[v]->freed_rms_px;
    num_better += freed < fixed ? 1 : 0;
    const auto addBar = [&](double left, double right, double value, const char* kind) {
      if (!std::isfinite(value)) return;
      canvas.addRect(
          canvas.at(left, value), canvas.at(right, 0),
          fmt::format("class=\"{}\" data-view=\"{}\" data-rms=\"{:.9g}\"", kind, data.first_view + v, value));
    };
    addBar(x - 0.5 + gap, x, fixed, "bar");
    addBar(x, x + 0.5 - gap, freed, "bar freed");
  }
  const std::string fixed_rms = shortNumber(held_out.fixed_rms_px);
  const std::string freed_rms = shortNumber(held_out.freedRmsPx());
  return canvas.drawn(
      {.id = "fixed-freed",
       .title = "Fixed against freed",
       .reading = "Each pair of bars is a view: its error with the camera of the file, and with the camera "
                  "that these images give by themselves. Where the first bars are clearly higher, the file "
                  "is not of the camera that took the images.",
       .alt = fmt::format(
           "RMS of {} views: {} px with the camera of the file, and {} px with the camera that the images "
           "give; {} views are better with that one.",
           data.views.size(), fixed_rms, freed_rms, num_better)},
      {{"bar", fmt::format("camera of the file, {} px RMS", fixed_rms)},
       {"bar freed", fmt::format("camera of these images, {} px RMS", freed_rms)}});
}

Figure freedDifferenceFigure(const ReportData& data, const Calibration& freed) {
  RivalCamera rival{.name = "the camera of these images", .camera = freed.camera(), .size = data.size};
  if (freed.uncertainty.covariance) rival.covariance = freed.uncertainty.statedCovariance();
  Figure figure = differenceFigure(data, rival);
  figure.id = "freed-difference";
  figure.reading +=
      " These images say little about parts of the image where they show no board: differences there may be "
      "chance.";
  return figure;
}

std::string judgedParameters(const JudgedCamera& judged, const std::string& prefix) {
  const ReportData& data = *judged.data;
  const HeldOutJudgement* const held_out = judged.heldOut();
  const Calibration* const freed = held_out != nullptr && held_out->freed ? &*held_out->freed : nullptr;
  const bool has_std = std::ranges::any_of(data.parameter_std, [](double s) { return !std::isnan(s); });
  std::vector<PageColumn> columns = {{"Parameter"}, {"In the file"}};
  if (has_std) columns.push_back({"Standard deviation"});
  if (freed != nullptr)
    columns.insert(columns.end(), {{"By these images"}, {"Its standard deviation"}, {"Difference"}});
  std::vector<PageRow> rows;
  const auto names = data.camera.parameterNames();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double value = data.camera.parameters()[i];
    const double std = data.parameter_std[i];
    PageRow row{.cells = {std::string(names[i]), valueText(value, std)},
                .kind = isUndetermined(value, std) ? "weak" : ""};
    if (has_std) row.cells.push_back(deviationText(value, std));
    if (freed != nullptr) {
      const double other = onlyCamera(freed->fit).params[i];
      const double other_std = freed->uncertainty.parameterStd(static_cast<int>(i));
      row.cells.insert(row.cells.end(), {valueText(other, other_std), deviationText(other, other_std),
                                         valueText(other - value, other_std)});
    }
    rows.push_back(std::move(row));
  }
  const char* const reading =
      freed != nullptr
          ? "Parameters can make up for each other: a difference of a few standard deviations matters only "
            "where the map of the difference shows it."
      : has_std ? "The true value lies within two standard deviations in 95 of 100 cases, as the file states."
                : "The file states no standard deviations.";
  return tableFigure(prefix + "parameters",
                     freed != nullptr ? "Values in the file and by these images" : "Values in the file",
                     columns, rows, reading);
}

}  // namespace alidade
