// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/outliers.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "alidade/adjust/board/solve.h"
#include "alidade/calibrate/clean/view_fit.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

std::vector<ViewFit> fitsInUse(const Fit& fit, const PreparedViews& given) {
  std::vector<ViewFit> fits;
  for (std::size_t v = 0; v < fit.views.size(); ++v)
    fits.push_back(fitInUse(fit, v, given.views[fit.views[v].source]));
  return fits;
}

std::optional<std::size_t> worstForeignView(const Fit& fit, const PreparedViews& given) {
  const std::vector<ViewFit> fits = fitsInUse(fit, given);
  const std::vector<double> ratios = mapped(fits, &ViewFit::misfitRatio);
  const double stand_out = standOutRatio(ratios);
  std::optional<std::size_t> worst;
  for (std::size_t v = 0; v < fits.size(); ++v) {
    if (isForeign(fit, fits[v], stand_out) && (!worst || ratios[v] > ratios[*worst])) worst = v;
  }
  return worst;
}

// Judges all corners again; false if the outliers are the same as before.
bool leaveOutCorners(Fit& fit, const PreparedViews& given, const CancelFlag* cancel) {
  std::vector<std::vector<Observation>> kept;
  bool is_changed = false;
  for (const ViewFit& all : fitsInUse(fit, given)) {
    const std::vector<Observation>& before = fit.views[kept.size()].corners;
    std::vector<Observation>& good = kept.emplace_back();
    for (std::size_t i = 0; i < all.errors.size(); ++i) {
      if (!all.isOutlier(i)) good.push_back(all.corners[i]);
    }
    is_changed = is_changed || !std::ranges::equal(good, before, {}, &Observation::id, &Observation::id);
  }
  if (!is_changed) return false;
  for (std::size_t v = 0; v < fit.views.size(); ++v) fit.views[v].corners = std::move(kept[v]);
  fit = solve(std::move(fit), {.cancel = cancel});
  return true;
}

// Sets aside views that do not fit the camera of the others, the worst first, and solves again after each:
// views that look wrong beside a bad one may be right without it. Stops when half of the views are gone,
// since it is then unclear which are right.
// @throws Error (kInput) if too few views are left
void setAsideForeignViews(SettledFit& now, const PreparedViews& given, const CancelFlag* cancel) {
  while (2 * now.fit.views.size() > given.views.size()) {
    const auto worst = worstForeignView(now.fit, given);
    if (!worst) break;
    now.fit = withoutView(now.fit, *worst);
    requireViews(given, now.fit);
    now = settled(std::move(now.fit), cancel);
  }
}

// Sets aside views of which some corners fit only if all are numbered differently; the pose would be wrong
// as well. False if there are none.
bool setAsideMisnumberedViews(SettledFit& now, const PreparedViews& given, const CancelFlag* cancel) {
  constexpr std::size_t kFewOutliers = 3;  // too few to be a row or a column
  std::vector<bool> is_out;
  for (const ViewFit& of : fitsInUse(now.fit, given)) {
    const View& view = given.views[now.fit.views[is_out.size()].source];
    is_out.push_back(of.countOutliers() >= kFewOutliers && fittingOrder(now.fit, view));
  }
  if (std::ranges::find(is_out, true) == is_out.end()) return false;
  now.fit = withoutViews(now.fit, is_out);
  requireViews(given, now.fit);
  now = settled(std::move(now.fit), cancel);
  return true;
}

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
  if (!view.isExplained() || std::abs(factor - 1) < kOther) return std::nullopt;
  return factor;
}

// Reason why a view does not fit the camera of the others, if its corners show one.
// @param used  the fit without the view
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
  const std::size_t num_outliers = fit->countOutliers();
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
                            .pixel = all.corners[i].pixel,
                            .error_px = all.errors[i]});
      }
    }
  }
  return outliers;
}

}  // namespace

bool readmitViews(SettledFit& now, const PreparedViews& given, const CancelFlag* cancel) {
  const std::vector<std::size_t> left_out = viewsLeftOut(given, now.fit);
  if (left_out.empty()) return false;
  const double stand_out = standOutRatio(mapped(fitsInUse(now.fit, given), &ViewFit::misfitRatio));
  std::vector<std::pair<std::size_t, ViewFit>> fitting;
  for (const std::size_t v : left_out) {
    auto view = fitAlone(now.fit, given.views[v]);
    if (!view || isForeign(now.fit, *view, stand_out)) continue;
    fitting.emplace_back(v, *std::move(view));
  }
  if (fitting.empty()) return false;
  for (auto& [source, view] : fitting)
    addView(now.fit, source, std::move(view.corners), view.camera_from_board, view.board);
  for (FitView& view : now.fit.views) view.image = given.views[view.source].image;
  now = settled(std::move(now.fit), cancel);
  return true;
}

SettledFit withoutOutliers(SettledFit settled, const PreparedViews& given, const CancelFlag* cancel) {
  bool may_readmit = true;
  for (int round = 0; round < kMaxRounds; ++round) {
    // Views first, because the remaining ones have enough corners.
    setAsideForeignViews(settled, given, cancel);
    if (leaveOutCorners(settled.fit, given, cancel)) continue;
    // Once only, or a borderline view would alternate for ever.
    if (std::exchange(may_readmit, false) && readmitViews(settled, given, cancel)) continue;
    if (!setAsideMisnumberedViews(settled, given, cancel)) return settled;
  }
  settled.is_settled = false;
  return settled;
}

Dropped droppedFrom(const Fit& fit, const PreparedViews& given, const CancelFlag* cancel) {
  Dropped dropped = given.dropped;
  dropped.outliers = outliersOf(fit, given);
  for (const std::size_t v : viewsLeftOut(given, fit)) {
    const View& view = given.views[v];
    dropped.views.push_back({.image = view.image,
                             .board = view.board,
                             .reason = misfitReason(fit, view, cancel),
                             .is_misfit = true});
  }
  std::ranges::sort(dropped.views, [](const auto& a, const auto& b) {
    return a.image == b.image ? a.board < b.board : naturalLess(a.image, b.image);
  });
  return dropped;
}

}  // namespace alidade
