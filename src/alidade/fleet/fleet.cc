// SPDX-License-Identifier: MIT
#include "alidade/fleet/fleet.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/parallel.h"
#include "alidade/core/statistics.h"
#include "alidade/fleet/drift.h"
#include "alidade/fleet/false_discovery.h"

namespace alidade {
namespace {

constexpr double kFleetNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kGridAlongLonger = 20;  // a lens is smooth: its 95th percentile needs no finer grid

DifferenceOptions differenceOptions(ImageSize size, std::optional<Freed> freed) {
  const int longer = std::max(size.width, size.height);
  const auto along = [&](int side) {
    return std::max(3, static_cast<int>(std::lround(static_cast<double>(kGridAlongLonger) * side / longer)));
  };
  return {.freed = freed, .columns = along(size.width), .rows = along(size.height)};
}

// A comparison, and the input of its test.
struct Comparison {
  UnitDifference result;
  std::optional<DifferenceSignificance> significance;
  std::vector<float> lengths;  // over the grid, px; NaN if not comparable
};

Comparison compared(const ComparedCamera& a, const ComparedCamera& b, std::optional<Freed> freed) {
  const ProjectionDifference difference = projectionDifference(a, b, differenceOptions(a.size, freed));
  Comparison comparison;
  comparison.result.is_comparable = isComparable(difference);
  for (std::size_t i = 0; i < difference.pixels.size(); ++i)
    comparison.lengths.push_back(static_cast<float>(difference.lengthAt(i)));
  if (!comparison.result.is_comparable) return comparison;
  comparison.result.p95_px = difference.p95_px;
  comparison.result.max_px = difference.max_px;
  comparison.significance = significanceOf(difference, a, b, freed);
  if (comparison.significance) comparison.result.expected_rms_px = comparison.significance->expected_rms_px;
  return comparison;
}

PopulationSample sampleOf(const FleetUnit& unit) {
  const auto values = unit.camera.parameters();
  const auto k = static_cast<Eigen::Index>(values.size());
  PopulationSample sample{.value = Eigen::Map<const Eigen::VectorXd>(values.data(), k),
                          .covariance = Eigen::MatrixXd::Zero(k, k)};
  if (!unit.covariance.empty()) sample.covariance = fullMatrix(unit.covariance, k).view();
  return sample;
}

// The statistic of a unit against a population whose covariance was estimated from `n` members is not
// chi-squared. It follows a beta distribution if the unit is a member, and Hotelling's otherwise; both reduce
// to an F distribution (Anderson 2003, An Introduction to Multivariate Statistical Analysis, ch. 5). If only
// a share of the covariance was estimated, the effective number of members is larger (Satterthwaite 1946).
double normalOfSquares(double squares, double directions, double num_members, double between_share,
                       bool is_member) {
  const double n = 1 + (num_members - 1) / std::max(1e-6, between_share * between_share);
  if (is_member) {
    const double below = n - directions - 1;
    const double part = n * squares / ((n - 1) * (n - 1));
    if (!(below >= 1)) return kFleetNan;
    if (part >= 1) return std::numeric_limits<double>::infinity();
    return normalOfF(part / (1 - part) * below / directions, directions, below);
  }
  const double below = n - directions;
  if (!(below >= 1)) return kFleetNan;
  return normalOfF(squares * n * below / ((n + 1) * directions * (n - 1)), directions, below);
}

// The most frequent model; in case of a tie, the first in the list of models.
std::string commonModel(const std::vector<FleetUnit>& units, const std::vector<std::size_t>& group) {
  std::map<std::string_view, std::size_t> counts;
  for (const std::size_t i : group) ++counts[units[i].camera.modelId()];
  std::string best;
  std::size_t most = 0;
  for (const std::string& model : modelIds()) {
    const auto found = counts.find(model);
    if (found == counts.end() || found->second <= most) continue;
    most = found->second;
    best = model;
  }
  return best;
}

std::vector<FleetGroup> groupsOf(const std::vector<FleetUnit>& units) {
  std::map<std::pair<int, int>, FleetGroup> by_size;
  for (std::size_t i = 0; i < units.size(); ++i) {
    FleetGroup& group = by_size[{units[i].size.width, units[i].size.height}];
    group.size = units[i].size;
    group.units.push_back(i);
  }
  std::vector<FleetGroup> groups;
  for (auto& [size, group] : by_size) groups.push_back(std::move(group));
  std::ranges::stable_sort(groups, std::ranges::greater(),
                           [](const FleetGroup& g) { return g.units.size(); });
  return groups;
}

// Nothing if there are too few units of one model.
std::optional<TypicalCamera> typicalOf(const std::vector<FleetUnit>& units, const FleetGroup& group) {
  const std::string model = commonModel(units, group.units);
  std::vector<PopulationSample> samples;
  std::size_t num_without = 0;
  for (const std::size_t i : group.units) {
    if (units[i].camera.modelId() != model) continue;
    samples.push_back(sampleOf(units[i]));
    num_without += units[i].covariance.empty() ? 1 : 0;
  }
  if (samples.size() < kFewestUnits) return std::nullopt;
  Population population = estimatePopulation(samples);
  const std::span<const double> mean(population.mean.data(),
                                     static_cast<std::size_t>(population.mean.size()));
  return TypicalCamera{.camera = AnyCamera::make(model, mean),
                       .population = population,
                       .num_units = samples.size(),
                       .num_without_covariance = num_without,
                       .can_judge = samples.size() >= fewestForOutliers(mean.size())};
}

FleetMap mapOf(ImageSize size, const std::vector<Comparison>& comparisons) {
  const DifferenceOptions grid = differenceOptions(size, std::nullopt);
  FleetMap map{.columns = grid.columns,
               .rows = grid.rows,
               .pixels = matchedGrid(size, size, matchImages(size, size, 0), grid.columns, grid.rows).pixels};
  for (std::size_t p = 0; p < map.pixels.size(); ++p) {
    std::vector<double> lengths;
    for (const Comparison& comparison : comparisons)
      if (comparison.result.is_comparable && std::isfinite(comparison.lengths[p]))
        lengths.push_back(comparison.lengths[p]);
    map.median_px.push_back(lengths.empty() ? kFleetNan : medianOf(lengths));
    map.p95_px.push_back(lengths.empty() ? kFleetNan : quantile95(std::move(lengths)));
  }
  return map;
}

void setTest(const TypicalCamera& typical, const FleetUnit& unit, bool is_of_model, bool is_member,
             Comparison& comparison) {
  if (!comparison.result.is_comparable || !comparison.significance || !typical.can_judge) return;
  const double share = is_of_model ? betweenShare(typical.population, sampleOf(unit)) : 1;
  comparison.result.sigmas = normalOfSquares(
      comparison.significance->squares, std::max(1.0, comparison.significance->directions),
      static_cast<double>(std::min(typical.population.numMembers(), kMostForSpread)), share, is_member);
}

void compareWithTypical(const std::vector<FleetUnit>& units, const FleetOptions& options, FleetGroup& group,
                        const std::function<void()>& countOne) {
  if (!group.typical) return;
  const TypicalCamera& typical = *group.typical;
  const ComparedCamera centre{
      .camera = &typical.camera, .size = group.size, .covariance = typical.population.predictive()};
  std::vector<Comparison> comparisons(group.units.size());
  std::vector<bool> is_of_model;
  std::vector<bool> is_member;
  std::size_t num_of_model = 0;
  for (const std::size_t i : group.units) {
    is_of_model.push_back(units[i].camera.modelId() == typical.camera.modelId());
    is_member.push_back(is_of_model.back() && typical.population.is_member[num_of_model]);
    num_of_model += is_of_model.back() ? 1 : 0;
  }
  parallelFor(
      group.units.size(), options.jobs,
      [&](std::size_t i) {
        const FleetUnit& unit = units[group.units[i]];
        comparisons[i] = compared(centre, unit.compared(), options.freed);
        setTest(typical, unit, is_of_model[i], is_member[i], comparisons[i]);
        countOne();
      },
      options.cancel);
  std::vector<double> distances;
  for (const Comparison& comparison : comparisons) {
    group.differences.push_back(comparison.result);
    if (!comparison.result.is_comparable) continue;
    distances.push_back(comparison.result.p95_px);
    group.num_within += comparison.result.p95_px <= options.tolerance_px ? 1 : 0;
  }
  if (distances.empty()) return;
  group.median_px = medianOf(distances);
  group.p95_px = quantile95(std::move(distances));
  group.map = mapOf(group.size, comparisons);
}

// Tests all units of the fleet together.
void testDeviations(std::vector<FleetGroup>& groups) {
  std::vector<double> p_values;
  for (const FleetGroup& group : groups)
    for (const UnitDifference& difference : group.differences)
      p_values.push_back(shareAbove(difference.sigmas));
  const std::vector<bool> positive = falseDiscoveryTest(p_values, kFalseShare);
  std::size_t i = 0;
  for (FleetGroup& group : groups)
    for (UnitDifference& difference : group.differences) difference.is_significant = positive[i++];
}

UnitDrift driftOf(const FleetUnit& unit, const FleetUnit& previous, std::optional<Freed> freed) {
  UnitDrift drift{.previous = previous.file};
  try {
    const Comparison comparison = compared(previous.compared(), unit.compared(), freed);
    drift.difference = comparison.result;
    if (comparison.significance && drift.difference.is_comparable)
      drift.difference.sigmas = comparison.significance->sigmas;
    if (!drift.difference.is_comparable) drift.reason = "the cameras have too little in common";
  } catch (const Error& reason) {
    drift.reason = reason.what();
  }
  return drift;
}

void setDrifts(const FleetFiles& previous, const FleetOptions& options, Fleet& fleet,
               const std::function<void()>& countOne) {
  fleet.has_previous = true;
  fleet.unreadable_previous = previous.unreadable;
  const auto pairs = pairedUnits(fleet.files.units, previous.units);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i]) {
      fleet.drifts.push_back({.unit = i, .previous = {}});
    } else {
      ++fleet.num_unpaired;
    }
  }
  parallelFor(
      fleet.drifts.size(), options.jobs,
      [&](std::size_t d) {
        const std::size_t unit = fleet.drifts[d].unit;
        fleet.drifts[d] = driftOf(fleet.files.units[unit], previous.units[*pairs[unit]], options.freed);
        fleet.drifts[d].unit = unit;
        countOne();
      },
      options.cancel);
  const std::vector<bool> positive = falseDiscoveryTest(
      mapped(fleet.drifts, [](const UnitDrift& drift) { return shareAbove(drift.difference.sigmas); }),
      kFalseShare);
  for (std::size_t d = 0; d < fleet.drifts.size(); ++d)
    fleet.drifts[d].difference.is_significant = positive[d];
}

}  // namespace

std::size_t FleetGroup::numDeviating() const {
  return static_cast<std::size_t>(std::ranges::count(differences, true, &UnitDifference::is_significant));
}

std::size_t Fleet::numDeviating() const {
  std::size_t sum = 0;
  for (const FleetGroup& group : groups) sum += group.numDeviating();
  return sum;
}

std::size_t Fleet::numDrifted() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(drifts, [](const UnitDrift& d) { return d.difference.is_significant; }));
}

std::size_t Fleet::count(std::optional<Verdict> verdict) const {
  return static_cast<std::size_t>(std::ranges::count(files.units, verdict, &FleetUnit::verdict));
}

Fleet analyseFleet(FleetFiles files, const std::optional<FleetFiles>& previous, const FleetOptions& options) {
  Fleet fleet{.files = std::move(files), .groups = {}, .tolerance_px = options.tolerance_px};
  fleet.groups = groupsOf(fleet.files.units);
  const std::size_t total = fleet.files.units.size() * (previous ? 2 : 1);
  std::mutex mutex;
  std::size_t num_done = 0;
  const auto countOne = [&] {
    if (!options.progress) return;
    const std::lock_guard lock(mutex);
    options.progress(++num_done, total);
  };
  for (FleetGroup& group : fleet.groups) {
    group.typical = typicalOf(fleet.files.units, group);
    compareWithTypical(fleet.files.units, options, group, countOne);
  }
  testDeviations(fleet.groups);
  if (previous) setDrifts(*previous, options, fleet, countOne);
  return fleet;
}

CameraRecord typicalRecord(const FleetGroup& group, double tolerance_px, std::string created_by) {
  expect(group.typical.has_value(), "the group has a typical camera");
  const Population& population = group.typical->population;
  CameraRecord record = bareRecord(group.typical->camera, group.size, std::move(created_by));
  const Eigen::MatrixXd covariance = population.predictive();
  CalibrationRecord stated;
  stated.accuracy_px = group.p95_px;
  if (!(group.p95_px <= tolerance_px)) stated.verdict = Verdict::kReservations;
  stated.covariance = lowerTriangle(covariance);
  for (Eigen::Index j = 0; j < covariance.rows(); ++j)
    stated.parameter_std.push_back(std::sqrt(std::max(0.0, covariance(j, j))));
  stated.findings = {"typical_of_fleet"};
  record.name.name = "typical";
  record.calibration = std::move(stated);
  return record;
}

}  // namespace alidade
