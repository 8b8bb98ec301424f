// SPDX-License-Identifier: MIT
#include "alidade/calibrate/weak_prior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "alidade/calibrate/scaled_inverse.h"
#include "alidade/calibrate/view_fit.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

constexpr auto kNumAffine = static_cast<Eigen::Index>(kAffineParamNames.size());
// Widths of priors in natural sizes; at 100, rounding drowns the prior.
constexpr std::array<double, 6> kWidths = {0.03, 0.1, 0.3, 1, 3, 10};
// Lenses are taken to lie about their model's start by no less than this, whatever the prior's width.
constexpr double kNatural = 1;
// One standard deviation from which on a combination of the lens' parameters counts as not seen, in natural
// sizes: it moves the corner of the image by a quarter of its diagonal.
constexpr double kUnseen = 0.5;
// Parameters of a lens that is held together, in natural sizes: what a prior should reach, for larger ones
// bring poles close to the image, and what it must.
constexpr std::array<double, 2> kBounds = {0.3, 1};
// A prior that raises twice the cost of the corners by more variances than this contradicts them.
constexpr double kContradiction = 25;
constexpr double kDominant = 0.5;  // of the largest part in the unseen combination: parameters to be named
constexpr double kSameCost = 1e-9;

// Inverse of a symmetric matrix on what is free, or nothing where that is singular to working precision.
std::optional<Eigen::MatrixXd> inverseOn(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& directions) {
  if (directions.cols() == 0) return Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  const auto inverse = scaledInverse(directions.transpose() * matrix * directions).inverse;
  if (!inverse) return std::nullopt;
  return directions * *inverse * directions.transpose();
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
  return camera.cone().is_limited_by_fold && foldsInsideImage(certifyDomain(camera, size));
}

// One way in which the views may be explained.
struct Solution {
  BundleState state;
  BundleSummary summary;
  WeakPrior held;

  [[nodiscard]] double cornersCost() const { return summary.cost - held.prior.cost(state.params); }
};

// The search for a prior, at the corners, weights and loss that the estimation has come to.
class Ladder {
 public:
  explicit Ladder(const Estimation& e)
      : e_(e),
        size_(e.views.front().size),
        variance_(noiseSigma(e) * noiseSigma(e)),
        scale_(lensScale(e.options.model, cameraOf(e.state), size_)),
        directions_(freeDirections(static_cast<int>(e.state.params.size()), e.constraint)) {}

  // Is there nothing to be done?
  [[nodiscard]] bool isSound(const Solution& solution) const {
    if (!isSteady(solution) || largest(solution) > kRunawaySizes) return false;
    const AnyCamera camera = cameraOf(solution.state);
    return !foldsInImage(camera, size_) && seesAll(camera, solution.state);
  }

  // The widest prior that holds the lens together, or none if it turns out not to be needed; nothing where
  // every prior contradicts the corners. From the model's own start, or else from where the solver went: a
  // lens that bends much is too far from the former for a loss that outliers do not move.
  [[nodiscard]] std::optional<Solution> climb(const Solution& free) const {
    auto best = climbFrom(plain(free), free);
    if (!best) best = climbFrom(free, free);
    if (best) describe(free, *best);
    return best;
  }

 private:
  // The model's own start under the same poses.
  [[nodiscard]] Solution plain(const Solution& free) const {
    Solution plain{.state = free.state, .summary = {}, .held = {}};
    for (Eigen::Index i = 0; i < scale_.mean.size(); ++i) {
      const bool is_principal_point = i == 2 || i == 3;
      if (!isFixed(i) && !is_principal_point)
        plain.state.params[static_cast<std::size_t>(i)] = scale_.mean(i);
    }
    return plain;
  }

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

  // Of the lens' parameters that are free, in natural sizes.
  [[nodiscard]] double largest(const Solution& solution) const {
    double largest = 0;
    for (Eigen::Index i = 0; i < scale_.size.size(); ++i) {
      if (!isFixed(i)) largest = std::max(largest, scale_.distance(solution.state.params, i));
    }
    return largest;
  }

  // Explains the corners no worse than noise allows, by a lens that is one all over the image.
  [[nodiscard]] bool isGood(const Solution& solution, const Solution& free) const {
    return 2 * (solution.cornersCost() - free.cornersCost()) <= kContradiction * variance_ &&
           isSound(solution);
  }

  [[nodiscard]] std::optional<Eigen::MatrixXd> covarianceOf(const Solution& solution) const {
    const Eigen::MatrixXd information =
        intrinsicsInformation(e_.options.model, e_.observations, solution.state, e_.constraint).information;
    if (!solution.held.isNone()) {
      const auto held =
          HeldCovariance::make(information, solution.state.params, solution.held, variance_, e_.constraint);
      if (!held) return std::nullopt;
      return held->byNoise();
    }
    const auto inverse = inverseOn(information, directions_);
    if (!inverse) return std::nullopt;
    return variance_ * *inverse;
  }

  // From narrow to wide, each from the one before, which keeps to the same valley.
  [[nodiscard]] std::optional<Solution> climbFrom(const Solution& start, const Solution& free) const {
    std::array<std::optional<Solution>, kBounds.size()> widest;
    Solution at = start;
    for (const double width : kWidths) {
      solve(at, width);
      if (!isGood(at, free)) continue;
      for (std::size_t i = 0; i < kBounds.size(); ++i) {
        if (largest(at) <= kBounds[i]) widest[i] = at;
      }
    }
    if (!widest.back()) return std::nullopt;
    Solution released{.state = widest.back()->state, .summary = {}, .held = {}};
    released.summary = solveBundle(e_.options.model, e_.observations, released.state, optionsWith({}));
    const bool is_optimum = released.summary.cost <= (1 + kSameCost) * free.summary.cost;
    if (is_optimum && isSound(released)) return released;
    return widest.front() ? widest.front() : widest.back();
  }

  void describe(const Solution& free, Solution& held) const {
    if (held.held.isNone()) return;
    held.held.free_params = free.state.params;
    const auto covariance = covarianceOf(held);
    if (!covariance) return;
    const Eigen::VectorXd direction = leastKnown(*covariance, scale_).direction;
    const double largest = direction.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < direction.size(); ++i) {
      if (std::abs(direction(i)) >= kDominant * largest)
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
  if (ladder.isSound({.state = e.state, .summary = e.summary, .held = e.weak_prior})) return;
  if (!e.weak_prior.isNone()) {
    e.weak_prior = {};
    solve(e);
  }
  auto held = ladder.climb({.state = e.state, .summary = e.summary, .held = {}});
  if (!held) return;
  e.state = std::move(held->state);
  e.weak_prior = std::move(held->held);
  solve(e);
}

std::optional<HeldCovariance> HeldCovariance::make(const Eigen::MatrixXd& information,
                                                   std::span<const double> params, const WeakPrior& held,
                                                   double variance, const ParamConstraint& constraint) {
  const Eigen::MatrixXd directions = freeDirections(static_cast<int>(information.rows()), constraint);
  const LensPrior natural = held.scale.prior(std::max(held.width, kNatural), variance);
  const auto inverse = inverseOn(information + Eigen::MatrixXd(natural.precision.asDiagonal()), directions);
  if (!inverse) return std::nullopt;
  const Eigen::Map<const Eigen::VectorXd> p(params.data(), information.rows());
  HeldCovariance result;
  result.information_ = information;
  result.inverse_ = *inverse;
  result.shift_ = *inverse * (held.prior.precision - natural.precision).cwiseProduct(p - held.prior.mean);
  result.variance_ = variance;
  return result;
}

Eigen::MatrixXd HeldCovariance::byNoise() const {
  return variance_ * inverse_ + shift_ * shift_.transpose();
}

Eigen::MatrixXd HeldCovariance::byViews(const Eigen::MatrixXd& robust) const {
  // The views' pulls in place of independent corners; the prior's part stays.
  const Eigen::MatrixXd through = inverse_ * information_;
  return byNoise() + through * robust * through.transpose() - variance_ * through * inverse_;
}

}  // namespace alidade
