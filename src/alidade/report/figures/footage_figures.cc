// SPDX-License-Identifier: MIT
#include "alidade/report/figures/footage_figures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "alidade/report/pages/page_table.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

std::string wordsOf(std::string id) {
  std::ranges::replace(id, '_', ' ');
  return id;
}

std::string tableOf(const ReportedFootageCheck& check, const std::string& id) {
  std::vector<PageRow> rows;
  for (const ReportedChange& change : check.changes) {
    const bool is_best = change.id == check.explanation;
    rows.push_back(
        {.cells = {wordsOf(change.id), change.text, shortNumber(change.effect_px),
                   shortNumber(change.sure_px), shortNumber(change.blind_px),
                   fmt::format("{:.1f} %", 100 * change.cost_drop), is_best ? "best explanation" : ""},
         .kind = ""});
  }
  const std::string title = check.edit.empty() ? "Changes that were tried"
                                               : fmt::format("Changes that were tried after {}", check.edit);
  const std::string verdict = "Verdict: " + wordsOf(check.verdict) + ".";
  if (rows.empty()) return fmt::format("<p class=\"note\">{}: {}</p>\n", escapedMarkup(title), verdict);
  return tableFigure(
      id, title,
      {{"Change", "words"},
       {"Best value", "words"},
       {"Displaces by, px"},
       {"Surely by, px"},
       {"Unnoticed below, px"},
       {"Squared error less by"},
       {"", "words"}},
      rows,
      verdict +
          " Each change is fitted alone, with the motion and the points of the scene. A file is wrong where "
          "the best one displaces points by more than five times the tolerance, and surely by half of that.");
}

}  // namespace

std::optional<Figure> footageErrorsFigure(const ReportedFootage& footage) {
  if (footage.checks.empty() || footage.checks.front().cells.empty()) return std::nullopt;
  const ReportedFootageCheck& check = footage.checks.front();
  const ImagePlot plot = imagePlot(footage.size);
  const PlotArea& area = plot.area;
  FigureCanvas canvas(plot.legend_top);
  double most = 0;
  double longest = 0;
  for (const ReportedFootageCell& cell : check.cells) {
    if (cell.num_pixels == 0) continue;
    most = std::max(most, cell.rms_px);
    longest = std::max(longest, cell.mean_px.norm());
  }
  const double length = 0.9 * area.box.sizes().x() / check.columns;
  const double times = longest > 0 ? roundBelow(length / (longest * area.scale())) : 1;
  canvas.addRect(area.box.min(), area.box.max(), "class=\"paper\"");
  std::string means;
  const Vector2d sides = area.box.sizes().cwiseQuotient(Vector2d(check.columns, check.rows));
  int num_seen = 0;
  for (int row = 0; row < check.rows; ++row) {
    for (int column = 0; column < check.columns; ++column) {
      const ReportedFootageCell& cell = check.cells[static_cast<std::size_t>(row * check.columns + column)];
      if (cell.num_pixels == 0) continue;
      ++num_seen;
      const Vector2d low = area.box.min() + sides.cwiseProduct(Vector2d(column, row));
      canvas.addRect(
          low, low + sides,
          fmt::format("class=\"warmth\" fill-opacity=\"{:.2f}\" data-count=\"{}\" data-rms=\"{:.9g}\"",
                      0.1 + 0.5 * (most > 0 ? cell.rms_px / most : 0), cell.num_pixels, cell.rms_px));
      means += arrowPath(low + 0.5 * sides, times * area.scale() * cell.mean_px);
    }
  }
  canvas.addPath(means, "class=\"mean halo-line\"");
  canvas.addPath(means, "class=\"mean\"");
  canvas.addImageFrame(area);
  canvas.addLegend({area.box.min().x(), plot.legend_top},
                   {{"line mean", fmt::format("mean of a cell ({})", timesLonger(times))},
                    {"warmth weak", fmt::format("RMS {} px", shortNumber(most / 3))},
                    {"warmth middling", fmt::format("{} px", shortNumber(2 * most / 3))},
                    {"warmth", fmt::format("{} px", shortNumber(most))}});
  Figure figure{.id = "footage-errors", .title = "Errors on the footage over the image"};
  figure.reading = fmt::format(
      "Errors of pixels that had no part in finding their point{}. Noise makes all cells alike and the "
      "arrows point in all directions; arrows that form a pattern show what the camera file does not "
      "describe.",
      check.edit.empty() ? "" : ", with the camera after " + check.edit);
  figure.alt = fmt::format(
      "Errors of {} pixels in {} of {} cells of the image, with an RMS of {} px; the largest RMS of a cell "
      "is {} px.",
      check.num_pixels, num_seen, check.cells.size(), shortNumber(check.holdout_rms_px), shortNumber(most));
  figure.svg = canvas.svg(figure.alt);
  return figure;
}

std::string footageTables(const ReportedFootage& footage, const std::string& prefix) {
  std::string html;
  for (std::size_t i = 0; i < footage.checks.size(); ++i) {
    const std::string number = i == 0 ? "" : fmt::format("-{}", i);
    html += tableOf(footage.checks[i], prefix + "footage-changes" + number);
  }
  return html;
}

std::string footageVerdictWords(const std::string& verdict) {
  return wordsOf(verdict);
}

std::string footageSentence(const std::vector<Diagnosis>& checks) {
  const auto found = std::ranges::find(checks, "footage", &Diagnosis::id);
  return found == checks.end() ? "" : "Footage finds it " + found->cause + ".";
}

}  // namespace alidade
