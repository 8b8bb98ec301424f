// SPDX-License-Identifier: MIT
#include "alidade/report/validation_figures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "alidade/report/difference_figure.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

// With as many decimals as the standard deviation makes sense of.
std::string valueText(double value, double std) {
  if (!(std > 0) || !std::isfinite(std)) return fmt::format("{:.6g}", value);
  const std::string text =
      fmt::format("{:.{}f}", value, std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 8));
  // No "-0.00".
  return text.find_first_of("123456789") == std::string::npos && text[0] == '-' ? text.substr(1) : text;
}

std::string stdText(double std) {
  if (std::isnan(std)) return "–";
  if (!(std > 0)) return "fixed";
  return valueText(std, std);
}

}  // namespace

Figure fixedFreedFigure(const ReportData& data, const ReportedHeldOut& tested) {
  double most = 0;
  for (const auto* values : {&tested.view_fixed_px, &tested.view_freed_px})
    for (const double value : *values)
      if (std::isfinite(value)) most = std::max(most, value);
  if (!(most > 0)) most = 1;
  const auto count = static_cast<double>(data.views.size());
  const PlotArea area{
      .box = {Vector2d(44, 24), Vector2d(890, 190)}, .low = {0.5, 0}, .high = {count + 0.5, 1.06 * most}};
  FigureCanvas canvas(229, 900);
  canvas.addAxes(area, "view, in order of image names", "error, px");
  const double gap = count <= 120 ? 0.12 : 0;
  std::size_t num_better = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const double x = static_cast<double>(v) + 1;
    const double fixed = tested.view_fixed_px[v];
    const double freed = tested.view_freed_px[v];
    num_better += freed < fixed ? 1 : 0;
    const auto addBar = [&](double left, double right, double value, const char* kind) {
      if (!std::isfinite(value)) return;
      canvas.addRect(
          area.at(left, value), area.at(right, 0),
          fmt::format("class=\"{}\" data-view=\"{}\" data-rms=\"{:.9g}\"", kind, data.first_view + v, value));
    };
    addBar(x - 0.5 + gap, x, fixed, "bar");
    addBar(x, x + 0.5 - gap, freed, "bar freed");
  }
  canvas.addLegend(
      {area.box.min().x(), 229},
      {{"bar", fmt::format("camera of the file, {} px RMS", shortNumber(tested.fixed_rms_px))},
       {"bar freed", fmt::format("camera of these images, {} px RMS", shortNumber(tested.freed_rms_px))}});
  Figure figure{.id = "fixed-freed", .title = "Fixed against freed", .is_wide = true};
  figure.reading =
      "Each pair of bars is a view: its error with the camera of the file, and with the camera that these "
      "images give by themselves. Where the first bars are clearly higher, the file is not of the camera "
      "that "
      "took the images.";
  figure.alt = fmt::format(
      "RMS of {} views: {} px with the camera of the file, and {} px with the camera that the images give; "
      "{} views are better with that one.",
      data.views.size(), shortNumber(tested.fixed_rms_px), shortNumber(tested.freed_rms_px), num_better);
  figure.svg = canvas.svg(figure.alt);
  return figure;
}

Figure freedDifferenceFigure(const ReportData& data, const ReportedHeldOut& tested) {
  RivalCamera rival{.name = "the camera of these images", .camera = tested.freed->camera, .size = data.size};
  if (tested.freed->covariance) rival.covariance = *tested.freed->covariance;
  Figure figure = differenceFigure(data, rival);
  figure.id = "freed-difference";
  figure.reading +=
      " These images say little about parts of the image where they show no board: differences there may be "
      "chance.";
  return figure;
}

std::string judgedParameters(const ReportedCameraJudgement& judged, const std::string& prefix) {
  const ReportData& data = *judged.data;
  const ReportedFreed* const freed =
      judged.held_out && judged.held_out->freed ? &*judged.held_out->freed : nullptr;
  const bool has_std = std::ranges::any_of(data.parameter_std, [](double s) { return !std::isnan(s); });
  std::string html = fmt::format(
      "<figure id=\"{}parameters\"{}><h3>{}</h3><div class=\"scroll\"><table><thead><tr><th "
      "scope=\"col\">Parameter</th><th scope=\"col\">In the file</th>{}{}</tr></thead><tbody>\n",
      prefix, freed != nullptr ? " class=\"wide\"" : "",
      freed != nullptr ? "Values in the file and by these images" : "Values in the file",
      has_std ? "<th scope=\"col\">Standard deviation</th>" : "",
      freed != nullptr ? "<th scope=\"col\">By these images</th><th scope=\"col\">Standard deviation</th><th "
                         "scope=\"col\">Difference</th>"
                       : "");
  const auto names = data.camera.parameterNames();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double value = data.camera.parameters()[i];
    html += fmt::format("<tr><td>{}</td><td>{}</td>", names[i], valueText(value, data.parameter_std[i]));
    if (has_std) html += fmt::format("<td>{}</td>", stdText(data.parameter_std[i]));
    if (freed != nullptr) {
      const double other = freed->camera.parameters()[i];
      const double std = freed->parameter_std[i];
      html += fmt::format("<td>{}</td><td>{}</td><td>{}</td>", valueText(other, std), stdText(std),
                          valueText(other - value, std));
    }
    html += "</tr>\n";
  }
  const char* const reading =
      freed != nullptr
          ? "Parameters can make up for each other: a difference of a few standard deviations matters only "
            "where the map of the difference shows it."
      : has_std ? "The true value lies within two standard deviations in 95 of 100 cases, as the file states."
                : "The file states no standard deviations.";
  return html + fmt::format("</tbody></table></div><figcaption class=\"reading\">{}</figcaption></figure>\n",
                            reading);
}

}  // namespace alidade
