// SPDX-License-Identifier: MIT
#include "support/start_sweep.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
#include "support/fit_set.h"

namespace alidade {
namespace {

constexpr double kNoisePx = 0.1;

double cpuSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

// Solves from the true camera and poses what the calibration found from nothing.
void compareWithTruth(SweepOutcome& outcome) {
  const Fit fit = solve(fitAt(outcome.set, outcome.drawn.camera, outcome.result.fit.loss));
  outcome.cost_from_truth = fit.summary.cost;
  outcome.is_determined =
      fit.summary.termination == Termination::kConverged && intrinsicsInformation(fit).inverse.has_value();
}

}  // namespace

std::vector<SweepCell> sweepCells() {
  std::vector<SweepCell> cells;
  const auto add = [&](std::string_view model, std::initializer_list<double> fovs) {
    for (const double fov : fovs) cells.push_back({.model = std::string(model), .fov_deg = fov});
  };
  for (const char* model : {"pinhole", "radtan", "rational", "thin_prism"})
    add(model, {20, 35, 50, 65, 80, 95, 110});
  add("fov", {20, 45, 70, 95, 120, 150});
  for (const char* model : {"kannala_brandt", "ucm", "omni", "eucm", "double_sphere"})
    add(model, {20, 45, 70, 95, 120, 150, 180, 200});
  return cells;
}

bool SweepOutcome::usesEverything() const {
  return error.empty() && result.dropped.outliers.empty() && result.dropped.views.empty();
}

bool SweepOutcome::isAtOptimum() const {
  constexpr double kRelative = 1e-6;
  return usesEverything() && result.fit.summary.cost <= (1 + kRelative) * cost_from_truth;
}

bool SweepOutcome::isHeld() const {
  return usesEverything() && !onlyCamera(result.fit).weak_prior.isNone();
}

bool SweepOutcome::isWarned() const {
  return !error.empty() || std::any_of(result.diagnoses.begin(), result.diagnoses.end(),
                                       [](const Diagnosis& f) { return f.id != "few_views"; });
}

SweepOutcome runSweepSet(const SweepCell& cell, std::uint64_t number) {
  std::uint64_t seed = streamSeed(number, static_cast<std::uint64_t>(cell.fov_deg));
  for (const char c : cell.model) seed = streamSeed(seed, static_cast<std::uint64_t>(c));
  Random random(seed);
  const DrawnCamera drawn = drawCamera(cell.model, cell.fov_deg, random);
  const int num_views = 8 + static_cast<int>(random.index(33));
  UserSet set = drawUserViews(drawn, num_views, kNoisePx, random);
  SweepOutcome outcome{.drawn = drawn, .set = std::move(set), .result = {}, .error = {}};
  const double before = cpuSeconds();
  try {
    outcome.result = calibrate(outcome.set.board, outcome.set.views, {.model = cell.model});
  } catch (const Error& e) {
    outcome.error = e.what();
  }
  outcome.seconds = cpuSeconds() - before;
  if (outcome.error.empty()) compareWithTruth(outcome);
  return outcome;
}

}  // namespace alidade
