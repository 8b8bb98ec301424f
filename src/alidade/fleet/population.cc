// SPDX-License-Identifier: MIT
#include "alidade/fleet/population.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>

#include "alidade/core/error.h"
#include "alidade/core/median.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Subset = std::vector<std::size_t>;

constexpr double kRidge = 1e-10;  // of a scaled variance: covariances of fixed parameters are singular

// The parameters that differ between samples, in units of their spread, because the units of the parameters
// span ten orders of magnitude.
struct ScaledSamples {
  std::vector<Eigen::Index> active;  // indices of these parameters
  VectorXd centre;                   // medians of all parameters
  VectorXd scale;                    // of the active ones
  std::vector<PopulationSample> samples;
};

double deviationOf(std::vector<double> values, double centre) {
  constexpr double kNormalOfMad = 1.482602218505602;  // standard deviation over median deviation
  double squares = 0;
  for (double& value : values) {
    value = std::abs(value - centre);
    squares += value * value;
  }
  const double rms = std::sqrt(squares / static_cast<double>(values.size()));
  const double mad = kNormalOfMad * medianOf(std::move(values));
  // If most samples share one value, the others determine the scale.
  return mad > 0 ? mad : rms;
}

ScaledSamples scaled(std::span<const PopulationSample> samples) {
  constexpr double kNoSpread = 1e-13;
  ScaledSamples result;
  const Eigen::Index k = samples.front().value.size();
  result.centre.resize(k);
  std::vector<double> scales;
  for (Eigen::Index j = 0; j < k; ++j) {
    std::vector<double> values;
    for (const PopulationSample& sample : samples) values.push_back(sample.value(j));
    result.centre(j) = medianOf(values);
    const double spread = deviationOf(values, result.centre(j));
    if (!(spread > kNoSpread * (1 + std::abs(result.centre(j))))) continue;
    result.active.push_back(j);
    scales.push_back(spread);
  }
  result.scale = Eigen::Map<VectorXd>(scales.data(), static_cast<Eigen::Index>(scales.size()));
  const VectorXd inverse = result.scale.cwiseInverse();
  for (const PopulationSample& sample : samples) {
    const VectorXd value = (sample.value - result.centre)(result.active);
    const MatrixXd covariance = sample.covariance(result.active, result.active);
    result.samples.push_back({.value = value.cwiseProduct(inverse),
                              .covariance = inverse.asDiagonal() * covariance * inverse.asDiagonal()});
  }
  return result;
}

MatrixXd inverseOf(const MatrixXd& covariance) {
  const Eigen::Index k = covariance.rows();
  return (covariance + kRidge * MatrixXd::Identity(k, k)).llt().solve(MatrixXd::Identity(k, k));
}

// The mean for a given spread: weighted least squares.
void setMean(std::span<const PopulationSample> samples, const Subset& subset, Population& estimate) {
  const Eigen::Index k = estimate.between.rows();
  MatrixXd information = MatrixXd::Zero(k, k);
  VectorXd weighted = VectorXd::Zero(k);
  for (const std::size_t i : subset) {
    const MatrixXd weight = inverseOf(estimate.between + samples[i].covariance);
    information += weight;
    weighted += weight * samples[i].value;
  }
  estimate.mean_covariance = information.llt().solve(MatrixXd::Identity(k, k));
  estimate.mean = estimate.mean_covariance * weighted;
}

MatrixXd meanError(std::span<const PopulationSample> samples, const Subset& subset) {
  const Eigen::Index k = samples.front().value.size();
  MatrixXd mean = MatrixXd::Zero(k, k);
  for (const std::size_t i : subset) mean += samples[i].covariance / static_cast<double>(subset.size());
  return mean;
}

// The sample covariance less the mean covariance of the measurements. If little or less than nothing remains,
// a share of the measurements' variance: the EM algorithm converges quickly to a smaller spread, but hardly
// leaves zero.
MatrixXd momentEstimate(std::span<const PopulationSample> samples, const Subset& subset,
                        const MatrixXd& error) {
  const Eigen::Index k = samples.front().value.size();
  const auto n = static_cast<double>(subset.size());
  VectorXd mean = VectorXd::Zero(k);
  for (const std::size_t i : subset) mean += samples[i].value / n;
  MatrixXd spread = -error;
  for (const std::size_t i : subset) {
    const VectorXd off = samples[i].value - mean;
    spread += off * off.transpose() / std::max(1.0, n - 1);
  }
  constexpr double kShareOfError = 0.3;
  constexpr double kLeast = 1e-6;
  const SymmetricEigen solver(spread);
  VectorXd variances = solver.eigenvalues();
  for (Eigen::Index j = 0; j < k; ++j) {
    const VectorXd direction = solver.eigenvectors().col(j);
    variances(j) = std::max({variances(j), kShareOfError * direction.dot(error * direction), kLeast});
  }
  return solver.eigenvectors() * variances.asDiagonal() * solver.eigenvectors().transpose();
}

// Estimate by moments only: a single pass, for subsets that will still change.
Population roughEstimate(std::span<const PopulationSample> samples, const Subset& subset) {
  Population estimate;
  estimate.between = momentEstimate(samples, subset, meanError(samples, subset));
  setMean(samples, subset, estimate);
  return estimate;
}

// Every n-th member of the subset, so that at most this many remain.
Subset thinned(const Subset& subset, std::size_t most) {
  if (subset.size() <= most) return subset;
  Subset result;
  for (std::size_t i = 0; i < most; ++i) result.push_back(subset[i * subset.size() / most]);
  return result;
}

// One step of the EM algorithm. @returns the change, as a share of the whole variance
double improve(std::span<const PopulationSample> samples, const Subset& subset, const MatrixXd& error,
               Population& estimate) {
  const Eigen::Index k = estimate.between.rows();
  const auto n = static_cast<double>(subset.size());
  MatrixXd next = MatrixXd::Zero(k, k);
  for (const std::size_t i : subset) {
    // For each member's own deviation: the share that is real, its size, and the remaining uncertainty.
    const MatrixXd share = estimate.between * inverseOf(estimate.between + samples[i].covariance);
    const VectorXd deviation = share * (samples[i].value - estimate.mean);
    next += deviation * deviation.transpose() + estimate.between - share * estimate.between +
            share * estimate.mean_covariance * share.transpose();
  }
  next = (0.5 / n * (next + next.transpose())).eval();
  const auto root = MatrixXd(next + error + kRidge * MatrixXd::Identity(k, k)).llt();
  const MatrixXd half = root.matrixL().solve(next - estimate.between);
  estimate.between = next;
  setMean(samples, subset, estimate);
  return root.matrixL().solve(half.transpose()).norm();
}

Population estimateOf(std::span<const PopulationSample> samples, const Subset& subset) {
  constexpr int kMaxSteps = 100;
  constexpr double kSettled = 1e-4;
  const Subset part = thinned(subset, kMostForSpread);
  Population estimate = roughEstimate(samples, part);
  const MatrixXd error = meanError(samples, part);
  for (int step = 0; step < kMaxSteps && improve(samples, part, error, estimate) > kSettled; ++step) {
  }
  if (part.size() < subset.size()) setMean(samples, subset, estimate);
  return estimate;
}

double squaresOf(const Population& estimate, const PopulationSample& sample) {
  const VectorXd off = sample.value - estimate.mean;
  return off.dot(inverseOf(estimate.between + sample.covariance) * off);
}

// Indices of the `count` samples with the smallest values, in ascending order.
Subset smallest(const std::vector<double>& values, std::size_t count) {
  Subset order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
  order.resize(count);
  std::ranges::sort(order);
  return order;
}

std::vector<double> allSquares(const Population& estimate, std::span<const PopulationSample> samples) {
  std::vector<double> squares;
  for (const PopulationSample& sample : samples) squares.push_back(squaresOf(estimate, sample));
  return squares;
}

// The three quarters of the samples that are nearest to each other.
Subset centralSamples(std::span<const PopulationSample> samples) {
  constexpr int kMaxSteps = 20;
  const std::size_t count = samples.size() - samples.size() / 4;
  std::vector<double> squares;
  for (const PopulationSample& sample : samples) {
    // In units of the robust spread, about the medians.
    const VectorXd whole = sample.covariance.diagonal() + VectorXd::Ones(sample.value.size());
    squares.push_back(sample.value.cwiseAbs2().cwiseQuotient(whole).sum());
  }
  Subset subset = smallest(squares, count);
  for (int step = 0; step < kMaxSteps; ++step) {
    Subset next = smallest(allSquares(roughEstimate(samples, subset), samples), count);
    if (next == subset) break;
    subset = std::move(next);
  }
  return subset;
}

// The squared distance that a further member exceeds once in a thousand cases, for an estimate from this many
// members: Hotelling's distribution.
double limitOfSquares(double k, std::size_t num_members) {
  const auto n = static_cast<double>(num_members);
  const double below = std::max(1.0, n - k);
  return k * (n * n - 1) / (n * below) * fOfNormal(kNormalOneInThousand, k, below);
}

// The members, and the population estimated from them.
std::pair<Subset, Population> membersOf(std::span<const PopulationSample> samples) {
  constexpr int kMaxSteps = 5;
  const auto k = static_cast<double>(samples.front().value.size());
  const Subset central = centralSamples(samples);
  Population estimate = estimateOf(samples, central);
  double limit = limitOfSquares(k, central.size());
  std::vector<double> squares = allSquares(estimate, samples);
  // The core lacks its tails, so its covariance is too small; the median shows by how much.
  const double inflation = std::max(1.0, medianOf(squares) / (k * meanSquareOfNormal(0, k)));
  for (double& value : squares) value /= inflation;
  Subset members;
  for (int step = 0; step < kMaxSteps; ++step) {
    Subset next;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (squares[i] <= limit) next.push_back(i);
    if (next == members || next.size() < 2) break;
    members = std::move(next);
    estimate = estimateOf(samples, members);
    limit = limitOfSquares(k, members.size());
    squares = allSquares(estimate, samples);
  }
  return {std::move(members), std::move(estimate)};
}

}  // namespace

std::size_t fewestForOutliers(std::size_t num_parameters) {
  constexpr std::size_t kSpare = 6;  // more than any covariance fits exactly
  return num_parameters + kSpare;
}

std::size_t Population::numMembers() const {
  return static_cast<std::size_t>(std::ranges::count(is_member, true));
}

Population estimatePopulation(std::span<const PopulationSample> samples) {
  expect(samples.size() >= 2, "a population has two samples or more");
  const ScaledSamples in_units = scaled(samples);
  const auto k = samples.front().value.size();
  Population population{.mean = in_units.centre,
                        .mean_covariance = MatrixXd::Zero(k, k),
                        .between = MatrixXd::Zero(k, k),
                        .is_member = std::vector<bool>(samples.size(), true)};
  if (in_units.active.empty()) return population;
  Population estimate;
  if (samples.size() >= fewestForOutliers(in_units.active.size())) {
    const auto [members, of_members] = membersOf(in_units.samples);
    estimate = of_members;
    population.is_member.assign(samples.size(), false);
    for (const std::size_t i : members) population.is_member[i] = true;
  } else {
    Subset all(samples.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    estimate = estimateOf(in_units.samples, all);
  }
  const auto& unit = in_units.scale;
  population.mean(in_units.active) += estimate.mean.cwiseProduct(unit);
  population.mean_covariance(in_units.active, in_units.active) =
      unit.asDiagonal() * estimate.mean_covariance * unit.asDiagonal();
  population.between(in_units.active, in_units.active) =
      unit.asDiagonal() * estimate.between * unit.asDiagonal();
  return population;
}

double betweenShare(const Population& population, const PopulationSample& sample) {
  const MatrixXd whole = population.between + sample.covariance;
  std::vector<Eigen::Index> active;
  for (Eigen::Index j = 0; j < whole.rows(); ++j)
    if (whole(j, j) > 0) active.push_back(j);
  if (active.empty()) return 0;
  const VectorXd inverse = VectorXd(whole.diagonal()(active)).cwiseSqrt().cwiseInverse();
  const MatrixXd weight = inverseOf(inverse.asDiagonal() * whole(active, active) * inverse.asDiagonal());
  const MatrixXd between = inverse.asDiagonal() * population.between(active, active) * inverse.asDiagonal();
  return (weight * between).trace() / static_cast<double>(active.size());
}

}  // namespace alidade
