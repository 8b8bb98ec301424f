// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/view_reason.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "alidade/adjust/robust_weighting.h"
#include "alidade/adjust/solve.h"
#include "alidade/calibrate/clean/renumbering.h"
#include "alidade/calibrate/clean/view_fit.h"
#include "alidade/core/number_text.h"

namespace alidade {
namespace {

// The factor on the focal lengths with which the view fits. From the parameters' storage order, the focal
// lengths come first.
std::optional<double> fittingFocal(const Fit& fit, ViewFit view, const CancelFlag* cancel) {
  constexpr double kOther = 0.02;  // closer ones are the same lens with the focus moved, or chance
  Fit alone{.cameras = fit.cameras, .boards = fit.boards, .loss = fit.loss};
  onlyBoard(alone).is_shape_fixed = true;
  FitCamera& camera = onlyCamera(alone);
  camera.weak_prior = {};
  camera.constraint = {.held = {}, .same_focal = true};
  for (int i = 2; i < static_cast<int>(camera.params.size()); ++i) camera.constraint.held.push_back(i);
  addView(alone, 0, view.corners, view.camera_from_board);
  alone = solve(std::move(alone), {.function_tolerance = 1e-9, .cancel = cancel});
  if (alone.summary.termination != Termination::kConverged) return std::nullopt;
  view.errors = alone.views.front().errors;
  const double factor = onlyCamera(alone).params[0] / onlyCamera(fit).params[0];
  if (!isExplained(view, noiseSigma(fit)) || std::abs(factor - 1) < kOther) return std::nullopt;
  return factor;
}

}  // namespace

std::string misfitReason(const Fit& used, const View& view, const CancelFlag* cancel) {
  if (const auto order = fittingOrder(used, view))
    return "its corners are numbered otherwise than those of the other views: they fit if they are "
           "numbered " +
           *order;
  const auto fit = fitAlone(used, view);
  if (!fit) return "no pose of the board explains its corners";
  if (const auto factor = fittingFocal(used, *fit, cancel))
    return "it fits a camera with focal lengths " + numberText("%.2f", *factor) +
           " times as long: another camera, zoom, focus or crop";
  const std::size_t num_outliers = countOutliers(*fit, noiseSigma(used));
  const std::string share = std::to_string(num_outliers) + " of " + std::to_string(fit->errors.size());
  if (isSmooth(onlyBoard(used).target, *fit)) {
    double largest = 0;
    for (const auto& error : fit->errors) largest = std::max(largest, error.norm());
    return "its corners are displaced together, smoothly and by up to " + numberText("%.1f", largest) +
           " px: the board or the camera moved, or the board was bent, while the image was taken";
  }
  return share + " of its corners do not fit the camera that the other views agree on";
}

}  // namespace alidade
