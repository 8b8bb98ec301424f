// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/dropped.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/clean/renumbering.h"
#include "alidade/calibrate/clean/view_fit.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/target/view.h"

namespace alidade {
namespace {

/// Reason why a view does not fit the camera of the others, if its corners show one.
/// @param used  the fit without the view
[[nodiscard]] std::string misfitReason(const Fit& used, const View& view, const CancelFlag* cancel);

// Factor on the focal lengths with which the view fits. Focal lengths come first in the parameters' storage
// order.
std::optional<double> fittingFocal(const Fit& fit, ViewFit view, const CancelFlag* cancel) {
  constexpr double kOther = 0.02;  // smaller differences: the same lens refocused, or chance
  Fit alone{.cameras = fit.cameras, .boards = fit.boards, .loss = fit.loss};
  fixShapes(alone);
  FitCamera& camera = onlyCamera(alone);
  camera.weak_prior = {};
  camera.constraint = {.held = {}, .same_focal = true};
  for (int i = 2; i < static_cast<int>(camera.params.size()); ++i) camera.constraint.held.push_back(i);
  addView(alone, 0, view.corners, view.camera_from_board, view.board);
  alone = solve(std::move(alone), {.function_tolerance = 1e-9, .cancel = cancel});
  if (alone.summary.termination != Termination::kConverged) return std::nullopt;
  view.errors = alone.views.front().errors;
  const double factor = onlyCamera(alone).params[0] / onlyCamera(fit).params[0];
  if (!isExplained(view, noiseSigma(fit)) || std::abs(factor - 1) < kOther) return std::nullopt;
  return factor;
}

std::string misfitReason(const Fit& used, const View& view, const CancelFlag* cancel) {
  if (const auto order = fittingOrder(used, view))
    return "its corners are numbered differently from those of the other views: they fit if they are "
           "numbered " +
           *order;
  const auto fit = fitAlone(used, view);
  if (!fit) return "no pose of the board explains its corners";
  if (const auto factor = fittingFocal(used, *fit, cancel))
    return "it fits a camera with focal lengths " + numberText("%.2f", *factor) +
           " times as long: another camera, zoom, focus or crop";
  const std::size_t num_outliers = countOutliers(*fit, noiseSigma(used));
  const std::string share = std::to_string(num_outliers) + " of " + std::to_string(fit->errors.size());
  if (isSmooth(used.boards[view.board].target, *fit)) {
    double largest = 0;
    for (const auto& error : fit->errors) largest = std::max(largest, error.norm());
    return "its corners are displaced together, smoothly and by up to " + numberText("%.1f", largest) +
           " px: the board or the camera moved, or the board was bent, while the image was taken";
  }
  return share + " of its corners do not fit the camera that the other views agree on";
}

std::vector<Outlier> outliersOf(const Fit& fit, const PreparedViews& given) {
  std::vector<Outlier> outliers;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const View& view = given.views[fit.views[v].source];
    const ViewFit all = fitInUse(fit, v, view);
    auto used = fit.views[v].corners.begin();
    for (std::size_t i = 0; i < all.corners.size(); ++i) {
      if (used != fit.views[v].corners.end() && used->id == all.corners[i].id) {
        ++used;
      } else {
        outliers.push_back({.source = fit.views[v].source,
                            .image = view.image,
                            .board = view.board,
                            .corner_id = all.corners[i].id,
                            .error_px = all.errors[i]});
      }
    }
  }
  return outliers;
}

}  // namespace

Dropped droppedFrom(const Fit& fit, const PreparedViews& given, const CancelFlag* cancel) {
  Dropped dropped{.views = given.excluded, .repeated = given.repeated, .outliers = outliersOf(fit, given)};
  for (const std::size_t v : viewsLeftOut(given, fit)) {
    const View& view = given.views[v];
    dropped.views.push_back({.image = view.image,
                             .board = view.board,
                             .reason = misfitReason(fit, view, cancel),
                             .is_misfit = true});
  }
  std::sort(dropped.views.begin(), dropped.views.end(), [](const auto& a, const auto& b) {
    return a.image == b.image ? a.board < b.board : naturalLess(a.image, b.image);
  });
  return dropped;
}

}  // namespace alidade
