// SPDX-License-Identifier: MIT
#include "alidade/report/page.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/report/image_figures.h"
#include "alidade/report/lens_figures.h"
#include "alidade/report/report_assets.h"
#include "alidade/report/residual_figures.h"
#include "alidade/report/scene_figure.h"
#include "alidade/report/undistorted_figure.h"
#include "alidade/report/view_figures.h"

namespace alidade {
namespace {

using nlohmann::json;

struct Section {
  std::string id;
  std::string title;
  std::vector<Figure> figures = {};
  std::string more = {};  // HTML after the figures
};

// An error, with two digits as in the summary.
std::string errorText(double px) {
  return (px >= 100 ? fmt::format("{:.0f}", px) : twoDigits(px)) + "\u00a0px";
}

struct VerdictWords {
  const char* kind;
  const char* words;
};

VerdictWords verdictWords(Verdict verdict) {
  if (verdict == Verdict::kTrustworthy) return {"good", "Trustworthy"};
  if (verdict == Verdict::kReservations) return {"fair", "Usable with reservations"};
  return {"bad", "Rejected: do not use this camera"};
}

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

std::string findingsHtml(const ReportData& data) {
  std::string list;
  std::string notes;
  int num_notes = 0;
  for (const Diagnosis& finding : data.findings) {
    const bool is_note = finding.severity <= Severity::kNote;
    const char* name = finding.severity == Severity::kFailure ? "Failure" : is_note ? "Note" : "Warning";
    const std::string effect =
        std::isfinite(finding.effect_px) && finding.effect_px > 0
            ? fmt::format(" Effect on projected points: up to {}.", errorText(finding.effect_px))
            : "";
    std::string sentence = finding.message();
    if (!sentence.empty() && sentence[0] >= 'a' && sentence[0] <= 'z')
      sentence[0] = static_cast<char>(sentence[0] - 'a' + 'A');
    std::string& to = is_note ? notes : list;
    num_notes += is_note ? 1 : 0;
    to += fmt::format("<li class=\"{}\"><span class=\"severity\">{}</span><span>{}.{}</span>",
                      severityName(finding.severity), name, escapedMarkup(sentence), effect);
    if (!finding.next_step.empty())
      to += fmt::format("<span class=\"todo\">What to do: {}.</span>", escapedMarkup(finding.next_step));
    to += "</li>\n";
  }
  if (data.next_view) {
    list += fmt::format(
        "<li class=\"advice\"><span class=\"severity\">Next</span><span>To improve the camera, take one more "
        "photograph: "
        "{} (<a href=\"#next-view\">see the drawing</a>).</span></li>\n",
        escapedMarkup(data.next_view->text));
  }
  std::string html = list.empty() ? "" : "<ul class=\"findings\">\n" + list + "</ul>\n";
  if (num_notes > 0) {
    html += fmt::format(
        "<details><summary>{} note{} without effect on the verdict</summary>\n<ul class=\"findings\">\n{}"
        "</ul></details>\n",
        num_notes, num_notes == 1 ? "" : "s", notes);
  }
  return html;
}

std::string numbersHtml(const ReportData& data) {
  std::string html = "<dl class=\"numbers\">\n";
  const auto add = [&](const char* name, const std::string& value, const std::string& more) {
    html += fmt::format("<div><dt>{}</dt><dd>{}<small>{}</small></dd></div>\n", name, escapedMarkup(value),
                        escapedMarkup(more));
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
  return html + "</dl>\n";
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

// Buttons with pictures, the largest error first.
std::string viewSheet(const ReportData& data, const std::vector<std::string>& pictures) {
  std::vector<std::size_t> order(data.views.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(
      order, [&](std::size_t a, std::size_t b) { return data.views[a].rms_px > data.views[b].rms_px; });
  std::string html =
      "<figure id=\"view-sheet\" class=\"wide\"><h3>Views, the largest error first</h3><figcaption "
      "class=\"reading\">Open a view to see its detected corners (circles) and where the camera projects "
      "them "
      "(crosses).</figcaption><div class=\"sheet-of-views\">\n";
  constexpr std::size_t kFew = 18;  // are all shown
  const std::size_t num_shown = order.size() <= kFew ? order.size() : 12;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == num_shown)
      html += fmt::format("</div><details><summary>{} more views</summary><div class=\"sheet-of-views\">\n",
                          order.size() - i);
    const std::size_t v = order[i];
    const ReportedView& view = data.views[v];
    const std::string name = escapedMarkup(view.image);
    const std::string words = fmt::format("RMS {:.3f} px", view.rms_px);
    html += fmt::format(
        "<button class=\"thumb\" type=\"button\" data-view=\"{}\" aria-label=\"Open view {}, {}\">", v, name,
        words);
    html += pictures[v].empty() ? cornersPicture(data, view)
                                : fmt::format("<img alt=\"\" width=\"{}\" height=\"{}\" src=\"{}\">",
                                              data.size.width, data.size.height, pictures[v]);
    html +=
        fmt::format("<span class=\"name\">{}</span><span class=\"error\">{}</span></button>\n", name, words);
  }
  return html + (order.size() > num_shown ? "</div></details></figure>\n" : "</div></figure>\n");
}

constexpr std::string_view kViewer =
    "<dialog id=\"viewer\" aria-labelledby=\"viewer-name\"><div class=\"viewer\"><header><h3 "
    "id=\"viewer-name\"></h3>"
    "<label>Errors drawn <select id=\"viewer-times\"><option value=\"1\">true to scale</option><option "
    "value=\"10\" "
    "selected>10 times longer</option><option value=\"50\">50 times longer</option><option value=\"200\">200 "
    "times "
    "longer</option></select></label>"
    "<button class=\"plain\" id=\"viewer-before\" type=\"button\" aria-label=\"Previous view\">←</button>"
    "<button class=\"plain\" id=\"viewer-after\" type=\"button\" aria-label=\"Next view\">→</button>"
    "<button class=\"plain\" id=\"viewer-close\" autofocus type=\"button\">Close</button></header>"
    "<svg id=\"viewer-drawing\" role=\"img\" aria-labelledby=\"viewer-words\" viewBox=\"-0.5 -0.5 WIDTH "
    "HEIGHT\"></svg>"
    "<footer><span id=\"viewer-words\"></span><span>circle: detected; cross: "
    "projected</span></footer></div></dialog>\n";

std::string listHtml(const std::string& title, const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string html = fmt::format("<details><summary>{}</summary><ul>\n", title);
  for (const std::string& line : lines) html += "<li>" + escapedMarkup(line) + "</li>\n";
  return html + "</ul></details>\n";
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

std::vector<Section> sectionsOf(const ReportData& data, const PageOptions& options) {
  std::vector<Section> sections;
  Section accuracy{.id = "where", .title = "Where the camera is accurate"};
  if (data.accuracy) accuracy.figures.push_back(accuracyFigure(data));
  accuracy.figures.push_back(coverageFigure(data));
  sections.push_back(std::move(accuracy));
  Section next{.id = "how", .title = "How the board was held"};
  if (data.next_view) next.figures.push_back(nextViewFigure(data));
  next.figures.push_back(tiltFigure(data));
  next.figures.push_back(distanceFigure(data));
  next.figures.push_back(sceneFigure(data));
  sections.push_back(std::move(next));
  Section errors{.id = "errors", .title = "Reprojection errors"};
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
  Section lens{.id = "lens", .title = "Lens", .figures = {distortionGridFigure(data), radialFigure(data)}};
  if (std::optional<Figure> figure = undistortedFigure(data, options.image_of))
    lens.figures.push_back(*std::move(figure));
  if (options.rival) lens.figures.push_back(differenceFigure(data, *options.rival));
  sections.push_back(std::move(lens));
  Section parameters{.id = "values", .title = "Parameters and models"};
  if (data.covariance) parameters.figures.push_back(correlationFigure(data));
  sections.push_back(std::move(parameters));
  return sections;
}

std::string figureHtml(const Figure& figure) {
  return fmt::format(
      "<figure id=\"{}\"{}><h3>{}</h3>\n{}<figcaption class=\"reading\">{}</figcaption></figure>\n",
      figure.id, figure.is_wide ? " class=\"wide\"" : "", escapedMarkup(figure.title), figure.svg,
      escapedMarkup(figure.reading));
}

// The evidence as text for a script element. A "<" could end that, and stands in texts alone.
std::string embeddedEvidence(const json& evidence) {
  json document = evidence;
  const auto rounded = [](json& value) {
    if (value.is_number_float()) value = std::round(1e4 * value.get<double>()) / 1e4;
  };
  for (json& view : document["views"]) {
    for (json& corner : view["corners"]) {
      for (const char* key : {"u", "v", "dx", "dy"}) rounded(corner[key]);
    }
  }
  std::string text;
  for (const char c : document.dump(-1, ' ', false, json::error_handler_t::replace)) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

std::string headHtml(const std::string& title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src "
      "data:\">\n"
      "<meta name=\"color-scheme\" content=\"light "
      "dark\">\n<title>{}</title>\n<style>\n{}{}{}</style>\n</head>\n",
      escapedMarkup(title), paletteCss(), figureCss(), pageCss());
}

std::string topHtml(const ReportData& data, const std::string& title, const std::vector<Section>& sections) {
  const VerdictWords verdict = verdictWords(data.verdict);
  std::string specs;
  for (const ReportedBoard& board : data.boards) specs += (specs.empty() ? "" : ", ") + board.target.spec();
  std::string html = fmt::format(
      "<header><p class=\"kicker\">Calibration report</p>\n<h1>{}</h1>\n<p class=\"kicker\">{}</p></header>\n"
      "<section class=\"verdict {}\" aria-label=\"Verdict\"><strong>{}</strong><p>{}</p></section>\n",
      escapedMarkup(title), escapedMarkup(specs), verdict.kind, verdict.words, accuracySentence(data));
  html += findingsHtml(data) + numbersHtml(data) + "<nav aria-label=\"Sections\">";
  for (const Section& section : sections)
    html += fmt::format("<a href=\"#{}\">{}</a>\n", section.id, section.title);
  return html + "</nav>\n";
}

std::string viewerHtml(const ImageSize& size) {
  std::string html(kViewer);
  html.replace(html.find("WIDTH"), 5, std::to_string(size.width));
  html.replace(html.find("HEIGHT"), 6, std::to_string(size.height));
  return html;
}

}  // namespace

std::string reportPage(const json& evidence, const std::string& file, const PageOptions& options) {
  const ReportData data = readReportData(evidence, file);
  const std::vector<std::string> pictures = viewPictures(data, options.image_of, options.num_jobs);
  std::vector<Section> sections = sectionsOf(data, options);
  for (Section& section : sections) {
    if (section.id == "views") section.more = viewSheet(data, pictures);
    if (section.id == "values") section.more = parametersHtml(data) + modelsHtml(data);
  }
  const std::string title =
      fmt::format("{}, {} × {} px", data.camera.modelId(), data.size.width, data.size.height);
  std::string html =
      headHtml("Calibration: " + title) + "<body>\n" + topHtml(data, title, sections) + "<main>\n";
  for (const Section& section : sections) {
    html += fmt::format("<h2 id=\"{}\">{}</h2>\n<div class=\"figures\">\n", section.id, section.title);
    for (const Figure& figure : section.figures) html += figureHtml(figure);
    html += section.more + "</div>\n";
  }
  html +=
      "<h2 id=\"details\">Details</h2>\n" + detailsHtml(data, evidence) + "</main>\n" + viewerHtml(data.size);
  html += fmt::format(
      "<footer>Made by {}. The numbers behind this page are part of it: see the element with the id "
      "“evidence”.</footer>\n",
      escapedMarkup(data.created_by));
  html += "<script type=\"application/json\" id=\"evidence\">" + embeddedEvidence(evidence) +
          "</script>\n<script>\n";
  html += pageScript();
  return html + "</script>\n</body>\n</html>\n";
}

std::vector<FigureFile> reportFigures(const json& evidence, const std::string& file,
                                      const PageOptions& options) {
  const ReportData data = readReportData(evidence, file);
  std::vector<FigureFile> files;
  for (const Section& section : sectionsOf(data, options)) {
    for (const Figure& figure : section.figures) {
      // The style goes into the drawing, with a ground of its own.
      const std::size_t end_of_tag = figure.svg.find('>') + 1;
      files.push_back({.name = figure.id + ".svg",
                       .svg = "<svg xmlns=\"http://www.w3.org/2000/svg\"" +
                              figure.svg.substr(4, end_of_tag - 4) +
                              fmt::format("\n<style>\n{}{}svg {{ background: var(--ground); }}\n</style>\n",
                                          paletteCss(), figureCss()) +
                              figure.svg.substr(end_of_tag)});
    }
  }
  return files;
}

}  // namespace alidade
