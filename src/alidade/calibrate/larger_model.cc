// SPDX-License-Identifier: MIT
#include "alidade/calibrate/larger_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>

#include "alidade/calibrate/covariance.h"
#include "alidade/camera/model_list.h"
#include "alidade/init/lens_shapes.h"

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
  const double floor = 2 * kMinSigmaPx * kMinSigmaPx * static_cast<double>(num_corners);
  const double drop = 2 * (cornersCost(e) - larger_cost);
  return drop / extra > kNeededF * std::max(2 * larger_cost, floor) / freedom &&
         drop > needed_share * 2 * cornersCost(e);
}

// A larger model is only worth recommending if these views determine it and it sees the whole image.
bool isSound(const Estimation& e, const std::string& id, const BundleState& larger) {
  constexpr double kMinCondition = 1e-11;  // of parameters scaled to the same size
  const IntrinsicsInformation information = intrinsicsInformation(id, e.observations, larger);
  if (!information.inverse || information.scaled_condition < kMinCondition) return false;
  const AnyCamera camera = AnyCamera::make(id, larger.params);
  if (!certifyDomain(camera, e.views.front().size).full_image) return false;
  for (std::size_t v = 0; v < e.views.size(); ++v) {
    for (const Observation& observation : e.observations[v]) {
      if (!camera.project(larger.camera_from_board[v] * observation.p_board).ok()) return false;
    }
  }
  return true;
}

}  // namespace

// After run(): the next larger model, if it says beyond doubt that this one lacks something. It is solved
// from this one's answer, on the same corners and with the same loss, so that the two costs compare.
std::optional<BetterModel> betterModel(const Estimation& e) {
  const auto id = nextLargerModel(NestedModels{}, e.options.model);
  // Held parameters are the user's will; a larger model would be compared with something else.
  if (!id || !e.constraint.isNone() || e.summary.termination == Termination::kFailed) return std::nullopt;
  BundleState larger = e.state;
  larger.params = parametersByName(e.options.model, e.state.params, *id);
  // A few steps tell whether there is anything to gain; most often there is not.
  constexpr int kGlance = 5;
  const BundleSummary glance = solveLarger(e, *id, larger, kGlance);
  if (!isGain(e, glance.cost, larger.params.size())) return std::nullopt;
  // Where the larger model has parameters that these views cannot tell apart, the solver drifts without
  // end.
  constexpr int kPatience = 100;
  const BundleSummary summary = solveLarger(e, *id, larger, kPatience);
  if (summary.termination != Termination::kConverged || !isGain(e, summary.cost, larger.params.size()) ||
      !isSound(e, *id, larger)) {
    return std::nullopt;
  }
  // Both by the weights of this model, as the comparison was.
  double sum = 0;
  std::size_t num_corners = 0;
  for (std::size_t v = 0; v < e.views.size(); ++v) {
    const auto errors =
        reprojectionErrors(*id, larger.params, larger.camera_from_board[v], e.observations[v]);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      sum += e.observations[v][i].weight * errors[i].squaredNorm();
      ++num_corners;
    }
  }
  return BetterModel{.id = *id,
                     .rms_px = std::sqrt(sum / static_cast<double>(num_corners)),
                     .lean_rms_px = std::sqrt(meanWeightedSquare(e))};
}

}  // namespace alidade
