// SPDX-License-Identifier: MIT
#include "alidade/calibrate/choose/model_solution.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/adjust/noise/larger_model.h"
#include "alidade/adjust/noise/model_soundness.h"
#include "alidade/calibrate/clean/view_fit.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/camera/image_domain.h"
#include "alidade/camera/model_traits.h"
#include "alidade/camera/same_lens.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

// A model considered for the choice. Its verdict and reason are empty until they are known.
struct Candidate : ModelCandidate {
  explicit Candidate(std::string_view model_id)
      : ModelCandidate{.id = std::string(model_id),
                       .num_params = static_cast<int>(parameterNames(model_id).size()),
                       .verdict = {},
                       .reason = {}} {}
  // Marks the model as one that must not be recommended.
  void ruleOut(const Unsoundness& why) {
    verdict = why.id;
    reason = why.text;
    folds = why.folds;
  }

  // The result of fittedPlainly(). Nothing if the model is ruled out or, without a verdict, needs no search
  // of its own.
  std::optional<ModelSolution> solution;
  ParamConstraint constraint;
  std::exception_ptr error;  // why no camera of the model explains the views
  bool folds = false;        // the only reason to rule it out, see Unsoundness

  // Results on the common corners.
  std::vector<double> params;
  std::optional<HoldoutReport> holdout;
  std::optional<HeldOutScore> score;
};

using Candidates = std::vector<Candidate>;

// The options with this model.
CalibratorOptions withModel(std::string_view model_id, CalibratorOptions options) {
  options.model = model_id;
  return options;
}

// Up to the first field angle, perspective lenses with distortion fit every lens, and radtan and rational are
// the models that all programs read. Beyond it, fisheye models are considered if one fits better than radtan;
// beyond the second angle, always.
constexpr double kWideFieldRad = 100 * std::numbers::pi / 180;
constexpr double kVeryWideFieldRad = 110 * std::numbers::pi / 180;
// Share of the cost that a larger model must remove to be a candidate. Three parameters, the fewest that a
// larger model adds, must remove more than this from the RMS.
constexpr double kNeededDrop = 0.02;
static_assert(kNeededDrop < 2 * 3 * kShareOfParameter);

void fit(Candidate& candidate, const PreparedViews& given, const CalibratorOptions& options) {
  CalibratorOptions own = withModel(candidate.id, options);
  own.jobs = 1;
  try {
    candidate.solution = fittedPlainly(given, own);
  } catch (const Error&) {
    candidate.error = std::current_exception();
  }
  if (candidate.solution && candidate.solution->fit.summary.termination != Termination::kFailed) return;
  candidate.solution.reset();
  candidate.ruleOut({.id = "no_solution", .text = "no camera of this model explains the views"});
}

void fitAll(std::span<Candidate> candidates, const PreparedViews& given, const CalibratorOptions& options) {
  parallelFor(
      candidates.size(), options.jobs, [&](std::size_t i) { fit(candidates[i], given, options); },
      options.cancel);
}

int numHeldOfLens(const ParamConstraint& constraint) {
  return static_cast<int>(
      std::ranges::count_if(constraint.held, [](int i) { return i >= static_cast<int>(kNumAffine); }));
}

bool isAllowed(std::string_view id, const CalibratorOptions& options) {
  const auto& models = options.models;
  if (!modelTraits(id).is_candidate) return false;
  if (!models.empty()) return std::ranges::find(models, id) != models.end();
  // The entrance pupil would take up how the real lens deviates from a stiff model.
  return options.num_pupil.value_or(0) == 0 || !modelTraits(id).is_stiff;
}

// Sum of rho over all corners; corners of views that the camera does not explain count as far off.
double costOf(const Fit& fit, HuberLoss loss, const PreparedViews& given) {
  double cost = 0;
  for (const FitView& view : fit.views) {
    cost += noiseFloor(view.errors.size());
    for (const Eigen::Vector2d& error : view.errors) cost += loss.rho(error.squaredNorm());
  }
  for (const std::size_t v : viewsLeftOut(given, fit))
    cost += static_cast<double>(given.views[v].corners.size()) * farOff(loss);
  return cost;
}

// True if the camera of a fit folds inside the image.
bool foldsInsideImage(const Fit& fit) {
  return foldsInsideImage(cameraOf(fit), onlyCamera(fit).size);
}

// Angle between the rays of the midpoints of the image's shorter sides; infinite if these have no ray.
double fieldOf(const Fit& fit) {
  const ImageSize size = onlyCamera(fit).size;
  const AnyCamera camera = cameraOf(fit);
  const double x = size.width - 1;
  const double y = size.height - 1;
  const bool is_upright = size.height > size.width;
  const auto a = camera.unproject(is_upright ? Eigen::Vector2d(0.5 * x, 0) : Eigen::Vector2d(0, 0.5 * y));
  const auto b = camera.unproject(is_upright ? Eigen::Vector2d(0.5 * x, y) : Eigen::Vector2d(x, 0.5 * y));
  if (!a || !b) return std::numeric_limits<double>::infinity();
  const auto fromAxis = [](const Eigen::Vector3d& ray) { return std::atan2(ray.head<2>().norm(), ray.z()); };
  return fromAxis(*a) + fromAxis(*b);
}

// True if a camera sees a corner at 90 degrees or more from its axis, where perspective models have no pixel.
bool seesSideways(const Fit& fit) {
  for (const FitView& view : fit.views) {
    const SE3 pose = cameraFromBoard(fit, view);
    for (const Observation& corner : view.corners) {
      if ((pose * corner.p_board).z() <= 0) return true;
    }
  }
  return false;
}

bool isOpen(const Candidate& c) {
  return c.solution && c.verdict.empty();
}

void requireAny(const Candidates& candidates) {
  if (std::ranges::any_of(candidates, isOpen)) return;
  for (const Candidate& c : candidates) {
    if (c.error) std::rethrow_exception(c.error);
  }
  throw inputError({.where = "calibration",
                    .found = "views that no camera model explains",
                    .expected = "views of one flat board by one camera",
                    .next_step = "check the board's size, and name a model with --model"});
}

// True if a model fits well enough for a larger one to start from it and converge in a few steps.
bool fitsRoughly(const Candidate& candidate, const Candidates& candidates) {
  constexpr double kRoughly = 2;  // times the noise that the best model leaves
  if (!candidate.solution) return false;
  const double threshold = candidate.solution->fit.loss.threshold_px;
  return std::ranges::all_of(candidates, [&](const Candidate& c) {
    return !c.solution || threshold <= kRoughly * c.solution->fit.loss.threshold_px;
  });
}

// A larger model that a glance shows to fit no better than `lean`.
Candidate dismissed(Candidate candidate, std::string_view lean) {
  candidate.verdict = "larger";
  candidate.reason = "fits no better than " + std::string(lean);
  return candidate;
}

// The perspective models besides the lead. Smaller ones are solved from its poses; larger ones are fitted
// only if a few steps show a gain over the model before. A model that folds may be improved on in ways that
// the errors do not show.
void addPerspective(Candidates& candidates, bool is_sideways, const PreparedViews& given,
                    const CalibratorOptions& options) {
  const ModelTraits& lead = leadTraits(LensFamily::kPerspective);
  std::string lean(lead.id);
  for (const ModelTraits& model : allModelTraits()) {
    if (model.family != lead.family || model.id == lead.id || !isAllowed(model.id, options)) continue;
    Candidate candidate(model.id);
    const auto at = std::ranges::find(candidates, lean, &Candidate::id);
    if (lead.extends(model.id)) {
      // A wide view needs no search of its own.
    } else if (is_sideways) {
      candidate.ruleOut(
          {.id = "corners_outside_domain", .text = "some corners lie 90 degrees from the axis or more"});
    } else if (!model.extends(lean) || !isAllowed(lean, options) || !fitsRoughly(*at, candidates) ||
               foldsInsideImage(at->solution->fit) ||
               dropAtAGlance(at->solution->fit, candidate.id, options.cancel) > kNeededDrop) {
      fit(candidate, given, options);
      if (candidate.solution) lean = candidate.id;
    } else {
      candidate = dismissed(std::move(candidate), lean);
    }
    candidates.push_back(std::move(candidate));
  }
}

// The wide models besides the lead, the smallest first. Those that extend it are fitted only if a glance
// shows a gain over it.
Candidates furtherWide(const Candidate& of_lead, const PreparedViews& given,
                       const CalibratorOptions& options) {
  const ModelTraits& lead = leadTraits(LensFamily::kWide);
  const bool is_lead = of_lead.solution && isAllowed(lead.id, options);
  Candidates candidates;
  Candidates not_fitted;
  for (const ModelTraits& model : allModelTraits()) {
    if (model.family != lead.family || model.id == lead.id || !isAllowed(model.id, options)) continue;
    Candidate candidate(model.id);
    if (is_lead && model.extends(lead.id) &&
        !(dropAtAGlance(of_lead.solution->fit, candidate.id, options.cancel) > kNeededDrop)) {
      not_fitted.push_back(dismissed(std::move(candidate), lead.id));
    } else {
      candidates.push_back(std::move(candidate));
    }
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::num_params);
  fitAll(candidates, given, options);
  std::ranges::move(not_fitted, std::back_inserter(candidates));
  return candidates;
}

// The smallest of the fitted models that fits all corners about as well as any. @pre at least one is fitted.
Candidate& fittest(Candidates& candidates, const PreparedViews& given) {
  HuberLoss loss = kNoLoss;
  for (const Candidate& c : candidates) {
    if (isOpen(c)) loss.threshold_px = std::min(loss.threshold_px, c.solution->fit.loss.threshold_px);
  }
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& c : candidates) {
    if (isOpen(c)) least = std::min(least, costOf(c.solution->fit, loss, given));
  }
  const auto found = std::ranges::find_if(candidates, [&](const Candidate& c) {
    return isOpen(c) && costOf(c.solution->fit, loss, given) <= (1 + kNeededDrop) * least;
  });
  expect(found != candidates.end(), "a model that fits");
  return *found;
}

// Fits the models under consideration, by number of parameters.
// @param are_all_lenses  false: fisheye models only for wide lenses, because radtan and rational are what all
//                        programs read
// @throws Error (kInput) if neither a perspective nor a fisheye lens explains the views
Candidates fitCandidates(bool are_all_lenses, const PreparedViews& given, const CalibratorOptions& options,
                         ModelChoice& choice) {
  // The leads of the two families. One of them explains the views of any lens, at least roughly, and shows
  // how wide the lens is. Where radtan would fold, the polynomial in the angle fits better.
  Candidates candidates;
  const std::string_view perspective = leadTraits(LensFamily::kPerspective).id;
  candidates.emplace_back(perspective);
  candidates.emplace_back(leadTraits(LensFamily::kWide).id);
  fitAll(candidates, given, options);
  requireAny(candidates);
  const Candidate& better = fittest(candidates, given);
  const Fit& widest = better.solution->fit;
  choice.field_rad = fieldOf(widest);
  const double limit = better.id == perspective ? kVeryWideFieldRad : kWideFieldRad;
  choice.is_wide = choice.field_rad > limit;
  const bool is_sideways = seesSideways(widest);
  // If radtan is restricted, one of these may replace it.
  const bool is_whole =
      isAllowed(perspective, options) && numHeldOfLens(constraintOf(withModel(perspective, options))) == 0;
  if (choice.is_wide || !is_whole || are_all_lenses) {
    std::ranges::move(furtherWide(candidates.back(), given, options), std::back_inserter(candidates));
  } else if (candidates.front().solution) {
    candidates.pop_back();
  }
  addPerspective(candidates, is_sideways, given, options);
  for (Candidate& candidate : candidates) {
    if (!isAllowed(candidate.id, options))
      candidate.ruleOut({.id = "not_allowed", .text = "not among the models to choose from"});
    candidate.constraint = constraintOf(withModel(candidate.id, options));
    candidate.num_params -= numHeldOfLens(candidate.constraint);
  }
  requireAny(candidates);
  std::ranges::stable_sort(candidates, {}, &Candidate::num_params);
  return candidates;
}

// The reference's corners, weights, loss and boards, with the candidate's camera and, where it has them,
// poses.
Fit onCornersOf(const Fit& reference, const Candidate& candidate, const PreparedViews& given) {
  Fit fit = reference;
  fixShapes(fit);
  FitCamera& camera = onlyCamera(fit);
  camera.constraint = candidate.constraint;
  camera.weak_prior = {};
  if (!candidate.solution) {
    setLens(candidate.id, parametersByName(camera.model, camera.params, candidate.id), camera);
    return fit;
  }
  const Fit& own = candidate.solution->fit;
  camera.model = candidate.id;
  camera.params = onlyCamera(own).params;
  for (const FitView& view : fit.views) {
    const auto at = std::ranges::find(own.views, view.source, &FitView::source);
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
              int jobs, const CancelFlag* cancel) {
  if (!candidate.verdict.empty()) return;
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
    candidate.verdict = "worse";
    candidate.reason = "fits corners worse than " + onlyCamera(reference).model;
    return;
  }
  if (const auto why = unsoundnessOf(fit)) {
    candidate.ruleOut(*why);
  } else if (!onlyCamera(fit).weak_prior.isNone()) {
    // A prior hides undetermined parameters, and a fold where no corner was seen.
    candidate.ruleOut(
        {.id = "ill_conditioned",
         .text = "these views leave its parameters undetermined, and only a weak prior holds it together",
         .folds = true});
  }
  if (!candidate.verdict.empty() && !candidate.folds) return;
  const auto held_out = heldOutErrors(fit, jobs, cancel);
  candidate.holdout = holdoutReport(held_out);
  candidate.holdout_rms_px = candidate.holdout->rms_px;
  if (held_out) {
    candidate.score = scoreOf(*held_out, fit);
  } else {
    candidate.ruleOut(
        {.id = "no_holdout", .text = "some of the views alone leave its parameters undetermined"});
  }
}

// Wide models with many more parameters than the lead also follow other lenses.
bool isLargeWide(const ModelTraits& model) {
  constexpr std::size_t kFewFurther = 2;
  const ModelTraits& lead = leadTraits(LensFamily::kWide);
  return model.family == lead.family &&
         model.parameter_names.size() > lead.parameter_names.size() + kFewFurther;
}

// A large wide model must not stand in for a perspective one that predicts as well, sound or not.
void ruleOutStandIns(Candidates& candidates) {
  for (Candidate& c : candidates) {
    if (!c.score || !isLargeWide(modelTraits(c.id))) continue;
    const auto as_good = std::ranges::find_if(candidates, [&c](const Candidate& other) {
      return other.score && modelTraits(other.id).family == LensFamily::kPerspective &&
             other.score->sum <= c.score->sum;
    });
    if (as_good == candidates.end()) continue;
    c.ruleOut({.id = "worse", .text = "predicts corners no better than " + as_good->id});
    c.score.reset();
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
    const auto num_further = static_cast<std::size_t>(c.num_params - lean.num_params);
    if (!excessOf(*lean.score, *c.score).isWorth(num_further)) continue;
    if (better == nullptr || c.score->sum < better->score->sum) better = &c;
  }
  return better;
}

// The smallest model that no other one beats, preferably without a fold or a prior. If all have one, the
// finding about it says what to do; this would not apply to a model that does not even fit.
const Candidate& smallestAsGoodAs(const Candidate& best, const Candidates& candidates) {
  const auto rank = [](const Candidate& c) {
    return std::tuple(!c.verdict.empty(), c.num_params, c.score->sum);
  };
  const Candidate* smallest = &best;
  for (const Candidate& c : candidates) {
    if (c.score && !betterThan(c, candidates) && rank(c) < rank(*smallest)) smallest = &c;
  }
  return *smallest;
}

// A camera that folds inside the image is rejected. A sound one that predicts about as well is used instead.
const Candidate& soundInstead(const Candidate& chosen, const Candidates& candidates, const IsClose& isClose) {
  if (chosen.verdict != "folds_in_image") return chosen;
  const Candidate* sound = nullptr;
  for (const Candidate& c : candidates) {
    if (!c.score || !c.verdict.empty()) continue;
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
    if (&c == &chosen || !c.score || (!c.verdict.empty() && !c.folds)) continue;
    if (is_wide && modelTraits(c.id).family == LensFamily::kPerspective) continue;
    if (c.score->sum > chosen.score->sum && excessOf(*c.score, *best.score).is_significant) continue;
    rivals.push_back(cameraOf(c.id, c.params));
  }
  return rivals;
}

// Completes the report on a candidate.
void conclude(Candidate& c, const Candidates& candidates, const Candidate* best, const Candidate& chosen) {
  const Candidate* better = c.score ? betterThan(c, candidates) : nullptr;
  if (c.score) {
    const HeldOutExcess excess = excessOf(*c.score, *best->score);
    c.excess = excess.share;
    c.excess_std = excess.std;
  }
  if (&c == &chosen) {
    c.verdict = "chosen";
    c.reason = "";
  } else if (c.verdict.empty() && better != nullptr) {
    c.verdict = "worse";
    c.reason = "predicts corners worse than " + better->id;
  } else if (c.verdict.empty()) {
    c.verdict = "larger";
    c.reason = "predicts no better than " + chosen.id + ", with " +
               (c.num_params > chosen.num_params ? "more" : "as many") + " parameters";
  }
}

// Share of the corners of the views in use that was left out.
double shareLeftOut(const Fit& fit, const PreparedViews& given) {
  std::size_t num_given = 0;
  for (const FitView& view : fit.views) num_given += given.views[view.source].corners.size();
  return 1 - static_cast<double>(numCorners(fit)) / static_cast<double>(num_given);
}

ModelSolution chosenAmong(bool are_all_lenses, const PreparedViews& given, const CalibratorOptions& options) {
  const IsClose isClose = [&](double larger_px, double smaller_px) {
    if (!are_all_lenses) return false;  // one of these is good enough, or all are compared
    const double further_px = std::sqrt(std::max(0.0, larger_px * larger_px - smaller_px * smaller_px));
    return severityOf(further_px, options.tolerance_px) == Severity::kNote;
  };
  ModelChoice choice;
  Candidates candidates = fitCandidates(are_all_lenses, given, options, choice);
  Candidate& reference = fittest(candidates, given);
  reference.solution = withDataSettled(*std::move(reference.solution), given, options);
  choice.reference = reference.id;
  const Fit& reference_fit = reference.solution->fit;
  const auto num_open =
      std::ranges::count_if(candidates, [](const Candidate& c) { return c.verdict.empty(); });
  const int jobs_each = std::max(1, resolveJobs(options.jobs) / std::max(1, static_cast<int>(num_open)));
  parallelFor(
      candidates.size(), options.jobs,
      [&](std::size_t i) {
        evaluate(candidates[i], reference_fit, isClose, given, jobs_each, options.cancel);
      },
      options.cancel);
  ruleOutStandIns(candidates);
  const Candidate* best = bestOf(candidates);
  // If no model is sound, report the findings on the best-fitting one.
  const Candidate* smallest = best != nullptr ? &smallestAsGoodAs(*best, candidates) : &reference;
  const auto settle = [&](const Candidate& chosen) -> Candidate& {
    Candidate& winner = candidates[static_cast<std::size_t>(&chosen - candidates.data())];
    if (&winner == &reference) {
      winner.solution->holdout = winner.holdout;
      return winner;
    }
    const CalibratorOptions own = withModel(winner.id, options);
    if (!winner.solution) winner.solution = fittedPlainly(given, own);
    winner.solution = withDataSettled(*std::move(winner.solution), given, own);
    return winner;
  };
  Candidate* winner = &settle(soundInstead(*smallest, candidates, isClose));
  // With the corners that the reference leaves out, a large model may fold after all.
  while (winner->verdict.empty() && foldsInsideImage(winner->solution->fit)) {
    winner->ruleOut({.id = "folds_in_image", .text = "it folds over inside the image", .folds = true});
    const Candidate& sound = soundInstead(*winner, candidates, isClose);
    if (&sound != winner) winner = &settle(sound);
  }
  std::vector<AnyCamera> rivals;
  if (best != nullptr) {
    choice.best = best->id;
    rivals = rivalsOf(*winner, *best, candidates, choice.is_wide);
  }
  for (Candidate& c : candidates) {
    conclude(c, candidates, best, *winner);
    choice.candidates.push_back(c);
  }
  ModelSolution solution = *std::move(winner->solution);
  solution.rivals = std::move(rivals);
  solution.choice.model = std::move(choice);
  return solution;
}

}  // namespace

ModelSolution chooseModel(const PreparedViews& given, const CalibratorOptions& options) {
  constexpr double kManyOutliers = 0.05;  // may be corners that another lens explains
  // The entrance pupil moves in fisheye lenses.
  if (options.num_pupil.value_or(0) > 0) return chosenAmong(true, given, options);
  ModelSolution chosen = chosenAmong(false, given, options);
  if (!foldsInsideImage(chosen.fit) && shareLeftOut(chosen.fit, given) < kManyOutliers) return chosen;
  return chosenAmong(true, given, options);
}

}  // namespace alidade
