// SPDX-License-Identifier: MIT
#include "alidade/report/page.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/report/image_figures.h"
#include "alidade/report/lens_figures.h"
#include "alidade/report/page_shell.h"
#include "alidade/report/residual_figures.h"
#include "alidade/report/rig_page.h"
#include "alidade/report/scene_figure.h"
#include "alidade/report/undistorted_figure.h"
#include "alidade/report/view_figures.h"
#include "alidade/report/view_sheet.h"

namespace alidade {
namespace {

using nlohmann::json;

std::string accuracySentence(const ReportData& data) {
  if (!data.accuracy) return "The accuracy is unknown, because the views do not determine the camera.";
  const ReportedAccuracy& accuracy = *data.accuracy;
  const std::string of =
      std::isinf(accuracy.distance_m) ? "" : fmt::format(" {:g} m away", accuracy.distance_m);
  return fmt::format(
      "In 95 of 100 cases a projected point{} is within {} of the truth where boards were seen "
      "({:.0f}\u00a0% of the image). {:.0f}\u00a0% of the image is within your tolerance of "
      "{:g}\u00a0px; the worst place is {} off.",
      of, errorText(accuracy.covered_px), 100 * accuracy.covered_share,
      100 * accuracy.shareWithin(data.tolerance_px), data.tolerance_px, errorText(accuracy.worst_px));
}

std::vector<PageNumber> numbersOf(const ReportData& data) {
  std::vector<PageNumber> numbers;
  const auto add = [&](const char* name, const std::string& value, const std::string& more) {
    numbers.push_back({.name = name, .value = value, .more = more});
  };
  if (data.accuracy) {
    add("Accuracy", errorText(data.accuracy->covered_px), "95 %, where boards were seen");
    add("Within tolerance", fmt::format("{:.0f} %", 100 * data.accuracy->shareWithin(data.tolerance_px)),
        fmt::format("of the image, {:g} px", data.tolerance_px));
  }
  add("Reprojection error", fmt::format("{:.3f} px", data.rms_px), "RMS of all corners");
  add("Cross-validation",
      std::isfinite(data.holdout_rms_px) ? fmt::format("{:.3f} px", data.holdout_rms_px) : "impossible",
      "RMS of unseen corners");
  add("Images", fmt::format("{} of {}", data.num_images_used, data.num_images_given),
      "used for the calibration");
  add("Corners", std::to_string(data.num_corners),
      data.num_outliers == 0 ? "no outliers" : fmt::format("{} outliers left out", data.num_outliers));
  return numbers;
}

std::string parametersHtml(const ReportData& data) {
  std::string html =
      "<figure id=\"parameters\"><h3>Parameters</h3><div class=\"scroll\"><table><thead><tr><th "
      "scope=\"col\">Parameter</th><th scope=\"col\">Value</th><th scope=\"col\">Standard deviation</th></tr>"
      "</thead><tbody>\n";
  const auto names = data.camera.parameterNames();
  const auto values = data.camera.parameters();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double std = data.parameter_std[i];
    const bool is_fixed = !(std > 0) || !std::isfinite(std);
    const int decimals = is_fixed ? 0 : std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, 8);
    html +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", names[i],
                    is_fixed ? fmt::format("{:.6g}", values[i]) : fmt::format("{:.{}f}", values[i], decimals),
                    std::isnan(std) ? "unknown"
                    : is_fixed      ? "fixed"
                                    : fmt::format("{:.{}f}", std, decimals));
  }
  return html +
         "</tbody></table></div><figcaption class=\"reading\">The true value lies within two standard "
         "deviations in 95 of "
         "100 cases; a parameter whose standard deviation exceeds it is not determined by these photographs."
         "</figcaption></figure>\n";
}

std::string modelsHtml(const ReportData& data) {
  if (data.models.empty()) return "";
  std::string html =
      "<figure id=\"models\" class=\"wide\"><h3>Candidate lens models</h3><div "
      "class=\"scroll\"><table><thead><tr>"
      "<th scope=\"col\">Model</th><th scope=\"col\">Parameters</th><th scope=\"col\">RMS, px</th><th "
      "scope=\"col\">"
      "Cross-validation, px</th><th scope=\"col\" class=\"words\">Result</th></tr></thead><tbody>\n";
  const auto px = [](double value) {
    return std::isfinite(value) ? fmt::format("{:.4f}", value) : std::string("–");
  };
  for (const ReportedModel& model : data.models) {
    const bool is_chosen = model.verdict == "chosen";
    html += fmt::format(
        "<tr{}><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"words\">{}</td></tr>\n",
        is_chosen ? " class=\"chosen\"" : "", escapedMarkup(model.id), model.num_params, px(model.rms_px),
        px(model.holdout_rms_px), is_chosen ? "chosen" : escapedMarkup(model.reason));
  }
  return html +
         "</tbody></table></div><figcaption class=\"reading\">Cross-validation measures the error on corners "
         "that were not "
         "used for the fit: a larger model that does not lower it only fits noise.</figcaption></figure>\n";
}

std::string detailsHtml(const ReportData& data, const json& evidence) {
  std::string html;
  std::vector<std::string> boards;
  for (const ReportedBoard& board : data.boards) {
    const bool is_flat = board.shape == BoardShape{};
    boards.push_back(board.target.spec() +
                     (is_flat ? ", flat"
                              : fmt::format(", bent by {:.2g} mm in x and {:.2g} mm in y",
                                            1e3 * board.shape.bend_x_m, 1e3 * board.shape.bend_y_m)));
    const Eigen::Vector2d rms_m = offsetRms(board.shape);
    if (!board.shape.offsets_m.empty()) {
      boards.back() += fmt::format("; {} {:.2g} mm off in the plane and {:.2g} mm across it (RMS)",
                                   board.target.words().points, 1e3 * rms_m.x(), 1e3 * rms_m.y());
    }
  }
  html += listHtml(boards.size() == 1 ? "Board" : "Boards", boards);
  html += listHtml(fmt::format("{} image{} without a usable board", data.reasons.size(),
                               data.reasons.size() == 1 ? "" : "s"),
                   data.reasons);
  html += listHtml("Notes of the detection", data.notes);
  std::vector<std::string> settings;
  const json given = evidence.value("settings", json::object());
  for (const auto& [name, values] : given.items()) {
    std::string line = "--" + name;
    for (const json& value : values)
      line += " " + (value.is_string() ? value.get<std::string>() : value.dump());
    settings.push_back(line);
  }
  return html + listHtml("Settings", settings);
}

std::vector<PageSection> sectionsOf(const ReportData& data, const PageOptions& options) {
  std::vector<PageSection> sections;
  PageSection accuracy{.id = "where", .title = "Where the camera is accurate"};
  if (data.accuracy) accuracy.figures.push_back(accuracyFigure(data));
  accuracy.figures.push_back(coverageFigure(data));
  sections.push_back(std::move(accuracy));
  PageSection next{.id = "how", .title = "How the board was held"};
  if (data.next_view) next.figures.push_back(nextViewFigure(data));
  next.figures.push_back(tiltFigure(data));
  next.figures.push_back(distanceFigure(data));
  next.figures.push_back(sceneFigure(data));
  sections.push_back(std::move(next));
  PageSection errors{.id = "errors", .title = "Reprojection errors"};
  errors.figures.push_back(imageResidualsFigure(data));
  for (std::size_t b = 0; b < data.boards.size(); ++b) {
    const bool is_used =
        std::ranges::any_of(data.views, [&](const ReportedView& view) { return view.board == b; });
    if (is_used) errors.figures.push_back(boardResidualsFigure(data, b));
  }
  errors.figures.push_back(histogramFigure(data));
  errors.figures.push_back(normalPlotFigure(data));
  sections.push_back(std::move(errors));
  sections.push_back({.id = "views", .title = "Views", .figures = {viewErrorsFigure(data)}, .more = {}});
  PageSection lens{
      .id = "lens", .title = "Lens", .figures = {distortionGridFigure(data), radialFigure(data)}};
  if (std::optional<Figure> figure = undistortedFigure(data, options.pictures.image_of))
    lens.figures.push_back(*std::move(figure));
  if (options.rival) lens.figures.push_back(differenceFigure(data, *options.rival));
  sections.push_back(std::move(lens));
  PageSection parameters{.id = "values", .title = "Parameters and models"};
  if (data.covariance) parameters.figures.push_back(correlationFigure(data));
  sections.push_back(std::move(parameters));
  return sections;
}

// The page of a rig has neither pictures of views nor another camera.
void refuseCameraOptions(const std::string& file, const PageOptions& options) {
  if (!options.pictures.image_of && !options.rival) return;
  throw usageError(
      {.where = file,
       .found = std::string("the evidence of a rig, with ") + (options.rival ? "--against" : "--images"),
       .expected = "the evidence of one camera",
       .next_step = options.rival ? "compare rigs with alidade diff" : "leave --images out"});
}

}  // namespace

std::string reportPage(const json& evidence, const std::string& file, const PageOptions& options) {
  if (isRigEvidence(evidence)) {
    refuseCameraOptions(file, options);
    return rigPage(evidence, file);
  }
  const ReportData data = readReportData(evidence, file);
  PageOptions keeping = options;
  keeping.pictures.image_of = keepingOne(options.pictures.image_of, undistortedImageName(data));
  const std::vector<std::string> pictures = viewPictures(data, keeping.pictures, options.num_jobs);
  PageContent page{
      .title = fmt::format("{}, {} × {} px", data.camera.modelId(), data.size.width, data.size.height),
      .subject = "camera",
      .verdict = data.verdict,
      .sentence = accuracySentence(data),
      .findings = data.findings,
      .numbers = numbersOf(data),
      .sections = sectionsOf(data, keeping),
      .details = detailsHtml(data, evidence),
      .dialog = viewerHtml(),
      .created_by = data.created_by};
  for (const ReportedBoard& board : data.boards)
    page.subtitle += (page.subtitle.empty() ? "" : ", ") + board.target.spec();
  if (data.next_view) page.next_text = data.next_view->text;
  for (PageSection& section : page.sections) {
    if (section.id == "views") section.more = viewSheet(data, pictures);
    if (section.id == "values") section.more = parametersHtml(data) + modelsHtml(data);
  }
  return pageText(page, evidence);
}

std::vector<FigureFile> reportFigures(const json& evidence, const std::string& file,
                                      const PageOptions& options) {
  if (isRigEvidence(evidence)) {
    refuseCameraOptions(file, options);
    return rigFigures(evidence, file);
  }
  return figureFiles(sectionsOf(readReportData(evidence, file), options));
}

}  // namespace alidade
