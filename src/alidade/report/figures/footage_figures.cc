// SPDX-License-Identifier: MIT
#include "alidade/report/figures/footage_figures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/report/canvas/page_table.h"

namespace alidade {
namespace {

std::string wordsOf(std::string_view id_of) {
  std::string id(id_of);
  std::ranges::replace(id, '_', ' ');
  return id;
}

// @param edit  flags of `convert` applied before the check; empty: none
std::string tableOf(const FootageCheck& check, const std::string& edit, const std::string& id) {
  const auto px = [](double value) { return std::isfinite(value) ? shortNumber(value) : "unknown"; };
  std::vector<PageRow> rows;
  for (std::size_t i = 0; i < check.changes.size(); ++i) {
    const CameraChange& change = check.changes[i];
    rows.push_back(
        {.cells = {wordsOf(changeId(change.kind)), describe(change), px(change.effect_px), px(change.sure_px),
                   px(change.blind_px), fmt::format("{:.1f} %", 100 * change.cost_drop),
                   check.explanation == i ? "best explanation" : ""},
         .kind = ""});
  }
  const std::string title =
      edit.empty() ? "Changes that were tried" : fmt::format("Changes that were tried after {}", edit);
  const std::string verdict = "Verdict: " + footageVerdictWords(check.verdict) + ".";
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

std::optional<Figure> footageErrorsFigure(const FootageJudgement& footage) {
  const bool is_edited = !footage.edits.empty();
  const FootageCheck& check = is_edited ? footage.edits.front().check : footage.check;
  if (footage.isOtherSize() != is_edited || check.cells.empty()) return std::nullopt;
  const ImagePlot plot = imagePlot(footage.image_size);
  const PlotArea& area = plot.area;
  FigureCanvas canvas(plot.legend_top);
  double most = 0;
  double longest = 0;
  for (const FootageCell& cell : check.cells) {
    if (cell.num_pixels == 0) continue;
    most = std::max(most, cell.rms_px);
    longest = std::max(longest, cell.mean_px.norm());
  }
  const double length = 0.9 * area.box.sizes().x() / FootageCheck::kColumns;
  const double times = longest > 0 ? roundBelow(length / (longest * area.scale())) : 1;
  canvas.addRect(area.box.min(), area.box.max(), "class=\"paper\"");
  const std::string means = canvas.addErrorCells(
      area, FootageCheck::kColumns, FootageCheck::kRows, mapped(check.cells, [&](const FootageCell& cell) {
        return cell.num_pixels == 0 ? ErrorCell{}
                                    : ErrorCell{.count = cell.num_pixels,
                                                .rms_px = cell.rms_px,
                                                .arrow = times * area.scale() * cell.mean_px};
      }));
  const auto num_seen =
      std::ranges::count_if(check.cells, [](const FootageCell& cell) { return cell.num_pixels > 0; });
  canvas.addMeanArrows(means);
  canvas.addImageFrame(area);
  Legend legend = warmthLegend(most);
  legend.insert(legend.begin(), {"line mean", fmt::format("mean of a cell ({})", timesLonger(times))});
  canvas.addLegend({area.box.min().x(), plot.legend_top}, legend);
  Figure figure{.id = "footage-errors", .title = "Errors on the footage over the image"};
  figure.reading = fmt::format(
      "Errors of pixels that had no part in finding their point{}. Noise makes all cells alike and the "
      "arrows point in all directions; arrows that form a pattern show what the camera file does not "
      "describe.",
      is_edited ? ", with the camera after " + editFlags(footage.edits.front().request) : "");
  figure.alt = fmt::format(
      "Errors of {} pixels in {} of {} cells of the image, with an RMS of {} px; the largest RMS of a cell "
      "is {} px.",
      check.num_pixels, num_seen, check.cells.size(),
      check.num_windows > 0 ? shortNumber(check.holdout_rms_px) : "unknown", shortNumber(most));
  return canvas.drawn(std::move(figure));
}

std::string footageTables(const FootageJudgement& footage, const std::string& prefix) {
  const std::string id = prefix + "footage-changes";
  if (!footage.isOtherSize()) return tableOf(footage.check, "", id);
  std::string html;
  for (std::size_t i = 0; i < footage.edits.size(); ++i) {
    const FootageEdit& edit = footage.edits[i];
    html += tableOf(edit.check, editFlags(edit.request), i == 0 ? id : fmt::format("{}-{}", id, i));
  }
  return html;
}

std::string footageVerdictWords(FootageVerdict verdict) {
  return wordsOf(verdictId(verdict));
}

std::string footageSentence(const std::vector<Diagnosis>& checks) {
  const auto found = std::ranges::find(checks, "footage", &Diagnosis::id);
  return found == checks.end() ? "" : "Footage finds it " + found->cause + ".";
}

}  // namespace alidade
