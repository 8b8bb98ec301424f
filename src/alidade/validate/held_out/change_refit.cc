// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/change_refit.h"

#include <cmath>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/statistics.h"
#include "alidade/validate/held_out/held_views.h"
#include "alidade/validate/held_out/misfit.h"

namespace alidade {
namespace {

constexpr int kMostSteps = 50;
constexpr int kMostHalvings = 10;
constexpr double kRestSigmas = 0.01;  // a step so short changes no figure that is printed

// A camera on the way, with the views posed for it.
struct Stop {
  AnyCamera camera;
  PosedViews posed;
  Misfit misfit;
};

std::optional<Stop> stopAt(const AnyCamera& tested, CameraChange change, double amount,
                           const PosedViews& near, const PosedViews* freed) {
  auto camera = changed(tested, change, amount);
  if (!camera) return std::nullopt;
  auto posed = reposed(*camera, near, freed);
  if (!posed) return std::nullopt;
  const Misfit misfit = misfitOf(*posed);
  return Stop{*std::move(camera), *std::move(posed), misfit};
}

}  // namespace

std::optional<ChangeRefit> refitChange(const AnyCamera& tested, CameraChange change,
                                       const ChangeEvidence& evidence) {
  expect(evidence.held != nullptr, "views to refit");
  const Eigen::VectorXd direction = directionOf(change, tested);
  if (direction.size() == 0) return std::nullopt;
  auto now = stopAt(tested, change, 0, *evidence.held, evidence.freed);
  double amount = 0;
  for (int step = 0; now && step < kMostSteps; ++step) {
    const auto scores = HeldScores::make(now->camera, now->posed, evidence.freed, evidence.noise_variance,
                                         evidence.covariance);
    auto estimate = scores ? scores->along(direction) : std::nullopt;
    if (!estimate) return std::nullopt;
    if (std::abs(estimate->amount) <= kRestSigmas * estimate->std) {
      estimate->amount = amount;
      estimate->sigmas = normalOfStudentT(std::abs(amount) / estimate->std, estimate->freedom);
      return ChangeRefit{now->camera, *estimate, now->misfit.rms_px};
    }
    std::optional<Stop> next;
    double length = estimate->amount;
    for (int halving = 0; halving < kMostHalvings; ++halving, length *= 0.5) {
      next = stopAt(tested, change, amount + length, now->posed, evidence.freed);
      if (next && next->misfit.weighted_squares < now->misfit.weighted_squares) break;
      next.reset();
    }
    amount += length;
    now = std::move(next);
  }
  return std::nullopt;
}

}  // namespace alidade
