// SPDX-License-Identifier: MIT
#include "alidade/fleet/fleet.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <Eigen/Cholesky>

#include "alidade/camera/model_fit.h"
#include "alidade/core/random.h"
#include "support/drawn_fleet.h"

namespace alidade {
namespace {

const CameraPopulation& population() {
  static const CameraPopulation all;
  return all;
}

FleetFiles filesOf(const std::vector<CameraRecord>& records) {
  FleetFiles files{.num_files = records.size()};
  for (std::size_t i = 0; i < records.size(); ++i) {
    const std::string name = "camera" + std::to_string(i) + ".yaml";
    files.units.push_back(unitOf(records[i], name, name));
  }
  return files;
}

Fleet analysed(const std::vector<CameraRecord>& records, const FleetOptions& options = {}) {
  return analyseFleet(filesOf(records), std::nullopt, options);
}

// Fleets of 200 cameras in which none deviates: at most one in a hundred may have a false alarm, so that of
// these few none should, and the typical camera is as far from the truth as it says.
TEST(Fleet, AccusesNobodyWhereNobodyDeviates) {
  constexpr int kFleets = 8;
  constexpr std::size_t kUnits = 200;
  int num_with_alarm = 0;
  std::size_t num_alarms = 0;
  double squares = 0;
  double variance_ratio = 0;
  double most_sigmas = 0;
  for (int f = 0; f < kFleets; ++f) {
    const Fleet fleet = analysed(population().drawFleet(kUnits, 100 + static_cast<std::uint64_t>(f)));
    ASSERT_EQ(fleet.groups.size(), 1u);
    const FleetGroup& group = fleet.groups.front();
    ASSERT_TRUE(group.typical && group.typical->can_judge);
    num_alarms += group.numDeviating();
    num_with_alarm += group.numDeviating() > 0 ? 1 : 0;
    for (const UnitDifference& difference : group.differences)
      most_sigmas = std::max(most_sigmas, difference.sigmas);
    const Population& found = group.typical->population;
    const auto truth = population().mean().parameters();
    const Eigen::VectorXd off = found.mean - Eigen::Map<const Eigen::VectorXd>(truth.data(), 9);
    squares += off.dot(found.mean_covariance.ldlt().solve(off)) / kFleets;
    variance_ratio +=
        found.between.diagonal().cwiseQuotient(population().between().diagonal()).mean() / kFleets;
  }
  EXPECT_LE(num_with_alarm, 1);
  EXPECT_LE(num_alarms, kUnits * kFleets / 100);
  EXPECT_NEAR(squares, 9, 4);  // chi-squared with 72 degrees of freedom, over 8: 9 +- 1.5
  EXPECT_NEAR(variance_ratio, 1, 0.1);
  // The tests are not blind either: of 1600 normal variables the largest is about 3.2.
  EXPECT_GT(most_sigmas, 2.5);
  EXPECT_LT(most_sigmas, 5);
}

TEST(Fleet, FindsUnitsThatDeviate) {
  const std::vector<std::size_t> deviants = {7, 50, 51, 120, 199};
  auto records = population().drawFleet(200, 3);
  Random random(4);
  for (const std::size_t i : deviants) {
    Eigen::VectorXd changed = population().drawUnit(random);
    changed(4) += 0.02;  // a lens of another kind: 10 standard deviations
    records[i] = population().calibrated(changed, 0.1, random);
  }
  const Fleet fleet = analysed(records);
  const FleetGroup& group = fleet.groups.front();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const bool is_deviant = std::ranges::count(deviants, i) > 0;
    EXPECT_EQ(group.differences[i].is_significant, is_deviant) << i;
    if (is_deviant) {
      EXPECT_FALSE(group.typical->population.is_member[i]) << i;
    }
  }
  // One in a thousand of the others is left out by chance.
  EXPECT_GE(group.typical->population.numMembers(), 200 - deviants.size() - 2);
  EXPECT_EQ(fleet.numDeviating(), deviants.size());
}

TEST(Fleet, CountsUnitsWithinTheTolerance) {
  const auto records = population().drawFleet(60, 5);
  const Fleet wide = analysed(records, {.tolerance_px = 1000});
  EXPECT_EQ(wide.groups.front().num_within, 60u);
  const FleetGroup& group = wide.groups.front();
  const Fleet narrow = analysed(records, {.tolerance_px = group.median_px});
  EXPECT_NEAR(static_cast<double>(narrow.groups.front().num_within), 30, 1);
  EXPECT_LT(group.median_px, group.p95_px);
  // 20 pixels across the image, and the map holds what the units say.
  EXPECT_EQ(group.map.columns, 20);
  EXPECT_EQ(group.map.rows, 15);
  ASSERT_EQ(group.map.p95_px.size(), 300u);
  for (std::size_t i = 0; i < group.map.p95_px.size(); ++i)
    EXPECT_LE(group.map.median_px[i], group.map.p95_px[i]);
}

TEST(Fleet, DoesNotDependOnTheNumberOfThreads) {
  const auto records = population().drawFleet(30, 6);
  const Fleet one = analysed(records, {.jobs = 1});
  const Fleet two = analysed(records, {.jobs = 2});
  for (std::size_t i = 0; i < records.size(); ++i) {
    EXPECT_EQ(one.groups[0].differences[i].p95_px, two.groups[0].differences[i].p95_px);
    EXPECT_EQ(one.groups[0].differences[i].sigmas, two.groups[0].differences[i].sigmas);
  }
}

// A previous calibration of each unit, of which some have changed since by half a pixel.
TEST(Fleet, FindsADriftOfHalfAPixel) {
  constexpr std::size_t kUnits = 100;
  const std::vector<std::size_t> drifted = {3, 40, 77, 98};
  std::vector<CameraRecord> now;
  std::vector<CameraRecord> before;
  for (std::size_t i = 0; i < kUnits; ++i) {
    Random random(streamSeed(21, i));
    const Eigen::VectorXd unit = population().drawUnit(random);
    const bool is_drifted = std::ranges::count(drifted, i) > 0;
    before.push_back(population().calibrated(unit, 0.1, random));
    now.push_back(population().calibrated(is_drifted ? withFocalError(unit, population().size(), 0.5) : unit,
                                          0.1, random));
  }
  std::ranges::reverse(before);
  FleetFiles previous = filesOf(before);
  for (std::size_t i = 0; i < kUnits; ++i)
    previous.units[i].place = "camera" + std::to_string(kUnits - 1 - i) + ".yaml";
  const Fleet fleet = analyseFleet(filesOf(now), previous, {});
  ASSERT_EQ(fleet.drifts.size(), kUnits);
  EXPECT_EQ(fleet.num_unpaired, 0u);
  for (const UnitDifference& drift : fleet.drifts) {
    const bool is_drifted = std::ranges::count(drifted, drift.unit) > 0;
    EXPECT_EQ(drift.is_significant, is_drifted) << drift.unit;
    if (is_drifted) {
      EXPECT_NEAR(drift.max_px, 0.5, 0.25) << drift.unit;
    }
  }
  EXPECT_EQ(fleet.numDrifted(), drifted.size());
}

TEST(Fleet, GroupsByImageSizeAndComparesOtherModelsByProjection) {
  auto records = population().drawFleet(40, 9);
  // The same lens in another model, and one that differs.
  const auto inOtherModel = [&](const CameraRecord& record) {
    return bareRecord(fitModel(record.camera, record.image_size, "rational").camera, record.image_size,
                      "a test");
  };
  records.push_back(inOtherModel(records[0]));
  Random random(10);
  records.push_back(inOtherModel(population().calibrated(
      withFocalError(population().drawUnit(random), population().size(), 40), 0.1, random)));
  for (int i = 0; i < 2; ++i) {
    records.push_back(bareRecord(AnyCamera::make("pinhole", std::vector<double>{500.0 + i, 500, 320, 240}),
                                 {640, 480}, "a test"));
  }
  const Fleet fleet = analysed(records);
  ASSERT_EQ(fleet.groups.size(), 2u);
  const FleetGroup& group = fleet.groups[0];
  ASSERT_EQ(group.units.size(), 42u);
  EXPECT_EQ(group.typical->num_units, 40u);
  EXPECT_EQ(group.typical->num_without_covariance, 0u);
  EXPECT_NEAR(group.differences[40].p95_px, group.differences[0].p95_px, 0.02);
  EXPECT_FALSE(group.differences[40].is_significant);
  EXPECT_TRUE(group.differences[41].is_significant);
  EXPECT_EQ(fleet.numDeviating(), 1u);
  EXPECT_FALSE(fleet.groups[1].typical);
  EXPECT_TRUE(fleet.groups[1].differences.empty());
}

TEST(Fleet, JudgesNobodyByFewUnits) {
  auto records = population().drawFleet(8, 12);
  const auto params = records[0].camera.parameters();
  std::vector<double> changed(params.begin(), params.end());
  changed[0] *= 1.2;
  records[0].camera = AnyCamera::make("radtan", changed);
  const Fleet fleet = analysed(records);
  ASSERT_TRUE(fleet.groups[0].typical);
  EXPECT_FALSE(fleet.groups[0].typical->can_judge);
  EXPECT_EQ(fleet.numDeviating(), 0u);
  EXPECT_GT(fleet.groups[0].differences[0].p95_px, 50);
  EXPECT_TRUE(std::isnan(fleet.groups[0].differences[0].sigmas));
}

TEST(Fleet, TakesUnitsWithoutCovarianceForExact) {
  auto records = population().drawFleet(60, 13);
  for (CameraRecord& record : records) record.calibration.reset();
  const Fleet fleet = analysed(records);
  EXPECT_EQ(fleet.groups[0].typical->num_without_covariance, 60u);
  EXPECT_EQ(fleet.count(std::nullopt), 60u);
  EXPECT_EQ(fleet.numDeviating(), 0u);
  EXPECT_TRUE(std::isfinite(fleet.groups[0].differences[0].sigmas));
}

TEST(Fleet, WritesTheTypicalCameraWithWhatOneMoreUnitMayDiffer) {
  const Fleet fleet = analysed(population().drawFleet(80, 14));
  const FleetGroup& group = fleet.groups[0];
  const CameraRecord record = typicalRecord(group, 1, "a test");
  const Eigen::MatrixXd covariance = *statedCovariance(record);
  EXPECT_TRUE(covariance.isApprox(group.typical->population.predictive(), 1e-12));
  EXPECT_EQ(record.calibration->accuracy_px, group.p95_px);
  EXPECT_EQ(record.image_size, population().size());
  EXPECT_EQ(record.name.name, "typical");
  EXPECT_EQ(record.calibration->verdict, Verdict::kReservations);
  EXPECT_EQ(typicalRecord(group, group.p95_px, "a test").calibration->verdict, Verdict::kTrustworthy);
}

TEST(Fleet, OfNoUnitsIsEmpty) {
  const Fleet fleet = analysed({});
  EXPECT_TRUE(fleet.groups.empty());
  EXPECT_EQ(fleet.numDeviating(), 0u);
}

}  // namespace
}  // namespace alidade
