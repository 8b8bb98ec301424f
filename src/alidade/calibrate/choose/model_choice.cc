// SPDX-License-Identifier: MIT
#include "alidade/calibrate/choose/model_choice.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tuple>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/calibrate/choose/choice_candidates.h"
#include "alidade/calibrate/clean/view_fit.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

// The reference's corners, weights, loss and boards, with the candidate's camera and, where it has them,
// poses.
Fit onCornersOf(const Fit& reference, const Candidate& candidate, const PreparedViews& given) {
  Fit fit = reference;
  fixShapes(fit);
  FitCamera& camera = onlyCamera(fit);
  camera.model = candidate.id;
  camera.constraint = candidate.constraint;
  camera.weak_prior = {};
  if (!candidate.solution) {
    camera.params = parametersByName(onlyCamera(reference).model, camera.params, candidate.id);
    return fit;
  }
  const Fit& own = candidate.solution->fit;
  camera.params = onlyCamera(own).params;
  for (const FitView& view : fit.views) {
    const auto at = std::find_if(own.views.begin(), own.views.end(),
                                 [&](const FitView& other) { return other.source == view.source; });
    if (at != own.views.end()) {
      setCameraFromBoard(fit, view, cameraFromBoard(own, *at));
    } else if (const auto alone = fitAlone(own, given.views[view.source])) {
      setCameraFromBoard(fit, view, alone->camera_from_board);
    }
  }
  return fit;
}

// True if the difference between two errors is too small for a warning.
using IsClose = std::function<bool(double larger_px, double smaller_px)>;

// Solves and cross-validates a candidate on the reference's corners, with its weights and loss.
void evaluate(Candidate& candidate, const Fit& reference, const IsClose& isClose, const PreparedViews& given,
              const CancelFlag* cancel) {
  if (candidate.unsoundness || !candidate.not_better_than.empty()) return;
  const bool is_reference = candidate.id == onlyCamera(reference).model;
  const Fit fit = is_reference ? reference
                               : solve(onCornersOf(reference, candidate, given),
                                       {.max_iterations = 100, .function_tolerance = 1e-8, .cancel = cancel});
  candidate.params = onlyCamera(fit).params;
  candidate.rms_px = weightedRms(fit);
  // Held-out errors are larger than those of the fit: cross-validation cannot make up for this.
  constexpr double kHopeless = 2;
  const double reference_px = weightedRms(reference);
  if (candidate.rms_px > kHopeless * reference_px && !isClose(candidate.rms_px, reference_px)) {
    candidate.fits_worse_than = onlyCamera(reference).model;
    return;
  }
  candidate.unsoundness = unsoundnessOf(fit);
  // A prior hides undetermined parameters, and a fold where no corner was seen.
  if (!candidate.unsoundness && !onlyCamera(fit).weak_prior.isNone()) {
    candidate.unsoundness = Unsoundness{
        .id = "ill_conditioned",
        .text = "these views leave its parameters undetermined, and only a weak prior holds it together",
        .folds = true};
  }
  if (candidate.unsoundness && !candidate.unsoundness->folds) return;
  const auto held_out = heldOutErrors(fit, cancel);
  candidate.holdout_rms_px = holdoutReport(held_out).rms_px;
  if (held_out) {
    candidate.score = scoreOf(*held_out, fit);
  } else {
    candidate.unsoundness =
        Unsoundness{.id = "no_holdout", .text = "some of the views alone leave its parameters undetermined"};
  }
}

const Candidate* bestOf(const Candidates& candidates) {
  const Candidate* best = nullptr;
  for (const Candidate& c : candidates) {
    if (c.score && (best == nullptr || c.score->sum < best->score->sum)) best = &c;
  }
  return best;
}

// The model with the lowest held-out error among those that predict corners so much better that their further
// parameters are worthwhile.
const Candidate* betterThan(const Candidate& lean, const Candidates& candidates) {
  const Candidate* better = nullptr;
  for (const Candidate& c : candidates) {
    if (!c.score || c.num_params < lean.num_params) continue;
    if (!excessOf(*lean.score, *c.score).isWorth(c.num_params - lean.num_params)) continue;
    if (better == nullptr || c.score->sum < better->score->sum) better = &c;
  }
  return better;
}

// The smallest model that no other one beats, preferably without a fold or a prior. If all have one, the
// finding about it says what to do; this would not apply to a model that does not even fit.
const Candidate& smallestAsGoodAs(const Candidate& best, const Candidates& candidates) {
  const auto rank = [](const Candidate& c) {
    return std::tuple(c.unsoundness.has_value(), c.num_params, c.score->sum);
  };
  const Candidate* smallest = &best;
  for (const Candidate& c : candidates) {
    if (c.score && !betterThan(c, candidates) && rank(c) < rank(*smallest)) smallest = &c;
  }
  return *smallest;
}

bool foldsInside(const Candidate& c) {
  return c.unsoundness && c.unsoundness->id == "folds_in_image";
}

// A camera that folds inside the image is rejected. A sound one that predicts about as well is used instead.
const Candidate& soundInstead(const Candidate& chosen, const Candidates& candidates, const IsClose& isClose) {
  if (!foldsInside(chosen)) return chosen;
  const Candidate* sound = nullptr;
  for (const Candidate& c : candidates) {
    if (!c.score || c.unsoundness) continue;
    if (!isClose(c.holdout_rms_px, chosen.holdout_rms_px)) continue;
    if (sound == nullptr || c.score->sum < sound->score->sum) sound = &c;
  }
  return sound != nullptr ? *sound : chosen;
}

// Models that predict corners no worse than the best one, apart from chance, or no worse than the chosen one.
// A model that folds in the image is wrong at the fold, but inside it still shows what the corners allow. In
// a wide field, models of the plane z = 1 are excluded: corners far out, where that plane is stretched
// without bounds, determine their coefficients, and beyond those corners they are arbitrary.
std::vector<AnyCamera> rivalsOf(const Candidate& chosen, const Candidate& best, const Candidates& candidates,
                                bool is_wide) {
  std::vector<AnyCamera> rivals;
  for (const Candidate& c : candidates) {
    if (&c == &chosen || !c.score || (c.unsoundness && !c.unsoundness->folds)) continue;
    if (is_wide && modelTraits(c.id).family == LensFamily::kPerspective) continue;
    if (c.score->sum > chosen.score->sum && excessOf(*c.score, *best.score).is_significant) continue;
    rivals.push_back(AnyCamera::make(c.id, c.params));
  }
  return rivals;
}

ModelCandidate report(const Candidate& c, const Candidates& candidates, const Candidate* best,
                      const Candidate& chosen) {
  ModelCandidate entry{.id = c.id, .num_params = static_cast<int>(c.num_params), .verdict = {}, .reason = {}};
  entry.rms_px = c.rms_px;
  entry.holdout_rms_px = c.holdout_rms_px;
  const Candidate* better = c.score ? betterThan(c, candidates) : nullptr;
  if (c.score) {
    const HeldOutExcess excess = excessOf(*c.score, *best->score);
    entry.excess = excess.share;
    entry.excess_std = excess.std;
  }
  if (&c == &chosen) {
    entry.verdict = "chosen";
  } else if (c.unsoundness) {
    entry.verdict = c.unsoundness->id;
    entry.reason = c.unsoundness->text;
  } else if (!c.fits_worse_than.empty()) {
    entry.verdict = "worse";
    entry.reason = "fits corners worse than " + c.fits_worse_than;
  } else if (!c.not_better_than.empty()) {
    entry.verdict = "larger";
    entry.reason = "fits no better than " + c.not_better_than;
  } else if (better != nullptr) {
    entry.verdict = "worse";
    entry.reason = "predicts corners worse than " + better->id;
  } else {
    entry.verdict = "larger";
    entry.reason = "predicts no better than " + chosen.id + ", with " +
                   (c.num_params > chosen.num_params ? "more" : "as many") + " parameters";
  }
  return entry;
}

// Share of the corners of the views in use that was left out.
double shareLeftOut(const Fit& fit, const PreparedViews& given) {
  std::size_t num_given = 0;
  for (const FitView& view : fit.views) num_given += given.views[view.source].corners.size();
  return 1 - static_cast<double>(numCorners(fit)) / static_cast<double>(num_given);
}

ModelSolution chosenAmong(Lenses lenses, const PreparedViews& given, const CalibratorOptions& options) {
  const IsClose isClose = [&](double larger_px, double smaller_px) {
    if (lenses == Lenses::kByField) return false;  // one of these is good enough, or all are compared
    const double further_px = std::sqrt(std::max(0.0, larger_px * larger_px - smaller_px * smaller_px));
    return severityOf(further_px, options.tolerance_px) == Severity::kNote;
  };
  ModelChoice choice;
  Candidates candidates = fitCandidates(lenses, given, options, choice);
  Candidate& reference = fittest(candidates, given);
  reference.solution = withDataSettled(*std::move(reference.solution), given, options);
  choice.reference = reference.id;
  const Fit& reference_fit = reference.solution->fit;
  parallelFor(
      candidates.size(), options.jobs,
      [&](std::size_t i) { evaluate(candidates[i], reference_fit, isClose, given, options.cancel); },
      options.cancel);
  const Candidate* best = bestOf(candidates);
  // If no model is sound, report the findings on the best-fitting one.
  const Candidate* smallest = best != nullptr ? &smallestAsGoodAs(*best, candidates) : &reference;
  smallest = &soundInstead(*smallest, candidates, isClose);
  const Candidate& chosen = *smallest;
  std::vector<AnyCamera> rivals;
  if (best != nullptr) {
    choice.best = best->id;
    rivals = rivalsOf(chosen, *best, candidates, choice.is_wide);
  }
  for (const Candidate& c : candidates) choice.candidates.push_back(report(c, candidates, best, chosen));
  Candidate& winner = candidates[static_cast<std::size_t>(&chosen - candidates.data())];
  if (&winner != &reference) {
    CalibratorOptions own = options;
    own.model = winner.id;
    if (!winner.solution) winner.solution = fittedPlainly(given, own);
    winner.solution = withDataSettled(*std::move(winner.solution), given, own);
  }
  ModelSolution solution = *std::move(winner.solution);
  solution.rivals = std::move(rivals);
  solution.choice.model = std::move(choice);
  return solution;
}

}  // namespace

ModelSolution chooseModel(const PreparedViews& given, const CalibratorOptions& options) {
  constexpr double kManyOutliers = 0.05;  // may be corners that another lens explains
  ModelSolution chosen = chosenAmong(Lenses::kByField, given, options);
  if (!foldsInsideImage(chosen.fit) && shareLeftOut(chosen.fit, given) < kManyOutliers) return chosen;
  return chosenAmong(Lenses::kAll, given, options);
}

}  // namespace alidade
