// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "alidade/adjust/board/places.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr std::size_t kFewestPlaces = 3;  // in a group

// Basis of the determined directions in which the information of all places together is 1.
Eigen::MatrixXd unitBasis(const Eigen::MatrixXd& information) {
  constexpr double kNothing = 1e-10;
  const Eigen::VectorXd scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const SymmetricEigen solver(scale.asDiagonal() * information * scale.asDiagonal());
  const Eigen::VectorXd values = solver.eigenvalues();
  const auto num_known = (values.array() > kNothing * values.maxCoeff()).count();  // they ascend
  return scale.asDiagonal() * solver.eigenvectors().rightCols(num_known) *
         values.tail(num_known).cwiseSqrt().cwiseInverse().asDiagonal();
}

// Cost of an offset d of the intrinsics by the evidence of a place: half of d^T S d + 2 g^T d, in units of
// the noise.
double costOf(const Reduced& place, const Eigen::VectorXd& d) {
  return 0.5 * d.dot(place.information * d) + place.gradient.dot(d);
}

struct Division {
  std::vector<int> group;  // 0 or 1 per place
  std::array<Eigen::VectorXd, 2> offset;
  double cost = std::numeric_limits<double>::infinity();
};

bool isLargeEnough(const std::vector<int>& group) {
  const auto ones = static_cast<std::size_t>(std::ranges::count(group, 1));
  return ones >= kFewestPlaces && group.size() - ones >= kFewestPlaces;
}

// The offset with the lowest cost for a group. All places together have information 1 in each direction;
// directions with less than a hundredth of that from the group hardly move.
Eigen::VectorXd offsetOf(std::span<const Reduced> places, const std::vector<int>& group, int which) {
  constexpr double kLittle = 0.01;
  Eigen::MatrixXd S =
      kLittle * Eigen::MatrixXd::Identity(places[0].information.rows(), places[0].information.cols());
  Eigen::VectorXd g = Eigen::VectorXd::Zero(S.rows());
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (group[i] != which) continue;
    S += places[i].information;
    g += places[i].gradient;
  }
  return -S.ldlt().solve(g);
}

// k-means, starting from a given assignment.
std::optional<Division> divided(std::span<const Reduced> places, std::vector<int> group) {
  constexpr int kMaxRounds = 30;
  Division division;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (!isLargeEnough(group)) return std::nullopt;
    for (int k = 0; k < 2; ++k) division.offset[static_cast<std::size_t>(k)] = offsetOf(places, group, k);
    division.group = group;
    division.cost = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double first = costOf(places[i], division.offset[0]);
      const double second = costOf(places[i], division.offset[1]);
      group[i] = second < first ? 1 : 0;
      division.cost += std::min(first, second);
    }
    if (group == division.group) break;
  }
  return division;
}

// Tries initial assignments by the sign of the pulls along each of the directions in which they are largest.
std::optional<Division> bestDivision(std::span<const Reduced> places) {
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(places[0].information.rows(), places[0].information.cols());
  for (const Reduced& place : places) squares += place.gradient * place.gradient.transpose();
  const SymmetricEigen solver(squares);
  std::optional<Division> best;
  for (Eigen::Index k = 0; k < squares.cols(); ++k) {
    std::vector<int> group;
    for (const Reduced& place : places)
      group.push_back(solver.eigenvectors().col(k).dot(place.gradient) > 0 ? 1 : 0);
    auto division = divided(places, std::move(group));
    if (division && (!best || division->cost < best->cost)) best = std::move(division);
  }
  return best;
}

// Groups places by the names of their views: names from two cameras usually differ in more than a number, or
// are in two folders. Nothing unless there are exactly two kinds of names.
std::optional<std::vector<int>> groupsByName(const Fit& fit, std::span<const std::size_t> place_of,
                                             std::size_t num_places) {
  std::vector<std::string> kinds;
  std::vector<int> group(num_places, 0);
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const std::string& name = fit.views[v].image;
    const auto slash = name.find_last_of('/');
    std::string kind = slash == std::string::npos ? "" : name.substr(0, slash + 1);
    for (const char c : name.substr(kind.size())) {
      if (c < '0' || c > '9') kind += c;
    }
    auto at = std::ranges::find(kinds, kind);
    if (at == kinds.end()) at = kinds.insert(kinds.end(), kind);
    group[place_of[v]] = static_cast<int>(at - kinds.begin());
  }
  if (kinds.size() != 2 || !isLargeEnough(group)) return std::nullopt;
  return group;
}

// F statistic of a division that was chosen independently of the data: gain of two offsets per parameter,
// over the remaining differences between places of a group.
double statistic(std::span<const Reduced> places, const Division& division) {
  constexpr double kSilent = 1e-6;
  double gain = 0;
  double left = 0;
  const auto num_free = static_cast<double>(places[0].gradient.size());
  double freedom = -2 * num_free;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::VectorXd& d = division.offset[static_cast<std::size_t>(division.group[i])];
    gain -= 2 * costOf(places[i], d);
    const SymmetricEigen solver(places[i].information);
    const Eigen::VectorXd pull =
        solver.eigenvectors().transpose() * (places[i].gradient + places[i].information * d);
    for (Eigen::Index k = 0; k < pull.size(); ++k) {
      if (!(solver.eigenvalues()(k) > kSilent)) continue;
      left += pull(k) * pull(k) / solver.eigenvalues()(k);
      ++freedom;
    }
  }
  return freedom > 0 ? gain / num_free / (left / freedom) : 0.0;
}

// Position of each view along the line between the offsets, which are at -1/2 and 1/2, with its variance by
// noise.
struct Estimate {
  double value;
  double variance;
};

// For each place, offsets are computed from the other places. Otherwise each of a few places would be near
// the offset of its own group, for any grouping, since with this many parameters some line always separates
// them.
std::vector<Estimate> estimatesOf(std::span<const Reduced> places, const Division& division) {
  std::vector<Estimate> estimates;
  std::vector<int> group = division.group;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Reduced& place = places[i];
    constexpr int kLeftOut = -1;
    const int own = std::exchange(group[i], kLeftOut);
    const Eigen::VectorXd first = offsetOf(places, group, 0);
    const Eigen::VectorXd second = offsetOf(places, group, 1);
    group[i] = own;
    const Eigen::VectorXd apart = second - first;
    const Eigen::VectorXd middle = 0.5 * (first + second);
    const double precision = apart.dot(place.information * apart);
    if (!(precision > 0)) continue;
    estimates.push_back({.value = -apart.dot(place.gradient + place.information * middle) / precision,
                         .variance = 1 / precision});
  }
  return estimates;
}

double logNormal(double x, double variance) {
  return -0.5 * (x * x / variance + std::log(2 * std::numbers::pi * variance));
}

// Log likelihood of one normal distribution of a given width.
double singleLikelihood(std::span<const Estimate> estimates, double width) {
  double weights = 0;
  double values = 0;
  for (const Estimate& e : estimates) {
    weights += 1 / (e.variance + width * width);
    values += e.value / (e.variance + width * width);
  }
  double sum = 0;
  for (const Estimate& e : estimates)
    sum += logNormal(e.value - values / weights, e.variance + width * width);
  return sum;
}

struct Mixture {
  double likelihood = -std::numeric_limits<double>::infinity();
  double separation = 0;   // between the means, in widths
  double num_smaller = 0;  // places in the smaller group
};

// Mixture of two normal distributions of this width, by expectation maximisation (Dempster, Laird and Rubin
// 1977, Maximum likelihood from incomplete data via the EM algorithm, Journal of the Royal Statistical
// Society B 39(1)).
Mixture mixtureOf(std::span<const Estimate> estimates, double width) {
  constexpr int kRounds = 50;
  const auto n = static_cast<double>(estimates.size());
  double share = 0.5;
  std::array<double, 2> mean = {-0.5, 0.5};
  Mixture mixture;
  for (int round = 0; round < kRounds; ++round) {
    const double before = std::exchange(mixture.likelihood, 0.0);
    double in_second = 0;
    std::array<double, 2> weights = {0, 0};
    std::array<double, 2> values = {0, 0};
    for (const Estimate& e : estimates) {
      const double variance = e.variance + width * width;
      const double first = std::log(1 - share) + logNormal(e.value - mean[0], variance);
      const double second = std::log(share) + logNormal(e.value - mean[1], variance);
      const double both = std::max(first, second) + std::log1p(std::exp(-std::abs(first - second)));
      const std::array<double, 2> chance = {std::exp(first - both), std::exp(second - both)};
      mixture.likelihood += both;
      in_second += chance[1];
      for (std::size_t k = 0; k < 2; ++k) {
        weights[k] += chance[k] / variance;
        values[k] += chance[k] * e.value / variance;
      }
    }
    constexpr double kAtRest = 1e-3;  // far below any relevant evidence
    mixture.num_smaller = std::min(in_second, n - in_second);
    if (std::abs(mixture.likelihood - before) < kAtRest) break;
    share = std::clamp(in_second / n, 1 / n, 1 - 1 / n);
    for (std::size_t k = 0; k < 2; ++k) {
      if (weights[k] > 0) mean[k] = values[k] / weights[k];
    }
  }
  mixture.separation = std::abs(mean[1] - mean[0]) / width;
  return mixture;
}

// True if the places form two groups and not one of any width.
bool areTwoGroups(std::span<const Estimate> estimates) {
  constexpr double kEvidence = 6;  // difference of log likelihoods; exceeded by one of 500 simulated cameras
  constexpr double kSeparation = 6;  // up to 5 if no lens of the model matches the real one
  double single = -std::numeric_limits<double>::infinity();
  Mixture mixture;
  for (double width = 1e-3; width < 2; width *= 1.7) {
    single = std::max(single, singleLikelihood(estimates, width));
    const Mixture of_width = mixtureOf(estimates, width);
    if (of_width.likelihood > mixture.likelihood) mixture = of_width;
  }
  constexpr double kRounding = 0.5;
  const bool are_groups =
      mixture.num_smaller > static_cast<double>(kFewestPlaces) - kRounding;  // no single odd view
  return are_groups && mixture.likelihood - single > kEvidence && mixture.separation > kSeparation;
}

// A division by names is tested first, because it does not depend on the data.
std::optional<Division> significantDivision(std::span<const Reduced> places,
                                            const std::optional<std::vector<int>>& by_name) {
  constexpr double kNamedF = 4;  // at most 3 for halves of real sets if the model fits the lens
  if (by_name) {
    Division named{.group = *by_name,
                   .offset = {offsetOf(places, *by_name, 0), offsetOf(places, *by_name, 1)}};
    if (statistic(places, named) > kNamedF) return named;
  }
  auto division = bestDivision(places);
  if (!division || !areTwoGroups(estimatesOf(places, *division))) return std::nullopt;
  return division;
}

}  // namespace

std::optional<TwoCameras> twoCameras(const Fit& fit, double variance) {
  const FitCamera& camera = onlyCamera(fit);
  const Eigen::MatrixXd directions =
      freeDirections(static_cast<int>(camera.params.size()), camera.constraint);
  const std::vector<std::size_t> place_of = placesOf(fit);
  const std::vector<Reduced> pulls = sumByPlace(reduced(fit, LossWeights::kUse), place_of);
  if (directions.cols() == 0 || pulls.size() < 2 * kFewestPlaces || !(variance > 0)) return std::nullopt;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(directions.cols(), directions.cols());
  for (const Reduced& pull : pulls) information += directions.transpose() * pull.information * directions;
  const Eigen::MatrixXd basis = directions * unitBasis(information);
  if (basis.cols() == 0) return std::nullopt;
  std::vector<Reduced> places;
  for (const Reduced& pull : pulls) {
    places.push_back({.information = basis.transpose() * pull.information * basis,
                      .gradient = basis.transpose() * pull.gradient / std::sqrt(variance)});
  }
  const auto division = significantDivision(places, groupsByName(fit, place_of, pulls.size()));
  if (!division) return std::nullopt;
  const auto num_second = std::ranges::count(division->group, 1);
  const int minority = 2 * num_second > static_cast<std::ptrdiff_t>(places.size()) ? 0 : 1;
  TwoCameras result;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    if (division->group[place_of[v]] == minority) result.minority.push_back(v);
  }
  const Eigen::VectorXd apart = division->offset[1] - division->offset[0];
  const Eigen::VectorXd step = (minority == 1 ? 1.0 : -1.0) * std::sqrt(variance) * (basis * apart);
  result.params_step.assign(step.begin(), step.begin() + static_cast<std::ptrdiff_t>(camera.numLensParams()));
  return result;
}

}  // namespace alidade
