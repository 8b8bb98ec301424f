// SPDX-License-Identifier: MIT
#include "alidade/calibrate/model_choice.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "alidade/calibrate/choice_candidates.h"
#include "alidade/calibrate/cross_validation.h"
#include "alidade/calibrate/estimation_steps.h"
#include "alidade/calibrate/view_fit.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

// The candidate's own camera and poses for the views of the reference.
BundleState stateOn(const Estimation& reference, const Estimation& own) {
  BundleState state{.params = own.state.params, .camera_from_board = {}};
  for (std::size_t v = 0; v < reference.views.size(); ++v) {
    const View& view = reference.views[v];
    const auto at = std::find_if(own.views.begin(), own.views.end(),
                                 [&](const View& other) { return other.image == view.image; });
    if (at != own.views.end()) {
      state.camera_from_board.push_back(
          own.state.camera_from_board[static_cast<std::size_t>(at - own.views.begin())]);
      continue;
    }
    const auto alone = fitAlone(own, view);
    state.camera_from_board.push_back(alone ? alone->camera_from_board
                                            : reference.state.camera_from_board[v]);
  }
  return state;
}

BundleState startOn(const Estimation& reference, const Candidate& candidate) {
  if (candidate.id == reference.options.model) return reference.state;
  if (candidate.fit) return stateOn(reference, candidate.fit->estimation);
  return {.params = parametersByName(reference.options.model, reference.state.params, candidate.id),
          .camera_from_board = reference.state.camera_from_board};
}

// Solves and cross-validates a candidate on the reference's corners, with its weights and loss.
void evaluate(Candidate& candidate, const Estimation& reference) {
  if (candidate.unsoundness || !candidate.not_better_than.empty()) return;
  // A prior hides what the views leave open, and a fold where no corner was seen.
  const bool is_reference = candidate.id == reference.options.model;
  const bool is_held = is_reference && !reference.weak_prior.isNone();
  const BundleOptions options = {.loss = reference.loss,
                                 .max_iterations = 100,
                                 .function_tolerance = 1e-8,
                                 .constraint = reference.constraint,
                                 .prior = is_held ? reference.weak_prior.prior : LensPrior{},
                                 .cancel = reference.options.cancel};
  BundleState state = startOn(reference, candidate);
  const BundleSummary summary =
      is_reference ? reference.summary : solveBundle(candidate.id, reference.observations, state, options);
  candidate.params = state.params;
  candidate.rms_px = weightedRms(candidate.id, reference.observations, state);
  candidate.unsoundness = unsoundnessOf(candidate.id, reference.views.front().size, reference.observations,
                                        state, summary, reference.constraint);
  if (!candidate.unsoundness && is_held) {
    candidate.unsoundness = Unsoundness{.id = "ill_conditioned",
                                        .text =
                                            "these views leave its parameters undetermined, and only a "
                                            "weak prior holds it together",
                                        .folds = true};
  }
  if (candidate.unsoundness && !candidate.unsoundness->folds) return;
  const auto held_out =
      heldOutErrors(candidate.id, reference.board.square_m, reference.observations, state, options);
  candidate.holdout_rms_px = holdoutReport(held_out).rms_px;
  if (held_out) {
    candidate.score = scoreOf(*held_out, reference.observations, reference.loss);
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

// The model that predicts corners so much better that its further parameters are worth it; the one that does
// so by most.
const Candidate* betterThan(const Candidate& lean, const Candidates& candidates) {
  const Candidate* better = nullptr;
  for (const Candidate& c : candidates) {
    if (!c.score || c.num_params < lean.num_params) continue;
    if (!excessOf(*lean.score, *c.score).isWorth(c.num_params - lean.num_params)) continue;
    if (better == nullptr || c.score->sum < better->score->sum) better = &c;
  }
  return better;
}

// The smallest model that is worse than none, better one that does not fold or needs a prior. Where all do,
// the finding on that says what to do; a model that does not even fit would not.
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

bool isPerspective(std::string_view id) {
  return id == Pinhole::kId || id == Radtan::kId || id == Rational::kId || id == ThinPrism::kId;
}

// Models that predict corners no worse than the best one beyond chance, or no worse than the chosen one. One
// that folds in the image is not the lens there, and up to the fold it shows what else the corners allow. In
// a wide field models of the plane z = 1 have nothing to say: their coefficients are set by the corners far
// out, where that plane is stretched without bounds, and beyond them they go anywhere.
std::vector<RivalCamera> rivalsOf(const Candidate& chosen, const Candidate& best,
                                  const Candidates& candidates, bool is_wide) {
  std::vector<RivalCamera> rivals;
  for (const Candidate& c : candidates) {
    if (&c == &chosen || !c.score || (c.unsoundness && !c.unsoundness->folds)) continue;
    if (is_wide && isPerspective(c.id)) continue;
    if (c.score->sum > chosen.score->sum && excessOf(*c.score, *best.score).is_significant) continue;
    rivals.push_back({.id = c.id, .params = c.params});
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

}  // namespace

ChosenModel chooseModel(const Checkerboard& board, const std::vector<View>& views,
                        const CalibratorOptions& options) {
  ModelChoice choice;
  Candidates candidates = fitCandidates(board, views, options, choice);
  Candidate& reference = fittest(candidates);
  settleData(reference.fit->estimation);
  choice.reference = reference.id;
  parallelFor(
      candidates.size(), options.jobs,
      [&](std::size_t i) { evaluate(candidates[i], reference.fit->estimation); }, options.cancel);
  const Candidate* best = bestOf(candidates);
  // Where no model is sound, the findings on the one that fits say why.
  const Candidate& chosen = best != nullptr ? smallestAsGoodAs(*best, candidates) : reference;
  std::vector<RivalCamera> rivals;
  if (best != nullptr) {
    choice.best = best->id;
    rivals = rivalsOf(chosen, *best, candidates, choice.is_wide);
  }
  for (const Candidate& c : candidates) choice.candidates.push_back(report(c, candidates, best, chosen));
  Candidate& winner = candidates[static_cast<std::size_t>(&chosen - candidates.data())];
  if (!winner.fit) {
    CalibratorOptions own = options;
    own.model = winner.id;
    winner.fit = std::make_unique<ModelFit>(board, views, std::move(own));
    fitPlainly(winner.fit->estimation);
  }
  if (&winner != &reference) settleData(winner.fit->estimation);
  return {.fit = std::move(winner.fit),
          .choice = std::move(choice),
          .params = std::move(winner.params),
          .rivals = std::move(rivals)};
}

}  // namespace alidade
