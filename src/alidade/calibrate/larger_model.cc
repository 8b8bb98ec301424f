// SPDX-License-Identifier: MIT
#include "alidade/calibrate/larger_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "alidade/calibrate/cross_validation.h"
#include "alidade/calibrate/model_comparison.h"
#include "alidade/calibrate/model_soundness.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

// The model that contains `model` and comes next after it in size, or nothing.
template <CameraModel... Models>
std::optional<std::string> nextLargerModel(ModelList<Models...>, std::string_view model) {
  const std::array<std::string_view, sizeof...(Models)> ids = {Models::kId...};
  const auto here = std::find(ids.begin(), ids.end(), model);
  if (here == ids.end() || here + 1 == ids.end()) return std::nullopt;
  return std::string(*(here + 1));
}

BundleSummary solveLarger(const Estimation& e, const std::string& id, BundleState& larger,
                          int max_iterations) {
  constexpr double kFunctionTolerance = 1e-8;  // of the cost: far below a gain that counts
  return solveBundle(id, e.observations, larger,
                     {.loss = e.loss,
                      .max_iterations = max_iterations,
                      .function_tolerance = kFunctionTolerance,
                      .constraint = e.constraint,
                      .cancel = e.options.cancel});
}

// A prior's share is no error that a larger model could explain.
double cornersCost(const Estimation& e) {
  return e.summary.cost - e.weak_prior.prior.cost(e.state.params);
}

// Is the gain real? F test of the further parameters: the drop of the sum of squares for each of them over
// the variance that the larger model leaves; 1 on average if they are not needed. A lens without distortion
// is a strong claim, and that decides it. Among distortions nobody's lens follows any formula to the last
// digit, and with corners enough that shows: there the gain must be worth the trouble as well.
bool isGain(const Estimation& e, double larger_cost, std::size_t num_larger_params) {
  constexpr double kNeededF = 10;           // chance alone exceeds this once in a billion times
  constexpr double kWorthwhileShare = 0.1;  // of the sum of squares: 5 % of the RMS
  const bool has_distortion = e.state.params.size() > kAffineParamNames.size();
  const double needed_share = has_distortion ? kWorthwhileShare : 0.0;
  std::size_t num_corners = 0;
  for (const auto& view : e.observations) num_corners += view.size();
  const auto extra = static_cast<double>(num_larger_params - e.state.params.size());
  const double freedom = 2.0 * static_cast<double>(num_corners) - static_cast<double>(num_larger_params) -
                         6.0 * static_cast<double>(e.views.size());
  const double drop = 2 * (cornersCost(e) - larger_cost);
  return drop / extra > kNeededF * std::max(2 * larger_cost, noiseFloor(num_corners)) / freedom &&
         drop > needed_share * 2 * cornersCost(e);
}

// A few steps tell whether there is anything to gain.
constexpr int kGlance = 5;

BundleState enlarged(const Estimation& e, const std::string& id) {
  BundleState larger = e.state;
  larger.params = parametersByName(e.options.model, e.state.params, id);
  return larger;
}

struct LargerSolution {
  std::string id;
  BundleState state;
};

// The next larger model solved on the same corners, if it explains them better beyond doubt and is sound.
std::optional<LargerSolution> largerSolution(const Estimation& e) {
  const auto id = nextLargerModel(NestedModels{}, e.options.model);
  // Held parameters are the user's will; a larger model would be compared with something else.
  if (!id || !e.constraint.isNone() || e.summary.termination == Termination::kFailed) return std::nullopt;
  BundleState larger = enlarged(e, *id);
  if (!isGain(e, solveLarger(e, *id, larger, kGlance).cost, larger.params.size())) return std::nullopt;
  // Where the larger model has parameters that these views cannot tell apart, the solver drifts without
  // end.
  constexpr int kPatience = 100;
  const BundleSummary summary = solveLarger(e, *id, larger, kPatience);
  if (!isGain(e, summary.cost, larger.params.size()) ||
      unsoundnessOf(*id, e.views.front().size, e.observations, larger, summary, e.constraint)) {
    return std::nullopt;
  }
  return LargerSolution{.id = *id, .state = std::move(larger)};
}

// Both by the weights of the model in use, as the comparison was.
BetterModel betterModelOf(const Estimation& e, const LargerSolution& larger) {
  return {.id = larger.id,
          .rms_px = weightedRms(larger.id, e.observations, larger.state),
          .lean_rms_px = std::sqrt(meanWeightedSquare(e))};
}

// Where some of the views alone do not determine one of the two, or its camera does not see what the other
// views show, the fit alone decides.
bool predictsBetter(const Estimation& e, const LargerSolution& larger) {
  const BundleOptions options = {.loss = e.loss, .cancel = e.options.cancel};
  BundleOptions lean_options = options;
  lean_options.prior = e.weak_prior.prior;
  const auto lean = heldOutErrors(e.options.model, e.board.square_m, e.observations, e.state, lean_options);
  const auto rich = heldOutErrors(larger.id, e.board.square_m, e.observations, larger.state, options);
  if (!lean || !rich) return true;
  if (holdoutReport(lean).num_unseen > 0 || holdoutReport(rich).num_unseen > 0) return true;
  return excessOf(scoreOf(*lean, e.observations, e.loss), scoreOf(*rich, e.observations, e.loss))
      .isWorth(larger.state.params.size() - e.state.params.size());
}

}  // namespace

std::optional<BetterModel> betterModel(const Estimation& e) {
  const auto larger = largerSolution(e);
  if (!larger) return std::nullopt;
  return betterModelOf(e, *larger);
}

std::optional<BetterModel> neededModel(const Estimation& e) {
  const auto larger = largerSolution(e);
  if (!larger || !predictsBetter(e, *larger)) return std::nullopt;
  return betterModelOf(e, *larger);
}

double dropAtAGlance(const Estimation& e, const std::string& larger_id) {
  BundleState larger = enlarged(e, larger_id);
  const BundleSummary glance = solveLarger(e, larger_id, larger, kGlance);
  if (glance.termination == Termination::kFailed) return 0;
  double floor = 0;
  for (const auto& view : e.observations) floor += noiseFloor(view.size());
  return 2 * (cornersCost(e) - glance.cost) / (2 * cornersCost(e) + floor);
}

}  // namespace alidade
