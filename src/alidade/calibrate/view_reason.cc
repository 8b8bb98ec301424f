// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_reason.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "alidade/calibrate/number_text.h"
#include "alidade/calibrate/renumbering.h"
#include "alidade/calibrate/view_fit.h"

namespace alidade {
namespace {

// The factor on the focal lengths with which the view fits. From the parameters' storage order, the focal
// lengths come first.
std::optional<double> fittingFocal(const Estimation& e, ViewFit fit) {
  constexpr double kOther = 0.02;  // closer ones are the same lens with the focus moved, or chance
  BundleState state{.params = e.state.params, .camera_from_board = {fit.camera_from_board}};
  std::vector<int> held;
  for (int i = 2; i < static_cast<int>(state.params.size()); ++i) held.push_back(i);
  const BundleSummary summary = solveBundle(e.options.model, std::span(&fit.observations, 1), state,
                                            {.loss = e.loss,
                                             .function_tolerance = 1e-9,
                                             .constraint = {.held = std::move(held), .same_focal = true},
                                             .cancel = e.options.cancel});
  if (summary.termination != Termination::kConverged) return std::nullopt;
  fit.camera_from_board = state.camera_from_board.front();
  fit.errors = reprojectionErrors(e.options.model, state.params, fit.camera_from_board, fit.observations);
  const double factor = state.params[0] / e.state.params[0];
  if (!isExplained(fit, noiseSigma(e)) || std::abs(factor - 1) < kOther) return std::nullopt;
  return factor;
}

std::string reasonFor(const Estimation& e, const View& view) {
  if (const auto order = fittingOrder(e, view))
    return "its corners are numbered otherwise than those of the other views: they fit if they are "
           "numbered " +
           *order;
  const auto fit = fitAlone(e, view);
  if (!fit) return "no pose of the board explains its corners";
  if (const auto factor = fittingFocal(e, *fit))
    return "it fits a camera with focal lengths " + numberText("%.2f", *factor) +
           " times as long: another camera, zoom, focus or crop";
  const std::size_t num_outliers = countOutliers(*fit, noiseSigma(e));
  const std::string share = std::to_string(num_outliers) + " of " + std::to_string(fit->errors.size());
  if (isSmooth(e.board, *fit)) {
    double largest = 0;
    for (const auto& error : fit->errors) largest = std::max(largest, error.norm());
    return "its corners are displaced together, smoothly and by up to " + numberText("%.1f", largest) +
           " px: the board or the camera moved, or the board was bent, while the image was taken";
  }
  return share + " of its corners do not fit the camera that the other views agree on";
}

}  // namespace

void nameReasons(Estimation& e) {
  for (const View& view : e.misfits) e.excluded.push_back({view.image, reasonFor(e, view)});
}

}  // namespace alidade
