// SPDX-License-Identifier: MIT
#include "alidade/calibrate/weak_prior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Eigenvalues>

#include "alidade/calibrate/view_fit.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

constexpr auto kNumAffine = static_cast<Eigen::Index>(kAffineParamNames.size());
constexpr double kNatural = 1;                     // widths of priors are in natural sizes
constexpr std::array<double, 2> kWider = {3, 10};  // at 100, rounding drowns the prior
constexpr std::array<double, 3> kNarrower = {0.3, 0.1, 0.03};
// One standard deviation from which on a combination of the lens' parameters counts as not seen. Where all
// are seen, it is at most a hundredth for polynomials of few terms.
constexpr double kUnseen = 0.3;
// Size to which a prior should bring every parameter; where none does, to which it must.
constexpr double kAtHome = 0.25;
constexpr double kBounded = 1.5;
// A prior that raises twice the cost of the corners by more variances than this contradicts them.
constexpr double kContradiction = 25;
constexpr double kDominant = 0.3;  // share of the unseen combination from which on a parameter is named
constexpr double kSameCost = 1e-9;
constexpr double kSingular = 1e-13;

// Inverse of a symmetric matrix on what is free, or nothing where that is singular to working precision.
std::optional<Eigen::MatrixXd> inverseOn(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& directions) {
  const Eigen::MatrixXd free = directions.transpose() * matrix * directions;
  const Eigen::VectorXd scale = free.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * free * scale.asDiagonal());
  const Eigen::VectorXd& values = solver.eigenvalues();
  if (solver.info() != Eigen::Success || !(values(0) > kSingular * values(values.size() - 1)))
    return std::nullopt;
  const Eigen::MatrixXd& vectors = solver.eigenvectors();
  const Eigen::MatrixXd inverse = vectors * values.cwiseInverse().asDiagonal() * vectors.transpose();
  return directions * (scale.asDiagonal() * inverse * scale.asDiagonal()) * directions.transpose();
}

// The combination of the lens' parameters that is known least.
struct LeastKnown {
  double sigma = 0;           // in natural sizes
  Eigen::VectorXd direction;  // unit length, in natural sizes; of the lens' parameters
};

LeastKnown leastKnown(const Eigen::MatrixXd& covariance, const LensScale& scale) {
  const Eigen::Index num_lens = scale.size.size() - kNumAffine;
  const Eigen::VectorXd inverse = scale.size.tail(num_lens).cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      inverse.asDiagonal() * covariance.bottomRightCorner(num_lens, num_lens) * inverse.asDiagonal());
  return {.sigma = std::sqrt(std::max(0.0, solver.eigenvalues()(num_lens - 1))),
          .direction = solver.eigenvectors().col(num_lens - 1)};
}

bool foldsInImage(const AnyCamera& camera, ImageSize size) {
  return camera.cone().is_limited_by_fold && !certifyDomain(camera, size).full_image;
}

// One way in which the views may be explained.
struct Solution {
  BundleState state;
  BundleSummary summary;
  WeakPrior held;

  [[nodiscard]] double cornersCost() const { return summary.cost - held.prior.cost(state.params); }
};

// Rays on which the corners in use are seen, as far as the camera explains them.
std::vector<Eigen::Vector3d> explainedRays(const Estimation& e) {
  std::vector<Eigen::Vector3d> rays;
  for (std::size_t v = 0; v < e.observations.size(); ++v) {
    for (std::size_t i = 0; i < e.observations[v].size(); ++i) {
      const Observation& o = e.observations[v][i];
      if (o.weight * e.errors[v][i].squaredNorm() < e.loss.threshold_px * e.loss.threshold_px)
        rays.push_back(e.state.camera_from_board[v] * o.p_board);
    }
  }
  return rays;
}

// The search for a prior, at the corners, weights and loss that the estimation has come to.
class Ladder {
 public:
  explicit Ladder(const Estimation& e)
      : e_(e),
        size_(e.views.front().size),
        variance_(noiseSigma(e) * noiseSigma(e)),
        scale_(lensScale(e.options.model, cameraOf(e.state), explainedRays(e), size_)),
        directions_(freeDirections(static_cast<int>(e.state.params.size()), e.constraint)) {}

  // Is there nothing to be done?
  [[nodiscard]] bool isSound(const Solution& solution) const {
    if (!isSteady(solution)) return false;
    const AnyCamera camera = cameraOf(solution.state);
    return !foldsInImage(camera, size_) && seesAll(camera, solution.state);
  }

  // The widest prior that holds the lens together, or none if it turns out not to be needed; nothing where
  // every prior contradicts the corners. From the model's own start, or else from where the solver went: a
  // lens that bends much is too far from the former for a loss that outliers do not move.
  [[nodiscard]] std::optional<Solution> climb(const Solution& free) const {
    Solution plain{.state = free.state, .summary = {}, .held = {}};
    for (Eigen::Index i = 0; i < scale_.mean.size(); ++i) {
      const bool is_principal_point = i == 2 || i == 3;
      if (!isFixed(i) && !is_principal_point)
        plain.state.params[static_cast<std::size_t>(i)] = scale_.mean(i);
    }
    for (const Solution* start : {static_cast<const Solution*>(&plain), &free}) {
      auto best = climbFrom(*start, free);
      if (!best || 2 * (best->cornersCost() - free.cornersCost()) > kContradiction * variance_) continue;
      describe(free, *best);
      return best;
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] bool seesAll(const AnyCamera& camera, const BundleState& state) const {
    for (std::size_t v = 0; v < e_.observations.size(); ++v) {
      for (const Observation& o : e_.observations[v]) {
        if (!camera.project(state.camera_from_board[v] * o.p_board).ok()) return false;
      }
    }
    return true;
  }

  [[nodiscard]] AnyCamera cameraOf(const BundleState& state) const {
    return AnyCamera::make(e_.options.model, state.params);
  }

  [[nodiscard]] bool isFixed(Eigen::Index i) const {
    const std::vector<int>& held = e_.constraint.held;
    return std::find(held.begin(), held.end(), static_cast<int>(i)) != held.end();
  }

  void solve(Solution& solution, double width) const {
    solution.held = {.width = width, .prior = scale_.prior(width, variance_), .scale = scale_};
    solution.summary =
        solveBundle(e_.options.model, e_.observations, solution.state, optionsWith(solution.held.prior));
  }

  [[nodiscard]] BundleOptions optionsWith(const LensPrior& prior) const {
    return {.loss = e_.loss, .constraint = e_.constraint, .prior = prior, .cancel = e_.options.cancel};
  }

  // At rest, and every combination seen, if need be by the prior's help.
  [[nodiscard]] bool isSteady(const Solution& solution) const {
    if (solution.summary.termination != Termination::kConverged) return false;
    const auto covariance = covarianceOf(solution);
    return covariance && (!solution.held.isNone() || leastKnown(*covariance, scale_).sigma <= kUnseen);
  }

  [[nodiscard]] bool isWithin(const Solution& solution, double limit) const {
    for (Eigen::Index i = 0; i < scale_.size.size(); ++i) {
      if (!isFixed(i) && scale_.distance(solution.state.params, i) > limit) return false;
    }
    return true;
  }

  // Of a size that a lens has, too.
  [[nodiscard]] bool isGood(const Solution& solution) const {
    return isWithin(solution, kBounded) && isSound(solution);
  }

  [[nodiscard]] std::optional<Eigen::MatrixXd> covarianceOf(const Solution& solution) const {
    const Eigen::MatrixXd information =
        intrinsicsInformation(e_.options.model, e_.observations, solution.state, e_.constraint).information;
    if (!solution.held.isNone()) return heldCovariance(information, solution.held, variance_, e_.constraint);
    const auto inverse = inverseOn(information, directions_);
    if (!inverse) return std::nullopt;
    return variance_ * *inverse;
  }

  [[nodiscard]] std::optional<Solution> climbFrom(const Solution& start, const Solution& free) const {
    Solution natural = start;
    solve(natural, kNatural);
    std::optional<Solution> passable;
    if (isGood(natural)) {
      if (isWithin(natural, kAtHome)) return widen(natural, free);
      passable = natural;
    }
    Solution narrower = natural;
    for (const double width : kNarrower) {
      solve(narrower, width);
      if (!isGood(narrower)) continue;
      if (isWithin(narrower, kAtHome)) return narrower;
      if (!passable) passable = narrower;
    }
    return passable;
  }

  // From a good one on to the widest, and to none if that leads to no worse an optimum than without.
  [[nodiscard]] Solution widen(Solution good, const Solution& free) const {
    for (const double width : kWider) {
      Solution wider = good;
      solve(wider, width);
      if (!isWithin(wider, kAtHome) || !isGood(wider)) return good;
      good = std::move(wider);
    }
    Solution released{.state = good.state, .summary = {}, .held = {}};
    released.summary = solveBundle(e_.options.model, e_.observations, released.state, optionsWith({}));
    const bool is_optimum = released.summary.cost <= (1 + kSameCost) * free.summary.cost;
    return is_optimum && isGood(released) ? released : good;
  }

  void describe(const Solution& free, Solution& held) const {
    if (held.held.isNone()) return;
    held.held.free_params = free.state.params;
    const auto covariance = covarianceOf(held);
    if (!covariance) return;
    const Eigen::VectorXd direction = leastKnown(*covariance, scale_).direction;
    for (Eigen::Index i = 0; i < direction.size(); ++i) {
      if (std::abs(direction(i)) >= kDominant)
        held.held.least_known.push_back(static_cast<int>(kNumAffine + i));
    }
  }

  const Estimation& e_;
  ImageSize size_;
  double variance_;
  LensScale scale_;
  Eigen::MatrixXd directions_;
};

}  // namespace

void holdTogether(Estimation& e) {
  if (e.state.params.size() == kAffineParamNames.size()) return;
  const Ladder ladder(e);
  e.weak_prior.is_missing = false;
  if (ladder.isSound({.state = e.state, .summary = e.summary, .held = e.weak_prior})) return;
  if (!e.weak_prior.isNone()) {
    e.weak_prior = {};
    solve(e);
  }
  auto held = ladder.climb({.state = e.state, .summary = e.summary, .held = {}});
  if (!held) {
    e.weak_prior.is_missing = true;
    return;
  }
  e.state = std::move(held->state);
  e.weak_prior = std::move(held->held);
  solve(e);
}

std::optional<Eigen::MatrixXd> heldCovariance(const Eigen::MatrixXd& information, const WeakPrior& held,
                                              double variance, const ParamConstraint& constraint) {
  const Eigen::MatrixXd directions = freeDirections(static_cast<int>(information.rows()), constraint);
  const Eigen::MatrixXd P = held.prior.precision.asDiagonal();
  const auto inverse = inverseOn(information + P, directions);
  if (!inverse) return std::nullopt;
  const double width = std::max(held.width, kNatural);
  const Eigen::VectorXd truth = (width * held.scale.size).cwiseAbs2();
  const Eigen::MatrixXd bias = held.prior.precision.cwiseAbs2().cwiseProduct(truth).asDiagonal();
  return *inverse * (variance * information + bias) * *inverse;
}

std::optional<Eigen::MatrixXd> heldRobustCovariance(const Eigen::MatrixXd& information,
                                                    const Eigen::MatrixXd& robust, const WeakPrior& held,
                                                    double variance, const ParamConstraint& constraint) {
  const auto all = heldCovariance(information, held, variance, constraint);
  const Eigen::MatrixXd directions = freeDirections(static_cast<int>(information.rows()), constraint);
  const auto inverse =
      inverseOn(information + Eigen::MatrixXd(held.prior.precision.asDiagonal()), directions);
  if (!all || !inverse) return std::nullopt;
  // The views' pulls in place of independent corners; the prior's part stays.
  return *all + *inverse * information * robust * information * *inverse -
         variance * *inverse * information * *inverse;
}

}  // namespace alidade
