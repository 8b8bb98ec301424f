// SPDX-License-Identifier: MIT
#include "alidade/report/pages/fleet_page.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/fleet/fleet_findings.h"
#include "alidade/report/canvas/page_table.h"
#include "alidade/report/data/fleet_json.h"
#include "alidade/report/figures/fleet_figures.h"
#include "alidade/report/pages/page_shell.h"

namespace alidade {
namespace {

constexpr std::size_t kMostRows = 50;

std::string sigmasText(double sigmas) {
  if (std::isnan(sigmas)) return "unknown";
  constexpr double kMostSaid = 37;
  return sigmas > kMostSaid ? "more than 37" : fmt::format("{:.1f}", sigmas);
}

std::string parametersTable(const FleetGroup& group, const std::string& prefix) {
  const TypicalCamera& typical = *group.typical;
  std::vector<PageRow> rows;
  const auto names = typical.camera.parameterNames();
  for (std::size_t j = 0; j < names.size(); ++j) {
    const auto at = static_cast<Eigen::Index>(j);
    const double between = std::sqrt(std::max(0.0, typical.population.between(at, at)));
    const double of_mean = std::sqrt(std::max(0.0, typical.population.mean_covariance(at, at)));
    const double mean = typical.population.mean(at);
    rows.push_back({{std::string(names[j]), valueText(mean, of_mean), deviationText(mean, of_mean),
                     deviationText(mean, between)}});
  }
  return tableFigure(
      prefix + "fleet-typical", "The typical camera",
      {{"Parameter"}, {"Mean"}, {"Standard deviation of the mean"}, {"Between units"}}, rows,
      "The last column is the standard deviation between units, without the uncertainty of the single "
      "files.");
}

// The significant differences from the typical camera or from the previous calibrations.
std::string differencesTable(const Fleet& fleet, const std::vector<UnitDifference>& differences,
                             bool are_drifts, const std::string& prefix) {
  const auto significant = significantOnes(differences);
  if (significant.empty()) return "";
  std::vector<PageRow> rows;
  for (const UnitDifference& difference : significant) {
    if (rows.size() == kMostRows) break;
    const FleetUnit& unit = fleet.files.units[difference.unit];
    rows.push_back(
        {{unit.file + (unit.name.serial.empty() ? "" : ", serial number " + unit.name.serial),
          are_drifts ? difference.previous : std::string(unit.camera.modelId()),
          shortNumber(difference.p95_px), shortNumber(difference.max_px), sigmasText(difference.sigmas)}});
  }
  const std::vector<PageColumn> columns = {{"File", "words"},
                                           {are_drifts ? "Previous" : "Model", "words"},
                                           {"95 % within, px"},
                                           {"At most, px"},
                                           {"Sigmas"}};
  const char* const reading =
      are_drifts ? "Differences between the two calibrations of a unit."
                 : "Sigmas say how improbable the difference is for a unit of this population, in standard "
                   "deviations of a normal variable.";
  return tableFigure(
      prefix + (are_drifts ? "fleet-drifted" : "fleet-deviants"),
      are_drifts ? "Units that changed" : "Units that deviate", columns, rows,
      reading + (significant.size() > kMostRows
                     ? fmt::format(" The {} largest of {} are shown.", kMostRows, significant.size())
                     : ""));
}

// Groups after the first one have their own ids.
std::vector<PageSection> fleetSections(const Fleet& fleet) {
  std::vector<PageSection> sections;
  std::size_t number = 0;
  for (const FleetGroup& group : fleet.groups) {
    ++number;
    if (!group.typical || !std::isfinite(group.p95_px)) continue;
    const std::string prefix = number == 1 ? "" : fmt::format("group{}-", number);
    PageSection section{.id = prefix + "units",
                        .title = fmt::format("{} units, {} px", group.units.size(), sizeText(group.size))};
    section.figures = {fleetMapFigure(group, fleet.tolerance_px),
                       fleetDistancesFigure(group, fleet.tolerance_px), fleetParametersFigure(fleet, group)};
    if (!prefix.empty())
      for (Figure& figure : section.figures) figure = withPrefix(figure, prefix);
    section.more = parametersTable(group, prefix) + differencesTable(fleet, group.differences, false, prefix);
    sections.push_back(std::move(section));
  }
  if (std::ranges::any_of(fleet.drifts, &UnitDifference::is_comparable)) {
    sections.push_back({.id = "drift",
                        .title = "Drift",
                        .figures = {fleetDriftFigure(fleet)},
                        .more = differencesTable(fleet, fleet.drifts, true, "")});
  }
  return sections;
}

std::vector<PageNumber> fleetNumbers(const Fleet& fleet) {
  const FleetGroup& group = fleet.groups.front();
  std::vector<PageNumber> numbers;
  if (group.typical && std::isfinite(group.p95_px)) {
    numbers.push_back(
        {"Distance from the typical camera", errorText(group.p95_px), "not exceeded by 95 % of the units"});
    numbers.push_back({"Within the tolerance", fmt::format("{} of {}", group.num_within, group.units.size()),
                       fmt::format("{} px (95 % of the image)", shortNumber(fleet.tolerance_px))});
    numbers.push_back({"Deviate", std::to_string(fleet.numDeviating()),
                       fmt::format("units; at most {:.0f} % of these by chance", 100 * kFalseShare)});
  }
  if (fleet.has_previous)
    numbers.push_back({"Changed", std::to_string(fleet.numDrifted()),
                       fmt::format("of {} with a previous calibration", fleet.drifts.size())});
  numbers.push_back({"Trustworthy", std::to_string(fleet.count(Verdict::kTrustworthy)),
                     fmt::format("{} with reservations, {} rejected, {} without a verdict",
                                 fleet.count(Verdict::kReservations), fleet.count(Verdict::kNo),
                                 fleet.count(std::nullopt))});
  std::vector<double> accuracies;
  for (const FleetUnit& unit : fleet.files.units)
    if (std::isfinite(unit.accuracy_px)) accuracies.push_back(unit.accuracy_px);
  if (!accuracies.empty()) {
    const double worst = std::ranges::max(accuracies);
    numbers.push_back({"Accuracy of the files", errorText(medianOf(std::move(accuracies))),
                       fmt::format("median; the worst {}", errorText(worst))});
  }
  numbers.push_back({"Image sizes", std::to_string(fleet.groups.size()), "each a group of its own"});
  return numbers;
}

}  // namespace

std::string servingSentence(const FleetGroup& group, double tolerance_px) {
  if (!group.typical) {
    return fmt::format("{} units of {} px: no typical camera, because fewer than {} have one model",
                       group.units.size(), sizeText(group.size), kFewestUnits);
  }
  return fmt::format("{} of {} units are within {:g} px of the typical camera{}", group.num_within,
                     group.units.size(), tolerance_px,
                     group.num_within > 0 ? ": one file may serve for these" : "");
}

std::string fleetPage(const Fleet& fleet, const RunOrigin& origin) {
  const FleetGroup& group = fleet.groups.front();
  PageContent page{
      .kind = "Fleet",
      .title = fmt::format("{} cameras in {} files", fleet.files.units.size(), fleet.files.num_files),
      .origin = origin,
      .headline = servingSentence(group, fleet.tolerance_px),
      .findings = asSentences(fleetFindings(fleet), mapped(fleet.files.units, &FleetUnit::file)),
      .numbers = fleetNumbers(fleet),
      .sections = fleetSections(fleet)};
  page.verdict = verdictOf(page.findings);
  page.subtitle =
      fmt::format("{}{} px", group.typical ? std::string(group.typical->camera.modelId()) + ", " : "",
                  sizeText(group.size));
  if (fleet.groups.size() > 1)
    page.subtitle += fmt::format(", and {}", counted(fleet.groups.size() - 1, "other image size"));
  page.sentence = "Distances hold for 95 % of the image, after the best rotation of each unit.";
  // A unit that changed matters even in a fleet too small for a typical camera.
  const auto drifted = std::ranges::find(page.findings, "drifted_units", &Diagnosis::id);
  if (drifted != page.findings.end())
    page.sentence = std::exchange(page.headline, drifted->message()) + ". " + page.sentence;
  page.details = listHtml(counted(fleet.files.unreadable.size(), "file") + " that cannot be read",
                          mapped(fleet.files.unreadable, &UnreadableFile::reason)) +
                 listHtml(counted(fleet.unreadable_previous.size(), "previous file") + " that cannot be read",
                          mapped(fleet.unreadable_previous, &UnreadableFile::reason));
  return pageText(page, withOrigin(fleetJson(fleet, origin.created_by), origin));
}

}  // namespace alidade
