// SPDX-License-Identifier: MIT
#include "alidade/fleet/population.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "alidade/core/random.h"

namespace alidade {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kK = 4;

VectorXd normals(Random& random, Eigen::Index k = kK) {
  VectorXd z(k);
  for (double& value : z) value = random.normal();
  return z;
}

// Units of the parameters differ as those of cameras do.
const VectorXd& units() {
  static const VectorXd all = (VectorXd(kK) << 3, 5, 2e-3, 1e-4).finished();
  return all;
}

MatrixXd trueRoot() {
  MatrixXd root(kK, kK);
  root << 1, 0, 0, 0, 0.8, 0.5, 0, 0, -0.3, 0.2, 1, 0, 0, 0.4, -0.9, 0.3;
  return units().asDiagonal() * root;
}

VectorXd trueMean() {
  return (VectorXd(kK) << 1000, 640, -0.2, 5e-4).finished();
}

// Each measured with an error of its own size, from a tenth of the spread to twice of it.
std::vector<PopulationSample> drawSamples(std::size_t count, Random& random) {
  const MatrixXd root = trueRoot();
  std::vector<PopulationSample> samples;
  for (std::size_t i = 0; i < count; ++i) {
    const double size = 0.1 * std::pow(20, random.uniform());
    MatrixXd error = MatrixXd::Zero(kK, kK);
    for (int j = 0; j < kK; ++j) error(j, j) = size * units()(j);
    error(1, 0) = 0.5 * size * units()(1);
    samples.push_back({.value = trueMean() + root * normals(random) + error * normals(random),
                       .covariance = error * error.transpose()});
  }
  return samples;
}

// Over many fleets the estimates are right in the mean, and the mean is as far off as it says.
TEST(Population, EstimatesMeanAndSpreadWithinTheirUncertainty) {
  constexpr int kFleets = 300;
  const MatrixXd truth = trueRoot() * trueRoot().transpose();
  double squares = 0;
  int num_beyond = 0;
  VectorXd variances = VectorXd::Zero(kK);
  std::size_t num_left_out = 0;
  for (int f = 0; f < kFleets; ++f) {
    Random random(streamSeed(17, static_cast<std::uint64_t>(f)));
    const auto samples = drawSamples(200, random);
    const Population found = estimatePopulation(samples);
    const VectorXd off = found.mean - trueMean();
    const double distance = off.dot(found.mean_covariance.ldlt().solve(off));
    squares += distance / kFleets;
    num_beyond += distance > 9.487729036781154 ? 1 : 0;  // 95 % of chi-squared with 4 degrees of freedom
    variances += found.between.diagonal().cwiseQuotient(truth.diagonal()) / kFleets;
    num_left_out += samples.size() - found.numMembers();
  }
  // The spread is estimated too, mostly from the fewer samples with small errors, and its uncertainty is not
  // in that of the mean: T squared is 4.4 instead of 4 in the mean, and about 7 % instead of 5 % lie beyond.
  EXPECT_NEAR(squares, 4.4, 0.5);
  EXPECT_GT(num_beyond, 0.03 * kFleets);
  EXPECT_LT(num_beyond, 0.12 * kFleets);
  for (int j = 0; j < kK; ++j) EXPECT_NEAR(variances(j), 1, 0.05) << j;
  // One in a thousand lies beyond the limit by chance.
  EXPECT_LE(num_left_out, 150u);
}

TEST(Population, RemovesTheErrorsOfTheMeasurements) {
  // The same camera, measured again and again: nothing but errors.
  Random random(3);
  std::vector<PopulationSample> samples;
  for (int i = 0; i < 300; ++i) {
    const MatrixXd error = units().asDiagonal();
    samples.push_back({.value = trueMean() + error * normals(random), .covariance = error * error});
  }
  const Population found = estimatePopulation(samples);
  // A variance of 300 samples is known to 8 % (one standard deviation): 0.45 squared is 2.5 of these.
  for (int j = 0; j < kK; ++j) EXPECT_LT(std::sqrt(found.between(j, j)), 0.45 * units()(j)) << j;
}

TEST(Population, LeavesOutWhatDoesNotBelong) {
  Random random(8);
  auto samples = drawSamples(100, random);
  const Population before = estimatePopulation(samples);
  constexpr std::size_t kStrangers = 20;
  for (std::size_t i = 0; i < kStrangers; ++i) {
    samples[5 * i].value(0) += 60;  // 20 standard deviations
    samples[5 * i].value(2) -= 0.03;
  }
  const Population found = estimatePopulation(samples);
  for (std::size_t i = 0; i < kStrangers; ++i) EXPECT_FALSE(found.is_member[5 * i]) << i;
  EXPECT_GE(found.numMembers(), 78u);
  for (int j = 0; j < kK; ++j) {
    EXPECT_NEAR(found.mean(j), before.mean(j), 0.5 * units()(j)) << j;
    EXPECT_NEAR(std::sqrt(found.between(j, j) / before.between(j, j)), 1, 0.35) << j;
  }
}

TEST(Population, KeepsWhatIsTheSameInAllSamples) {
  Random random(4);
  auto samples = drawSamples(30, random);
  for (PopulationSample& sample : samples) {
    sample.value(3) = 0.25;
    sample.covariance.row(3).setZero();
    sample.covariance.col(3).setZero();
  }
  const Population found = estimatePopulation(samples);
  EXPECT_EQ(found.mean(3), 0.25);
  EXPECT_EQ(found.between(3, 3), 0);
  EXPECT_NEAR(found.mean(0), 1000, 4);
  EXPECT_NEAR(betweenShare(found, {.value = found.mean, .covariance = MatrixXd::Zero(kK, kK)}), 1, 1e-6);
}

TEST(Population, KeepsTheMembersOfSmallPopulations) {
  constexpr int kFleets = 60;
  constexpr std::size_t kSamples = 16;
  std::size_t num_left_out = 0;
  for (int f = 0; f < kFleets; ++f) {
    Random random(streamSeed(29, static_cast<std::uint64_t>(f)));
    num_left_out += kSamples - estimatePopulation(drawSamples(kSamples, random)).numMembers();
  }
  EXPECT_LE(num_left_out, kFleets * kSamples / 50);
}

TEST(Population, TakesAllOfFewSamples) {
  Random random(6);
  auto samples = drawSamples(fewestForOutliers(kK) - 1, random);
  samples[0].value(0) += 1000;
  EXPECT_EQ(estimatePopulation(samples).numMembers(), samples.size());
  // Exact samples, fewer than parameters.
  std::vector<PopulationSample> two(2, {.value = trueMean(), .covariance = MatrixXd::Zero(kK, kK)});
  two[1].value(1) += 2;
  const Population found = estimatePopulation(two);
  EXPECT_NEAR(found.mean(1), 641, 1e-6);
  EXPECT_NEAR(found.between(1, 1), 2, 1e-3);
}

}  // namespace
}  // namespace alidade
