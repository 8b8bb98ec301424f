// SPDX-License-Identifier: MIT
#include "alidade/report/figures/fleet_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/report/canvas/level_map.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr int kNumBins = 32;

// Numbers of differences per bin: of all, and of the significant ones.
std::array<std::array<int, kNumBins>, 2> countedDifferences(const std::vector<UnitDifference>& differences,
                                                            double most) {
  std::array<std::array<int, kNumBins>, 2> counts{};
  for (const UnitDifference& difference : differences) {
    const auto bin = static_cast<std::size_t>(
        std::clamp(static_cast<int>(kNumBins * difference.p95_px / most), 0, kNumBins - 1));
    ++counts[0][bin];
    counts[1][bin] += difference.is_significant ? 1 : 0;
  }
  return counts;
}

// A histogram of differences with the tolerance; bars of significant differences are on top.
// @param x_name, bars  see FigureCanvas
Figure histogram(Figure words, std::vector<UnitDifference> differences, double tolerance_px,
                 const char* x_name, Legend bars) {
  std::erase_if(differences, [](const UnitDifference& difference) { return !difference.is_comparable; });
  double most = 0;
  for (const UnitDifference& difference : differences) most = std::max(most, difference.p95_px);
  // The tolerance is shown if it is near.
  constexpr double kNear = 2;
  const bool is_limit_shown = tolerance_px <= kNear * most;
  if (is_limit_shown) most = std::max(most, tolerance_px);
  most = most > 0 ? 1.03 * most : 1;
  const auto [all, marked] = countedDifferences(differences, most);
  FigureCanvas canvas({.box = {Vector2d(52, 14), Vector2d(430, 220)},
                       .low = {0, 0},
                       .high = {most, 1.06 * std::ranges::max(all)}},
                      38);
  canvas.addAxes(x_name, "units");
  const double width = most / kNumBins;
  constexpr double kGapShare = 0.06;
  for (std::size_t b = 0; b < all.size(); ++b) {
    const double left = (static_cast<double>(b) + kGapShare) * width;
    const double right = (static_cast<double>(b) + 1 - kGapShare) * width;
    const auto addBar = [&](double from, double to, const char* kind) {
      if (!(to > from)) return;
      canvas.addRect(canvas.at(left, to), canvas.at(right, from),
                     fmt::format("class=\"{}\" data-count=\"{:.0f}\" data-tell=\"{:.0f} from {} to {} px\"",
                                 kind, to - from, to - from, shortNumber(left), shortNumber(right)));
    };
    addBar(0, all[b] - marked[b], "bar");
    addBar(all[b] - marked[b], all[b], "bar freed");
  }
  if (std::ranges::none_of(differences, &UnitDifference::is_significant)) bars.pop_back();
  if (is_limit_shown) {
    canvas.addLine(canvas.at(tolerance_px, 0), canvas.at(tolerance_px, canvas.area().high.y()),
                   "limit domain");
    bars.emplace_back("line limit domain", fmt::format("tolerance, {} px", shortNumber(tolerance_px)));
  }
  return canvas.drawn(std::move(words), bars);
}

// Position of a value among those of all units.
struct ParameterStrip {
  std::string name;
  std::vector<double> of_members = {};  // standard deviations between units from the typical camera
  std::vector<double> of_others = {};
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
  FigureCanvas canvas(group.size, "blind");
  const FleetMap& values = group.map;
  Legend legend = addToleranceMap({.columns = values.columns,
                                   .rows = values.rows,
                                   .values = values.p95_px,
                                   .points = canvas.at(values.pixels)},
                                  tolerance_px, canvas);
  canvas.addImageFrame();
  const std::string sentence = toleranceSentence(legend, tolerance_px);
  if (std::ranges::any_of(values.p95_px, [](double px) { return std::isnan(px); }))
    legend.emplace_back("blind", "no ray");
  double worst = 0;
  for (const double px : values.p95_px)
    if (std::isfinite(px)) worst = std::max(worst, px);
  return canvas.drawn(
      {.id = "fleet-map",
       .title = "Where the units differ",
       .reading = "Each colour is a distance from the typical camera that 95 % of the units do not exceed "
                  "there, the best rotation removed. " +
                  sentence,
       .alt = fmt::format("Map of the distance that 95 % of {} units do not exceed; at most {} px.",
                          group.units.size(), shortNumber(worst))},
      legend);
}

Figure fleetDistancesFigure(const FleetGroup& group, double tolerance_px) {
  return histogram(
      {.id = "fleet-distances",
       .title = "Distances from the typical camera",
       .reading = "Each bar counts units by how far 95 % of their image is from the typical camera at most. "
                  "Units right of the tolerance need files of their own.",
       .alt =
           fmt::format("{} of {} units are within {} px of the typical camera; {} deviate.", group.num_within,
                       group.units.size(), shortNumber(tolerance_px), group.numDeviating())},
      group.differences, tolerance_px, "distance from the typical camera, px",
      {{"bar", "units"}, {"bar freed", "units that deviate"}});
}

Figure fleetParametersFigure(const Fleet& fleet, const FleetGroup& group) {
  constexpr double kRow = 22;
  constexpr double kLeft = 64;
  constexpr double kSpan = 4;       // standard deviations shown on each side
  constexpr double kMiddle = 0.95;  // of the units within a bar
  std::vector<ParameterStrip> strips = stripsOf(fleet, group);
  const double bottom = 14 + kRow * static_cast<double>(strips.size());
  FigureCanvas canvas(
      {.box = {Vector2d(kLeft, 14), Vector2d(430, bottom)}, .low = {-kSpan, 0}, .high = {kSpan, 1}}, 38);
  const PlotArea& area = canvas.area();
  for (int sigma = -static_cast<int>(kSpan); sigma <= static_cast<int>(kSpan); ++sigma) {
    canvas.addLine(area.at(sigma, 0), area.at(sigma, 1), sigma == 0 ? "mark" : "grid");
    canvas.addText({area.at(sigma, 0).x(), bottom + 13}, std::to_string(sigma), "middle", "tick");
  }
  canvas.addText({area.box.center().x(), bottom + 29}, "standard deviations between units", "middle", "axis");
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
      canvas.addRect({xOf(low), top + 8}, {xOf(high), top + 14}, "bar");
      canvas.addRect({xOf(quantileOf(strip.of_members, 0.25)), top + 5},
                     {xOf(quantileOf(strip.of_members, 0.75)), top + 17}, "cold");
    }
    constexpr std::size_t kMostDots = 200;
    for (std::size_t i = 0; i < std::min(kMostDots, strip.of_others.size()); ++i)
      canvas.addPath("M" + pointText({xOf(strip.of_others[i]), top + 11}) + "h0", "hue1 places");
  }
  canvas.addArea("frame");
  Legend legend = {{"cold", "half of the units"}, {"bar", "95 % of them"}};
  if (num_others > 0) legend.emplace_back("line hue1", "units that deviate");
  return canvas.drawn(
      {.id = "fleet-parameters",
       .title = "Parameters of the units",
       .reading = "Where a bar is much longer than from -2 to 2, the uncertainty of the single files is "
                  "larger than the spread between units. Dots at the border lie beyond it.",
       .alt = fmt::format("The spread of {} parameters of {} units, and {} units that deviate.",
                          strips.size(), group.typical->num_units, num_others)},
      legend);
}

Figure fleetDriftFigure(const Fleet& fleet) {
  const auto num_comparable = std::ranges::count(fleet.drifts, true, &UnitDifference::is_comparable);
  return histogram(
      {.id = "fleet-drift",
       .title = "Changes since the previous calibrations",
       .reading = "Each bar counts units by how far 95 % of their image is from their previous calibration "
                  "at most. Changes that the uncertainties of both explain are not marked.",
       .alt = fmt::format("{} units with a previous calibration, of which {} changed.", num_comparable,
                          fleet.numDrifted())},
      fleet.drifts, fleet.tolerance_px, "difference from the previous calibration, px",
      {{"bar", "units"}, {"bar freed", "units that changed"}});
}

}  // namespace alidade
