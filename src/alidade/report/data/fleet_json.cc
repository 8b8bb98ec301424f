// SPDX-License-Identifier: MIT
#include "alidade/report/data/fleet_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "alidade/fleet/fleet_findings.h"
#include "alidade/report/data/json_output.h"

namespace alidade {
namespace {

json deviationsJson(const AnyCamera& camera, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd std = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  return parametersJson(camera.parameterNames(), {std.data(), static_cast<std::size_t>(std.size())});
}

json groupJson(const FleetGroup& group) {
  json document = {{"image_size", group.size},
                   {"num_units", group.units.size()},
                   {"typical", nullptr},
                   {"num_deviating", group.numDeviating()},
                   {"num_within", group.num_within},
                   {"median_px", group.median_px},
                   {"p95_px", group.p95_px}};
  if (!group.typical) return document;
  const TypicalCamera& typical = *group.typical;
  document["typical"] = {
      {"model", typical.camera.modelId()},
      {"num_units", typical.num_units},
      {"num_members", typical.population.numMembers()},
      {"num_without_covariance", typical.num_without_covariance},
      {"can_judge", typical.can_judge},
      {"parameters", parametersJson(typical.camera.parameterNames(), typical.camera.parameters())},
      {"std_between_units", deviationsJson(typical.camera, typical.population.between)},
      {"std_of_mean", deviationsJson(typical.camera, typical.population.mean_covariance)}};
  const FleetMap& map = group.map;
  document["map"] = {
      {"columns", map.columns},
      {"rows", map.rows},
      {"pixels", rowsJson(map.columns, map.rows, [&](std::size_t i) { return vectorJson(map.pixels[i]); })},
      {"median_px", rowsJson(map.columns, map.rows, [&](std::size_t i) { return map.median_px[i]; })},
      {"p95_px", rowsJson(map.columns, map.rows, [&](std::size_t i) { return map.p95_px[i]; })}};
  return document;
}

json differenceFields(const UnitDifference& difference) {
  if (!difference.is_comparable) return nullptr;
  return {{"p95_px", difference.p95_px},
          {"max_px", difference.max_px},
          {"expected_rms_px", difference.expected_rms_px},
          {"sigmas", difference.sigmas},
          {"significant", std::isnan(difference.sigmas) ? json(nullptr) : json(difference.is_significant)}};
}

json unitsJson(const Fleet& fleet) {
  json list = json::array();
  for (const FleetUnit& unit : fleet.files.units) {
    list.push_back({{"file", unit.file},
                    {"name", unit.name.name},
                    {"serial", unit.name.serial},
                    {"model", unit.camera.modelId()},
                    {"image_size", unit.size},
                    {"verdict", unit.verdict ? json(verdictName(*unit.verdict)) : json(nullptr)},
                    {"accuracy_px", unit.accuracy_px},
                    {"from_typical", nullptr},
                    {"previous", nullptr},
                    {"drift", nullptr}});
  }
  for (const FleetGroup& group : fleet.groups)
    for (const UnitDifference& difference : group.differences)
      list[difference.unit]["from_typical"] = differenceFields(difference);
  for (const UnitDifference& drift : fleet.drifts) {
    list[drift.unit]["previous"] = drift.previous;
    list[drift.unit]["drift"] = differenceFields(drift);
  }
  return list;
}

json unreadableJson(const std::vector<UnreadableFile>& files) {
  json list = json::array();
  for (const UnreadableFile& file : files) list.push_back({{"file", file.file}, {"reason", file.reason}});
  return list;
}

}  // namespace

json fleetJson(const Fleet& fleet, const std::string& created_by) {
  json groups = json::array();
  for (const FleetGroup& group : fleet.groups) groups.push_back(groupJson(group));
  json verdicts = {{"none", fleet.count(std::nullopt)}};
  for (const Verdict verdict : {Verdict::kTrustworthy, Verdict::kReservations, Verdict::kNo})
    verdicts[std::string(verdictName(verdict))] = fleet.count(verdict);
  return {{"tolerance_px", fleet.tolerance_px},
          {"num_files", fleet.files.num_files},
          {"num_units", fleet.files.units.size()},
          {"num_deviating", fleet.numDeviating()},
          {"num_drifted", fleet.has_previous ? json(fleet.numDrifted()) : json(nullptr)},
          {"num_without_previous", fleet.has_previous ? json(fleet.num_unpaired) : json(nullptr)},
          {"verdicts", std::move(verdicts)},
          {"groups", std::move(groups)},
          {"units", unitsJson(fleet)},
          {"unreadable", unreadableJson(fleet.files.unreadable)},
          {"unreadable_previous", unreadableJson(fleet.unreadable_previous)},
          {"findings", fleetFindings(fleet)},
          {"created_by", created_by}};
}

}  // namespace alidade
