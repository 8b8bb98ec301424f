// SPDX-License-Identifier: MIT
#include "alidade/report/figures/fleet_figures.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/statistics.h"
#include "alidade/report/canvas/tolerance_map.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

// Lengths to count, and flags for those that stand out.
struct CountedLength {
  double px = 0;
  bool is_marked = false;
};

// Bars with the number of lengths per bin, those that stand out on top.
void addHistogram(const std::vector<CountedLength>& lengths, const PlotArea& area, int num_bins,
                  FigureCanvas& canvas) {
  std::vector<int> all(static_cast<std::size_t>(num_bins));
  std::vector<int> marked(all.size());
  for (const CountedLength& length : lengths) {
    const auto bin = static_cast<std::size_t>(
        std::clamp(static_cast<int>(num_bins * length.px / area.high.x()), 0, num_bins - 1));
    ++all[bin];
    marked[bin] += length.is_marked ? 1 : 0;
  }
  const double width = area.high.x() / num_bins;
  constexpr double kGapShare = 0.06;
  for (std::size_t b = 0; b < all.size(); ++b) {
    const double left = (static_cast<double>(b) + kGapShare) * width;
    const double right = (static_cast<double>(b) + 1 - kGapShare) * width;
    const auto addBar = [&](double from, double to, const char* kind) {
      if (!(to > from)) return;
      canvas.addRect(area.at(left, to), area.at(right, from),
                     fmt::format("class=\"{}\" data-count=\"{:.0f}\" data-tell=\"{:.0f} from {} to {} px\"",
                                 kind, to - from, to - from, shortNumber(left), shortNumber(right)));
    };
    addBar(0, all[b] - marked[b], "bar");
    addBar(all[b] - marked[b], all[b], "bar freed");
  }
}

// The largest number of lengths in any bin.
double highestBin(const std::vector<CountedLength>& lengths, double most, int num_bins) {
  std::vector<int> counts(static_cast<std::size_t>(num_bins));
  for (const CountedLength& length : lengths)
    ++counts[static_cast<std::size_t>(
        std::clamp(static_cast<int>(num_bins * length.px / most), 0, num_bins - 1))];
  return std::ranges::max(counts);
}

// A histogram with the tolerance, with bars for normal and outstanding lengths; without a separate frame if
// there is nothing to mark.
std::string histogramSvg(const std::vector<CountedLength>& lengths, double tolerance_px, const char* x_name,
                         const Legend& bars, const std::string& alt) {
  constexpr int kNumBins = 32;
  double most = 0;
  for (const CountedLength& length : lengths) most = std::max(most, length.px);
  // The tolerance is shown if it is near.
  constexpr double kNear = 2;
  const bool is_limit_shown = tolerance_px <= kNear * most;
  if (is_limit_shown) most = std::max(most, tolerance_px);
  most = most > 0 ? 1.03 * most : 1;
  const PlotArea area{.box = {Vector2d(52, 14), Vector2d(430, 220)},
                      .low = {0, 0},
                      .high = {most, 1.06 * highestBin(lengths, most, kNumBins)}};
  FigureCanvas canvas(258);
  canvas.addAxes(area, x_name, "units");
  addHistogram(lengths, area, kNumBins, canvas);
  Legend legend = {bars.front()};
  if (std::ranges::any_of(lengths, &CountedLength::is_marked)) legend.push_back(bars.back());
  if (is_limit_shown) {
    canvas.addLine(area.at(tolerance_px, 0), area.at(tolerance_px, area.high.y()), "class=\"limit domain\"");
    legend.emplace_back("line limit domain", fmt::format("tolerance, {} px", shortNumber(tolerance_px)));
  }
  canvas.addLegend({area.box.min().x(), 258}, legend);
  return canvas.svg(alt);
}

// Position of a value among those of all units.
struct ParameterStrip {
  std::string name;
  std::vector<double> of_members;  // standard deviations between units from the typical camera
  std::vector<double> of_others;
};

std::vector<ParameterStrip> stripsOf(const Fleet& fleet, const FleetGroup& group) {
  const TypicalCamera& typical = *group.typical;
  const auto names = typical.camera.parameterNames();
  std::vector<ParameterStrip> strips;
  for (std::size_t j = 0; j < names.size(); ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    const double std = std::sqrt(typical.population.between(at, at));
    if (!(std > 0)) continue;
    ParameterStrip strip{.name = std::string(names[j])};
    for (std::size_t i = 0; i < group.units.size(); ++i) {
      const AnyCamera& camera = fleet.files.units[group.units[i]].camera;
      if (camera.modelId() != typical.camera.modelId()) continue;
      auto& list = group.differences[i].is_significant ? strip.of_others : strip.of_members;
      list.push_back((camera.parameters()[j] - typical.population.mean(at)) / std);
    }
    strips.push_back(std::move(strip));
  }
  return strips;
}

// The value that a given share of the sorted values does not exceed.
double quantileOf(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(std::lround(at))];
}

}  // namespace

Figure fleetMapFigure(const FleetGroup& group, double tolerance_px) {
  const ImagePlot plot = imagePlot(group.size);
  FigureCanvas canvas(plot.legend_top);
  canvas.addRect(plot.area.box.min(), plot.area.box.max(), "class=\"blind\"");
  const FleetMap& values = group.map;
  const LevelMap map{
      .columns = values.columns,
      .rows = values.rows,
      .values = values.p95_px,
      .point_at = [&](int column, int row) {
        return plot.area.at(values.pixels[static_cast<std::size_t>(row * values.columns + column)]);
      }};
  auto legend = addToleranceMap(map, tolerance_px, plot.area, canvas);
  canvas.addImageFrame(plot.area);
  const std::string sentence = toleranceSentence(legend, tolerance_px);
  if (std::ranges::any_of(values.p95_px, [](double px) { return std::isnan(px); }))
    legend.emplace_back("blind", "no ray");
  canvas.addLegend({plot.area.box.min().x(), plot.legend_top}, legend);
  Figure figure{.id = "fleet-map", .title = "Where the units differ"};
  figure.reading =
      "Each colour is a distance from the typical camera that 95 % of the units do not exceed there, the "
      "best rotation removed. " +
      sentence;
  double worst = 0;
  for (const double px : values.p95_px)
    if (std::isfinite(px)) worst = std::max(worst, px);
  figure.alt = fmt::format("Map of the distance that 95 % of {} units do not exceed; at most {} px.",
                           group.units.size(), shortNumber(worst));
  return canvas.drawn(std::move(figure));
}

Figure fleetDistancesFigure(const FleetGroup& group, double tolerance_px) {
  std::vector<CountedLength> lengths;
  for (const UnitDifference& difference : group.differences)
    if (difference.is_comparable) lengths.push_back({difference.p95_px, difference.is_significant});
  Figure figure{.id = "fleet-distances", .title = "Distances from the typical camera"};
  figure.reading =
      "Each bar counts units by how far 95 % of their image is from the typical camera at most. Units right "
      "of the tolerance need files of their own.";
  figure.alt =
      fmt::format("{} of {} units are within {} px of the typical camera; {} deviate.", group.num_within,
                  group.units.size(), shortNumber(tolerance_px), group.numDeviating());
  figure.svg = histogramSvg(lengths, tolerance_px, "distance from the typical camera, px",
                            {{"bar", "units"}, {"bar freed", "units that deviate"}}, figure.alt);
  return figure;
}

Figure fleetParametersFigure(const Fleet& fleet, const FleetGroup& group) {
  constexpr double kRow = 22;
  constexpr double kLeft = 64;
  constexpr double kSpan = 4;       // standard deviations shown on each side
  constexpr double kMiddle = 0.95;  // of the units within a bar
  std::vector<ParameterStrip> strips = stripsOf(fleet, group);
  const double bottom = 14 + kRow * static_cast<double>(strips.size());
  const PlotArea area{
      .box = {Vector2d(kLeft, 14), Vector2d(430, bottom)}, .low = {-kSpan, 0}, .high = {kSpan, 1}};
  FigureCanvas canvas(bottom + 38);
  for (int sigma = -static_cast<int>(kSpan); sigma <= static_cast<int>(kSpan); ++sigma) {
    canvas.addLine(area.at(sigma, 0), area.at(sigma, 1), sigma == 0 ? "class=\"mark\"" : "class=\"grid\"");
    canvas.addText({area.at(sigma, 0).x(), bottom + 13}, std::to_string(sigma), "middle", "class=\"tick\"");
  }
  canvas.addText({area.box.center().x(), bottom + 29}, "standard deviations between units", "middle",
                 "class=\"axis\"");
  std::size_t num_others = 0;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    ParameterStrip& strip = strips[s];
    const double top = 14 + kRow * static_cast<double>(s);
    canvas.addText({kLeft - 8, top + 15}, strip.name, "end");
    num_others = std::max(num_others, strip.of_others.size());
    const auto xOf = [&](double sigmas) { return area.at(std::clamp(sigmas, -kSpan, kSpan), 0).x(); };
    if (!strip.of_members.empty()) {
      std::ranges::sort(strip.of_members);
      const double low = quantileOf(strip.of_members, 0.5 * (1 - kMiddle));
      const double high = quantileOf(strip.of_members, 0.5 * (1 + kMiddle));
      canvas.addRect({xOf(low), top + 8}, {xOf(high), top + 14}, "class=\"bar\"");
      canvas.addRect({xOf(quantileOf(strip.of_members, 0.25)), top + 5},
                     {xOf(quantileOf(strip.of_members, 0.75)), top + 17}, "class=\"cold\"");
    }
    constexpr std::size_t kMostDots = 200;
    for (std::size_t i = 0; i < std::min(kMostDots, strip.of_others.size()); ++i)
      canvas.addPath("M" + pointText({xOf(strip.of_others[i]), top + 11}) + "h0", "class=\"hue1 places\"");
  }
  canvas.addRect(area.box.min(), area.box.max(), "class=\"frame\"");
  Legend legend = {{"cold", "half of the units"}, {"bar", "95 % of them"}};
  if (num_others > 0) legend.emplace_back("line hue1", "units that deviate");
  canvas.addLegend({kLeft, bottom + 38}, legend);
  Figure figure{.id = "fleet-parameters", .title = "Parameters of the units"};
  figure.reading =
      "Where a bar is much longer than from -2 to 2, the uncertainty of the single files is larger than the "
      "spread between units. Dots at the border lie beyond it.";
  figure.alt = fmt::format("The spread of {} parameters of {} units, and {} units that deviate.",
                           strips.size(), group.typical->num_units, num_others);
  return canvas.drawn(std::move(figure));
}

Figure fleetDriftFigure(const Fleet& fleet) {
  std::vector<CountedLength> lengths;
  for (const UnitDrift& drift : fleet.drifts)
    if (drift.difference.is_comparable)
      lengths.push_back({drift.difference.p95_px, drift.difference.is_significant});
  Figure figure{.id = "fleet-drift", .title = "Changes since the previous calibrations"};
  figure.reading =
      "Each bar counts units by how far 95 % of their image is from their previous calibration at most. "
      "Changes that the uncertainties of both explain are not marked.";
  figure.alt = fmt::format("{} units with a previous calibration, of which {} changed.", lengths.size(),
                           fleet.numDrifted());
  figure.svg = histogramSvg(lengths, fleet.tolerance_px, "difference from the previous calibration, px",
                            {{"bar", "units"}, {"bar freed", "units that changed"}}, figure.alt);
  return figure;
}

}  // namespace alidade
