// SPDX-License-Identifier: MIT
#include "alidade/calibrate/choice_candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <utility>

#include "alidade/calibrate/estimation_steps.h"
#include "alidade/calibrate/larger_model.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"

namespace alidade {
namespace {

// Up to the first field across, perspective lenses with distortion follow every other lens, and radtan and
// rational are what all programs read. Beyond, fisheye models are considered where one fits better than
// radtan; beyond the second always.
constexpr double kWideFieldRad = 100 * std::numbers::pi / 180;
constexpr double kVeryWideFieldRad = 110 * std::numbers::pi / 180;
// What a larger model must take off the cost to come into question. Less than what three parameters, the
// fewest that one has, must take off the RMS.
constexpr double kNeededDrop = 0.02;
static_assert(kNeededDrop < 2 * 3 * kShareOfParameter);

void fit(Candidate& candidate, const Checkerboard& board, const std::vector<View>& views,
         const CalibratorOptions& options) {
  CalibratorOptions own = options;
  own.model = candidate.id;
  own.jobs = 1;
  auto fit = std::make_unique<ModelFit>(board, views, std::move(own));
  try {
    fitPlainly(fit->estimation);
  } catch (const Error&) {
    candidate.error = std::current_exception();
  }
  const bool is_fitted = !candidate.error && fit->estimation.summary.termination != Termination::kFailed;
  if (is_fitted) {
    candidate.fit = std::move(fit);
  } else {
    candidate.unsoundness =
        Unsoundness{.id = "no_solution", .text = "no camera of this model explains the views"};
  }
}

void fitAll(std::span<Candidate> candidates, const Checkerboard& board, const std::vector<View>& views,
            const CalibratorOptions& options) {
  parallelFor(
      candidates.size(), options.jobs, [&](std::size_t i) { fit(candidates[i], board, views, options); },
      options.cancel);
}

// Sum of rho over all corners; those of views that the camera does not explain count as far off.
double costOf(const Estimation& e, HuberLoss loss) {
  double cost = 0;
  for (const auto& view : e.errors) {
    cost += noiseFloor(view.size());
    for (const Eigen::Vector2d& error : view) cost += loss.rho(error.squaredNorm());
  }
  for (const View& view : e.misfits) cost += static_cast<double>(view.corners.size()) * farOff(loss);
  return cost;
}

// Between the middles of the image's shorter sides; infinite where these have no ray.
double fieldOf(const Estimation& e) {
  const ImageSize size = e.views.front().size;
  const AnyCamera camera = AnyCamera::make(e.options.model, e.state.params);
  const double x = size.width - 1;
  const double y = size.height - 1;
  const bool is_upright = size.height > size.width;
  const auto a = camera.unproject(is_upright ? Eigen::Vector2d(0.5 * x, 0) : Eigen::Vector2d(0, 0.5 * y));
  const auto b = camera.unproject(is_upright ? Eigen::Vector2d(0.5 * x, y) : Eigen::Vector2d(x, 0.5 * y));
  if (!a || !b) return std::numeric_limits<double>::infinity();
  const auto fromAxis = [](const Eigen::Vector3d& ray) { return std::atan2(ray.head<2>().norm(), ray.z()); };
  return fromAxis(*a) + fromAxis(*b);
}

// Does a camera see any corner that no plane in front of it has?
bool seesSideways(const Estimation& e) {
  for (std::size_t v = 0; v < e.views.size(); ++v) {
    for (const Observation& o : e.observations[v]) {
      if ((e.state.camera_from_board[v] * o.p_board).z() <= 0) return true;
    }
  }
  return false;
}

void requireAny(const Candidates& candidates) {
  if (std::any_of(candidates.begin(), candidates.end(), [](const Candidate& c) { return c.fit != nullptr; }))
    return;
  for (const Candidate& c : candidates) {
    if (c.error) std::rethrow_exception(c.error);
  }
  throw inputError({.where = "calibration",
                    .found = "views that no camera model explains",
                    .expected = "views of one flat board by one camera",
                    .next_step = "check the board's size, and name a model with --model"});
}

// Is a model on the right way, so that a few steps of a larger one start from something?
bool fitsRoughly(const Candidate& candidate, const Candidates& candidates) {
  constexpr double kRoughly = 2;  // times the noise that the best one leaves
  if (!candidate.fit) return false;
  const double threshold = candidate.fit->estimation.loss.threshold_px;
  return std::all_of(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return !c.fit || threshold <= kRoughly * c.fit->estimation.loss.threshold_px;
  });
}

bool foldsInsideImage(const Candidate& candidate) {
  const Estimation& e = candidate.fit->estimation;
  return foldsInsideImage(certifyDomain(AnyCamera::make(candidate.id, e.state.params), e.views.front().size));
}

// The models that contain radtan, each after a glance at what it gains over the one before it. One that folds
// leaves something to gain that the errors do not show.
void addLargerThanRadtan(Candidates& candidates, const Checkerboard& board, const std::vector<View>& views,
                         const CalibratorOptions& options) {
  std::string lean(Radtan::kId);
  for (const std::string_view id : {Rational::kId, ThinPrism::kId}) {
    const auto at =
        std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) { return c.id == lean; });
    Candidate larger(id);
    if (!fitsRoughly(*at, candidates) || foldsInsideImage(*at) ||
        dropAtAGlance(at->fit->estimation, larger.id) > kNeededDrop) {
      fit(larger, board, views, options);
      if (larger.fit) lean = larger.id;
    } else {
      larger.not_better_than = lean;
    }
    candidates.push_back(std::move(larger));
  }
}

}  // namespace

Candidate::Candidate(std::string_view model_id) : id(model_id), num_params(parameterNames(model_id).size()) {}

Candidates fitCandidates(const Checkerboard& board, const std::vector<View>& views,
                         const CalibratorOptions& options, ModelChoice& choice) {
  // Two lenses that stand for all: one of them explains the views of any, at least roughly, and tells how
  // wide it is. Where radtan would have to fold, the polynomial in the angle fits better.
  Candidates candidates;
  candidates.emplace_back(Radtan::kId);
  candidates.emplace_back(KannalaBrandt::kId);
  fitAll(candidates, board, views, options);
  requireAny(candidates);
  const Candidate& better = fittest(candidates);
  const Estimation& widest = better.fit->estimation;
  choice.field_rad = fieldOf(widest);
  const double limit = better.id == Radtan::kId ? kVeryWideFieldRad : kWideFieldRad;
  choice.is_wide = choice.field_rad > limit;
  const bool is_sideways = seesSideways(widest);
  if (choice.is_wide) {
    Candidates fisheyes;
    for (const std::string_view id : {Fov::kId, Ucm::kId, Eucm::kId, DoubleSphere::kId, Omni::kId})
      fisheyes.emplace_back(id);
    fitAll(fisheyes, board, views, options);
    std::move(fisheyes.begin(), fisheyes.end(), std::back_inserter(candidates));
  } else if (candidates.front().fit) {
    candidates.pop_back();
  }
  candidates.emplace_back(Pinhole::kId);
  if (is_sideways) {
    for (const std::string_view id : {Rational::kId, ThinPrism::kId}) {
      candidates.emplace_back(id).unsoundness = Unsoundness{
          .id = "corners_outside_domain", .text = "some corners lie 90 degrees from the axis or more"};
    }
  } else {
    addLargerThanRadtan(candidates, board, views, options);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.num_params < b.num_params; });
  return candidates;
}

Candidate& fittest(Candidates& candidates) {
  HuberLoss loss = kNoLoss;
  for (const Candidate& c : candidates) {
    if (c.fit) loss.threshold_px = std::min(loss.threshold_px, c.fit->estimation.loss.threshold_px);
  }
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& c : candidates) {
    if (c.fit) least = std::min(least, costOf(c.fit->estimation, loss));
  }
  const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
    return c.fit && costOf(c.fit->estimation, loss) <= (1 + kNeededDrop) * least;
  });
  expect(found != candidates.end(), "a model that fits");
  return *found;
}

}  // namespace alidade
