// SPDX-License-Identifier: MIT
#include "alidade/calibrate/choose/choice_candidates.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <utility>

#include "alidade/adjust/noise/larger_model.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

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
  CalibratorOptions own = options;
  own.model = candidate.id;
  own.jobs = 1;
  try {
    candidate.solution = fittedPlainly(given, own);
  } catch (const Error&) {
    candidate.error = std::current_exception();
  }
  if (candidate.solution && candidate.solution->fit.summary.termination != Termination::kFailed) return;
  candidate.solution.reset();
  candidate.unsoundness =
      Unsoundness{.id = "no_solution", .text = "no camera of this model explains the views"};
}

void fitAll(std::span<Candidate> candidates, const PreparedViews& given, const CalibratorOptions& options) {
  parallelFor(
      candidates.size(), options.jobs, [&](std::size_t i) { fit(candidates[i], given, options); },
      options.cancel);
}

std::size_t numHeldOfLens(const ParamConstraint& constraint) {
  return static_cast<std::size_t>(
      std::ranges::count_if(constraint.held, [](int i) { return i >= static_cast<int>(kNumAffine); }));
}

bool isAllowed(std::string_view id, const CalibratorOptions& options) {
  const auto& models = options.models;
  return models.empty() || std::find(models.begin(), models.end(), id) != models.end();
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

AnyCamera cameraOf(const Fit& fit) {
  return AnyCamera::make(onlyCamera(fit).model, onlyCamera(fit).params);
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
  return c.solution && !c.unsoundness;
}

void requireAny(const Candidates& candidates) {
  if (std::any_of(candidates.begin(), candidates.end(), isOpen)) return;
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
  return std::all_of(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return !c.solution || threshold <= kRoughly * c.solution->fit.loss.threshold_px;
  });
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
    const auto at =
        std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) { return c.id == lean; });
    if (lead.extends(model.id)) {
      // A wide view needs no search of its own.
    } else if (is_sideways) {
      candidate.unsoundness = Unsoundness{.id = "corners_outside_domain",
                                          .text = "some corners lie 90 degrees from the axis or more"};
    } else if (!model.extends(lean) || !isAllowed(lean, options) || !fitsRoughly(*at, candidates) ||
               foldsInsideImage(at->solution->fit) ||
               dropAtAGlance(at->solution->fit, candidate.id, options.cancel) > kNeededDrop) {
      fit(candidate, given, options);
      if (candidate.solution) lean = candidate.id;
    } else {
      candidate.not_better_than = lean;
    }
    candidates.push_back(std::move(candidate));
  }
}

// The wide models besides the lead, the smallest first.
Candidates furtherWide(const PreparedViews& given, const CalibratorOptions& options) {
  const ModelTraits& lead = leadTraits(LensFamily::kWide);
  Candidates candidates;
  for (const ModelTraits& model : allModelTraits()) {
    if (model.family == lead.family && model.id != lead.id && isAllowed(model.id, options))
      candidates.emplace_back(model.id);
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::num_params);
  fitAll(candidates, given, options);
  return candidates;
}

}  // namespace

Candidate::Candidate(std::string_view model_id) : id(model_id), num_params(parameterNames(model_id).size()) {}

bool foldsInsideImage(const Fit& fit) {
  return foldsInsideImage(cameraOf(fit), onlyCamera(fit).size);
}

Candidates fitCandidates(Lenses lenses, const PreparedViews& given, const CalibratorOptions& options,
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
  CalibratorOptions lead = options;
  lead.model = perspective;
  // If radtan is restricted, one of these may replace it.
  const bool is_whole = isAllowed(perspective, options) && numHeldOfLens(constraintOf(lead)) == 0;
  if (choice.is_wide || !is_whole || lenses == Lenses::kAll) {
    std::ranges::move(furtherWide(given, options), std::back_inserter(candidates));
  } else if (candidates.front().solution) {
    candidates.pop_back();
  }
  addPerspective(candidates, is_sideways, given, options);
  for (Candidate& candidate : candidates) {
    if (!isAllowed(candidate.id, options))
      candidate.unsoundness = Unsoundness{.id = "not_allowed", .text = "not among the models to choose from"};
    CalibratorOptions own = options;
    own.model = candidate.id;
    candidate.constraint = constraintOf(own);
    candidate.num_params -= numHeldOfLens(candidate.constraint);
  }
  requireAny(candidates);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.num_params < b.num_params; });
  return candidates;
}

Candidate& fittest(Candidates& candidates, const PreparedViews& given) {
  HuberLoss loss = kNoLoss;
  for (const Candidate& c : candidates) {
    if (isOpen(c)) loss.threshold_px = std::min(loss.threshold_px, c.solution->fit.loss.threshold_px);
  }
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& c : candidates) {
    if (isOpen(c)) least = std::min(least, costOf(c.solution->fit, loss, given));
  }
  const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return isOpen(c) && costOf(c.solution->fit, loss, given) <= (1 + kNeededDrop) * least;
  });
  expect(found != candidates.end(), "a model that fits");
  return *found;
}

}  // namespace alidade
