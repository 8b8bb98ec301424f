// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/weak_prior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/model_soundness.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/camera_model.h"
#include "alidade/camera/image_domain.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

// Widths of priors in natural sizes; at 100, the prior is lost in rounding.
constexpr std::array<double, 6> kWidths = {0.03, 0.1, 0.3, 1, 3, 10};
// Lenses are assumed to scatter about the model's start by at least this much, regardless of the prior's
// width.
constexpr double kNatural = 1;
// Standard deviation, in natural sizes, above which a combination of the lens parameters counts as
// undetermined: it moves the corner of the image by a quarter of its diagonal.
constexpr double kUnseen = 0.5;
// Limits of the parameters of a lens under a prior, in natural sizes: the preferred one, because larger
// parameters bring poles close to the image, and the one that must hold.
constexpr std::array<double, 2> kBounds = {0.3, 1};
// A prior contradicts the corners if it raises twice their cost by more variances than this.
constexpr double kContradiction = 25;
constexpr double kDominant = 0.5;  // share of the largest component of the undetermined combination;
                                   // parameters above it are named
constexpr double kSameCost = 1e-9;

// Combinations of the lens parameters in units of LensScale; the last one is determined least.
SymmetricEigen combinations(const Eigen::MatrixXd& covariance, const LensScale& scale) {
  const auto num_lens = static_cast<Eigen::Index>(scale.size.size() - kNumAffine);
  const Eigen::VectorXd inverse =
      Eigen::Map<const Eigen::VectorXd>(scale.size.data() + kNumAffine, num_lens).cwiseInverse();
  return SymmetricEigen(inverse.asDiagonal() * covariance.block(kNumAffine, kNumAffine, num_lens, num_lens) *
                        inverse.asDiagonal());
}

const WeakPrior& priorOf(const Fit& fit) {
  return onlyCamera(fit).weak_prior;
}

bool isFixed(const Fit& fit, std::size_t i) {
  return onlyCamera(fit).constraint.holds(static_cast<int>(i));
}

// The search for a prior, with the corners, weights, loss and board of the present fit.
class Ladder {
 public:
  Ladder(const Fit& fit, const CancelFlag* cancel)
      : variance_(noiseSigma(fit) * noiseSigma(fit)),
        scale_(lensScale(onlyCamera(fit).model, cameraOf(fit), onlyCamera(fit).size)),
        directions_(
            freeDirections(static_cast<int>(onlyCamera(fit).params.size()), onlyCamera(fit).constraint)),
        cancel_(cancel) {}

  // True if no prior is needed.
  [[nodiscard]] bool isSound(const Fit& fit) const {
    if (!isSteady(fit) || largest(fit) > kRunawaySizes) return false;
    const AnyCamera camera = cameraOf(fit);
    return !foldsInsideImage(camera, onlyCamera(fit).size) && numCornersOutside(fit, camera) == 0;
  }

  // The widest prior that keeps the lens sound, or no prior if it turns out to be unnecessary; nothing if
  // every prior contradicts the corners. Starts at the model's own start, otherwise at the solver's result,
  // because a robust loss may not lead from the former to a strongly distorted lens.
  [[nodiscard]] std::optional<Fit> climb(const Fit& free) const {
    auto best = climbFrom(plain(free), free);
    if (!best) best = climbFrom(free, free);
    if (best) describe(free, *best);
    return best;
  }

 private:
  // The model's own start with the same poses.
  [[nodiscard]] Fit plain(const Fit& free) const {
    Fit plain = free;
    for (std::size_t i = 0; i < scale_.mean.size(); ++i) {
      const bool is_principal_point = i == 2 || i == 3;
      if (!isFixed(free, i) && !is_principal_point) onlyCamera(plain).params[i] = scale_.mean[i];
    }
    return plain;
  }

  // True if the fit has converged and determines every combination, if necessary with the prior's help.
  [[nodiscard]] bool isSteady(const Fit& fit) const {
    if (fit.summary.termination != Termination::kConverged) return false;
    const auto covariance = covarianceOf(fit);
    if (!covariance || !priorOf(fit).isNone()) return covariance.has_value();
    const double largest = combinations(*covariance, scale_).eigenvalues().tail<1>()(0);
    return std::sqrt(std::max(0.0, largest)) <= kUnseen;
  }

  // The largest free lens parameter, in natural sizes.
  [[nodiscard]] double largest(const Fit& fit) const {
    double largest = 0;
    for (std::size_t i = 0; i < scale_.size.size(); ++i) {
      if (!isFixed(fit, i)) largest = std::max(largest, scale_.distance(onlyCamera(fit).params, i));
    }
    return largest;
  }

  // True if the fit explains the corners as well as noise allows, with a lens that is sound over the whole
  // image.
  [[nodiscard]] bool isGood(const Fit& fit, const Fit& free) const {
    return 2 * (cornersCost(fit) - cornersCost(free)) <= kContradiction * variance_ && isSound(fit);
  }

  [[nodiscard]] std::optional<Eigen::MatrixXd> covarianceOf(const Fit& fit) const {
    const Eigen::MatrixXd information = intrinsicsInformation(fit).information;
    if (!priorOf(fit).isNone()) return heldCovariance(information, onlyCamera(fit), variance_);
    const auto inverse = inverseAlong(directions_, information).inverse;
    if (!inverse) return std::nullopt;
    return variance_ * *inverse;
  }

  // From narrow to wide, each from the previous solution, which stays in the same valley.
  [[nodiscard]] std::optional<Fit> climbFrom(const Fit& start, const Fit& free) const {
    std::array<std::optional<Fit>, kBounds.size()> widest;
    Fit at = start;
    for (const double width : kWidths) {
      onlyCamera(at).weak_prior = {.width = width, .prior = scale_.prior(width, variance_), .scale = scale_};
      at = solve(std::move(at), {.cancel = cancel_});
      if (!isGood(at, free)) continue;
      for (std::size_t i = 0; i < kBounds.size(); ++i) {
        if (largest(at) <= kBounds[i]) widest[i] = at;
      }
    }
    if (!widest.back()) return std::nullopt;
    Fit released = *widest.back();
    onlyCamera(released).weak_prior = {};
    released = solve(std::move(released), {.cancel = cancel_});
    const bool is_optimum = released.summary.cost <= (1 + kSameCost) * free.summary.cost;
    if (is_optimum && isSound(released)) return released;
    return widest.front() ? widest.front() : widest.back();
  }

  void describe(const Fit& free, Fit& held) const {
    WeakPrior& prior = onlyCamera(held).weak_prior;
    if (prior.isNone()) return;
    prior.free_params = onlyCamera(free).params;
    const auto covariance = covarianceOf(held);
    if (!covariance) return;
    const Eigen::VectorXd direction = combinations(*covariance, scale_).eigenvectors().rightCols<1>();
    const double largest = direction.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < direction.size(); ++i) {
      if (std::abs(direction(i)) >= kDominant * largest)
        prior.least_known.push_back(static_cast<int>(kNumAffine) + static_cast<int>(i));
    }
  }

  double variance_;
  LensScale scale_;
  Eigen::MatrixXd directions_;
  const CancelFlag* cancel_;
};

Eigen::VectorXd vectorOf(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

Fit regularised(Fit fit, const CancelFlag* cancel) {
  FitCamera& camera = onlyCamera(fit);
  const bool is_pupil_given =
      camera.hasPupil() && camera.constraint.holds(static_cast<int>(camera.numLensParams()));
  if (camera.numLensParams() == kNumAffine || is_pupil_given) return fit;
  // The board keeps its shape during the search for the lens.
  const std::vector<FitBoard> boards = fit.boards;
  const Ladder ladder(fit, cancel);
  if (ladder.isSound(fit)) return fit;
  if (camera.hasPupil()) {  // views that do not determine the lens say nothing about its pupil
    camera.params.resize(camera.numLensParams());
    return regularised(solve(std::move(fit), {.cancel = cancel}), cancel);
  }
  fixShapes(fit);
  if (!priorOf(fit).isNone()) {
    onlyCamera(fit).weak_prior = {};
    fit = solve(std::move(fit), {.cancel = cancel});
  }
  if (auto held = ladder.climb(fit)) fit = *std::move(held);
  fit.boards = boards;
  return solve(std::move(fit), {.cancel = cancel});
}

std::optional<Eigen::MatrixXd> heldCovariance(const Eigen::MatrixXd& information, const FitCamera& camera,
                                              double variance, const Eigen::MatrixXd& robust) {
  const WeakPrior& held = camera.weak_prior;
  const Eigen::MatrixXd directions = freeDirections(static_cast<int>(information.rows()), camera.constraint);
  const Eigen::VectorXd natural =
      vectorOf(held.scale.prior(std::max(held.width, kNatural), variance).precision);
  const auto inverse = inverseAlong(directions, information + Eigen::MatrixXd(natural.asDiagonal())).inverse;
  if (!inverse) return std::nullopt;
  const Eigen::VectorXd shift =
      *inverse * (vectorOf(held.prior.precision) - natural)
                     .cwiseProduct(vectorOf(camera.params) - vectorOf(held.prior.mean));
  const Eigen::MatrixXd by_noise = variance * *inverse + shift * shift.transpose();
  if (robust.size() == 0) return by_noise;
  // Replaces independent corners by the views' pulls; the prior's part stays.
  const Eigen::MatrixXd through = *inverse * information;
  return Eigen::MatrixXd(by_noise + through * robust * through.transpose() - variance * through * *inverse);
}

}  // namespace alidade
