// SPDX-License-Identifier: MIT
#include "alidade/fleet/fleet_findings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/text/table_lines.h"

namespace alidade {
namespace {

// "a.yaml (2.1 px), b.yaml (1.9 px) and 5 more"
template <class Indices, class TextOf>
std::string firstOf(const Indices& indices, const TextOf& textOf) {
  constexpr std::size_t kMostNamed = 3;
  std::vector<std::string> names;
  for (const std::size_t i : indices)
    if (names.size() < kMostNamed) names.push_back(textOf(i));
  const std::size_t num_more = indices.size() - names.size();
  return join(names, ", ") + (num_more > 0 ? fmt::format(" and {} more", num_more) : "");
}

void addGroupFindings(const Fleet& fleet, const FleetGroup& group, std::vector<Diagnosis>& findings) {
  constexpr double kShareOfStrangers = 0.2;
  const std::string size = sizeText(group.size) + " px";
  if (!group.typical) {
    findings.push_back(
        {.id = "too_few_units",
         .cause = counted(group.units.size(), "unit") + " of " + size + ": too few for a typical camera",
         .limit = fmt::format("{} of one model", kFewestUnits)});
    return;
  }
  const TypicalCamera& typical = *group.typical;
  if (!typical.can_judge) {
    findings.push_back(
        {.id = "too_few_to_judge",
         .cause = fmt::format("{} of {} are too few to tell which of them deviate",
                              counted(typical.num_units, "unit"), size),
         .limit = fmt::format("{} units", fewestForOutliers(typical.camera.parameters().size()))});
  }
  if (typical.num_without_covariance > 0) {
    findings.push_back(
        {.id = "no_covariance",
         .cause = fmt::format("{} of {} of {} state no covariance and are treated as exact",
                              typical.num_without_covariance, counted(typical.num_units, "unit"), size),
         .evidence = "the spread between units contains their errors"});
  }
  const double strangers =
      1 - static_cast<double>(typical.population.numMembers()) / static_cast<double>(typical.num_units);
  if (strangers > kShareOfStrangers) {
    findings.push_back(
        {.id = "several_kinds",
         .cause = fmt::format("the {} of {} are probably of several kinds",
                              counted(typical.num_units, "unit"), size),
         .evidence = fmt::format("{:.0f} % of them do not belong to the largest one", 100 * strangers),
         .limit = fmt::format("{:.0f} %", 100 * kShareOfStrangers),
         .next_step = "put the files of each kind of camera into a folder of its own"});
  }
  const auto deviating = deviatingUnits(group);
  if (!deviating.empty()) {
    findings.push_back(
        {.id = "deviating_units",
         .cause =
             fmt::format("{} of {} differ from the typical camera by more than their uncertainty and the "
                         "spread between units explain",
                         deviating.size(), counted(group.units.size(), "unit")),
         .evidence = firstOf(deviating,
                             [&](std::size_t i) {
                               return fmt::format("{} ({:.2g} px)", fleet.files.units[group.units[i]].file,
                                                  group.differences[i].p95_px);
                             }),
         .next_step = "validate these files on photographs, or keep a file for each of these units"});
  }
}

std::string verdictField(const FleetUnit& unit) {
  return unit.verdict ? std::string(verdictName(*unit.verdict)) : "";
}

std::string numberField(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}

std::vector<std::string> differenceFields(const UnitDifference& difference, const char* significant,
                                          const char* other) {
  if (!difference.is_comparable) return {"", "", "", "not_comparable"};
  const char* const status = difference.is_significant       ? significant
                             : std::isnan(difference.sigmas) ? "not_judged"
                                                             : other;
  // An infinite difference is practically certain.
  const double sigmas = std::isinf(difference.sigmas) ? 99 : difference.sigmas;
  return {numberField(difference.p95_px), numberField(difference.max_px), numberField(sigmas), status};
}

}  // namespace

std::vector<std::size_t> deviatingUnits(const FleetGroup& group) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < group.differences.size(); ++i)
    if (group.differences[i].is_significant) found.push_back(i);
  std::ranges::stable_sort(found, std::ranges::greater(),
                           [&](std::size_t i) { return group.differences[i].p95_px; });
  return found;
}

std::vector<std::size_t> driftedUnits(const Fleet& fleet) {
  std::vector<std::size_t> found;
  for (std::size_t d = 0; d < fleet.drifts.size(); ++d)
    if (fleet.drifts[d].difference.is_significant) found.push_back(d);
  std::ranges::stable_sort(found, std::ranges::greater(),
                           [&](std::size_t d) { return fleet.drifts[d].difference.p95_px; });
  return found;
}

std::vector<Diagnosis> fleetFindings(const Fleet& fleet) {
  std::vector<Diagnosis> findings;
  for (const FleetGroup& group : fleet.groups) addGroupFindings(fleet, group, findings);
  const auto drifted = driftedUnits(fleet);
  if (!drifted.empty()) {
    findings.push_back(
        {.id = "drifted_units",
         .cause = fmt::format("{} of {} with a previous calibration changed by more than both uncertainties "
                              "explain",
                              drifted.size(), counted(fleet.drifts.size(), "unit")),
         .evidence = firstOf(drifted,
                             [&](std::size_t d) {
                               return fmt::format("{} ({:.2g} px)",
                                                  fleet.files.units[fleet.drifts[d].unit].file,
                                                  fleet.drifts[d].difference.p95_px);
                             }),
         .next_step = "calibrate these units again, and look for loose lenses"});
  }
  if (const std::size_t rejected = fleet.count(Verdict::kNo); rejected > 0) {
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < fleet.files.units.size(); ++i)
      if (fleet.files.units[i].verdict == Verdict::kNo) which.push_back(i);
    findings.push_back({.id = "rejected_units",
                        .cause = counted(rejected, "unit") + " are rejected by their own files",
                        .evidence = firstOf(which, [&](std::size_t i) { return fleet.files.units[i].file; }),
                        .next_step = "calibrate these units again"});
  }
  const auto addUnreadable = [&](const std::vector<UnreadableFile>& files, DiagnosisId id, const char* what) {
    if (files.empty()) return;
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < files.size(); ++i) all.push_back(i);
    findings.push_back({.id = id,
                        .severity = Severity::kWarning,
                        .cause = fmt::format("{} cannot be read and {} left out",
                                             counted(files.size(), std::string(what) + "file"),
                                             files.size() == 1 ? "is" : "are"),
                        .evidence = firstOf(all, [&](std::size_t i) { return files[i].file; }),
                        .next_step = "run alidade validate on them"});
  };
  addUnreadable(fleet.files.unreadable, "unreadable_files", "");
  addUnreadable(fleet.unreadable_previous, "unreadable_previous", "previous ");
  if (fleet.num_unpaired > 0) {
    findings.push_back({.id = "no_previous",
                        .cause = counted(fleet.num_unpaired, "unit") + " have no previous calibration",
                        .evidence = "none of the same serial number, name or file name"});
  }
  std::ranges::stable_sort(findings, std::ranges::greater(), &Diagnosis::severity);
  return findings;
}

std::string fleetCsv(const Fleet& fleet) {
  std::vector<std::vector<std::string>> rows;
  for (const FleetUnit& unit : fleet.files.units) {
    rows.push_back({unit.file, unit.name.name, unit.name.serial, std::string(unit.camera.modelId()),
                    std::to_string(unit.size.width), std::to_string(unit.size.height), verdictField(unit),
                    numberField(unit.accuracy_px)});
  }
  std::vector<std::vector<std::string>> places(rows.size(), {"", "", "", "no_typical_camera"});
  for (const FleetGroup& group : fleet.groups)
    for (std::size_t i = 0; i < group.differences.size(); ++i)
      places[group.units[i]] = differenceFields(group.differences[i], "deviates", "typical");
  std::vector<std::vector<std::string>> drifts(rows.size(), {"", "", "", "", ""});
  for (const UnitDrift& drift : fleet.drifts) {
    drifts[drift.unit] = differenceFields(drift.difference, "drifted", "unchanged");
    drifts[drift.unit].insert(drifts[drift.unit].begin(), drift.previous);
  }
  std::string text =
      "file,name,serial,model,width,height,verdict,accuracy_px,distance_px,distance_max_px,sigmas,status,previous,drift_px,drift_max_px,drift_sigmas,drift_status\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const auto* more : {&places[i], &drifts[i]})
      rows[i].insert(rows[i].end(), more->begin(), more->end());
    for (std::string& field : rows[i]) field = detail::csvField(field);
    text += join(rows[i], ",") + "\n";
  }
  return text;
}

}  // namespace alidade
