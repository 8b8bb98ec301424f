// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_out_images.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/corner_groups.h"
#include "alidade/calibrate/cross_validation.h"
#include "alidade/calibrate/local_sigma.h"
#include "alidade/calibrate/pose_refit.h"
#include "alidade/calibrate/start_poses.h"
#include "alidade/calibrate/view_kernel.h"
#include "alidade/compare/agreement.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/init/pose_from_rays.h"
#include "alidade/target/board_shape.h"
#include "alidade/validate/held_out/camera_change.h"
#include "alidade/validate/held_out/change_refit.h"
#include "alidade/validate/held_out/covered_pixels.h"
#include "alidade/validate/held_out/held_scores.h"
#include "alidade/validate/held_out/held_views.h"
#include "alidade/validate/held_out/misfit.h"

namespace alidade {
namespace {

// The fewest pixels over which a camera is compared.
constexpr std::size_t kFewestPixels = 20;

std::optional<CalibrationResult> calibrated(const ComparedCamera& camera, const Checkerboard& board,
                                            const std::vector<View>& views, const HeldOutOptions& options,
                                            std::string& complaint) {
  CalibratorOptions how{.model = std::string(camera.camera->modelId())};
  how.jobs = options.jobs;
  how.cancel = options.cancel;
  try {
    return calibrate(board, views, how);
  } catch (const Error& error) {
    complaint = error.what();
    return std::nullopt;
  }
}

// The views and corners that the freed calibration used; all of them without one.
std::vector<View> usedViews(const std::vector<View>& views, const std::optional<CalibrationResult>& freed) {
  if (!freed) return views;
  std::set<std::string> images;
  for (const ViewResult& view : freed->views) images.insert(view.image);
  std::set<std::pair<std::string, int>> outliers;
  for (const Outlier& outlier : freed->outliers) outliers.insert({outlier.image, outlier.corner_id});
  std::vector<View> used;
  for (const View& view : views) {
    if (!images.contains(view.image)) continue;
    used.push_back(view);
    std::erase_if(used.back().corners, [&](const Corner& corner) {
      return outliers.contains({view.image, corner.id});
    });
  }
  return used;
}

// The RMS of errors on the other half of a view's corners, for noise of the given sigma an axis: the pose has
// six parameters from half of the corners' coordinates.
double heldOutNoise(double sigma_px, const std::vector<std::vector<Observation>>& views) {
  double sum = 0;
  std::size_t count = 0;
  for (const auto& view : views) {
    const auto n = static_cast<double>(view.size());
    sum += 2 * sigma_px * sigma_px * (n + 6);
    count += view.size();
  }
  return std::sqrt(sum / static_cast<double>(count));
}

HuberLoss lossOf(const ComparedCamera& camera, const HeldOutJudgement& judgement) {
  return judgement.freed ? judgement.freed->loss : startLoss(camera.size);
}

// Poses the views for the camera as it is and asks what it predicts.
HeldViews predictCorners(const ComparedCamera& camera, const Checkerboard& board,
                         const std::vector<View>& views, HeldOutJudgement& judgement) {
  const std::string_view model = camera.camera->modelId();
  const auto given = camera.camera->parameters();
  const HuberLoss loss = lossOf(camera, judgement);
  const BoardShape shape = judgement.freed ? judgement.freed->shape.shape : BoardShape{};
  HeldViews held_views;
  PosedViews& fit = held_views.posed;
  fit = {
      .views = {}, .state = {.params = {given.begin(), given.end()}, .camera_from_board = {}}, .weights = {}};
  std::vector<std::size_t> seen_views;
  auto observations = observationsOf(board, views);
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (Observation& o : observations[v]) o.p_board = onBentBoard(board, shape, o.p_board);
    judgement.views.push_back({.image = views[v].image});
    HeldOutView& view = judgement.views.back();
    view.is_testable = isTestable(board, views[v]);
    const auto pose = poseOf(camera, board, views[v], observations[v], loss);
    if (!pose) {
      if (view.is_testable) view.num_unseen = static_cast<int>(views[v].corners.size());
      continue;
    }
    view.camera_from_board = *pose;
    fit.state.camera_from_board.push_back(*pose);
    fit.views.push_back(std::move(observations[v]));
    fit.weights.push_back(weightOf(views[v].image, judgement.freed));
    held_views.images.push_back(views[v].image);
    seen_views.push_back(v);
  }
  BundleOptions held{.loss = loss};
  held.constraint.held.resize(given.size());
  std::iota(held.constraint.held.begin(), held.constraint.held.end(), 0);
  const auto held_out = heldOutErrors(model, board.square_m, fit.views, fit.state, held);
  expect(held_out.has_value(), "a camera that is held has held-out errors");

  std::vector<std::vector<Eigen::Vector2d>> errors;
  double fixed_sum = 0;
  std::size_t fixed_count = 0;
  double held_out_sum = 0;
  for (std::size_t i = 0; i < fit.views.size(); ++i) {
    errors.push_back(
        reprojectionErrors(model, fit.state.params, fit.state.camera_from_board[i], fit.views[i]));
    for (const Eigen::Vector2d& error : errors.back()) fixed_sum += error.squaredNorm();
    fixed_count += errors.back().size();
    HeldOutView& view = judgement.views[seen_views[i]];
    double sum = 0;
    for (const Eigen::Vector2d& error : held_out->px[i]) {
      if (error.allFinite()) {
        sum += error.squaredNorm();
        ++view.num_corners;
      } else if (view.is_testable) {
        ++view.num_unseen;
      }
    }
    if (view.num_corners > 0) view.rms_px = std::sqrt(sum / view.num_corners);
    held_out_sum += sum;
  }
  for (const HeldOutView& view : judgement.views) {
    judgement.num_untestable_views += view.is_testable ? 0 : 1;
    judgement.num_corners += view.num_corners;
    judgement.num_unseen += view.num_unseen;
  }
  if (judgement.num_corners > 0) judgement.held_out_rms_px = std::sqrt(held_out_sum / judgement.num_corners);
  if (fixed_count == 0) return held_views;
  judgement.fixed_rms_px = std::sqrt(fixed_sum / static_cast<double>(fixed_count));
  judgement.noise_sigma_px = localSigma(board, fit.views, errors);
  if (judgement.freed) {
    const PosedViews freed = posedByFreed(held_views, *judgement.freed);
    judgement.noise_sigma_px =
        std::min(judgement.noise_sigma_px, localSigma(board, fit.views, errorsOf(model, freed)));
    judgement.misfit_sigmas = misfitSigmas(model, fit, freed);
  }
  judgement.noise_rms_px = heldOutNoise(judgement.noise_sigma_px, fit.views);
  return held_views;
}

// By how much the views' disagreement makes the variance of the parameters larger than the corners' noise
// does, at least 1; 1 where they are too few to disagree.
double varianceRatio(const CalibrationResult& freed) {
  return freed.by_views ? std::max(1.0, freed.by_views->excess) : 1.0;
}

void compareWithFreed(const ComparedCamera& tested, const std::vector<Eigen::Vector2d>& covered,
                      HeldOutJudgement& judgement) {
  const CalibrationResult& freed = *judgement.freed;
  judgement.freed_rms_px = freed.rms_px;
  if (!freed.covariance || covered.size() < kFewestPixels) return;
  const ComparedCamera other{
      &freed.camera, freed.image_size,
      freed.isNoiseExceeded() ? freed.statedCovariance() : judgement.variance_ratio * *freed.covariance};
  const DifferenceOptions options{.pixels = covered};
  judgement.difference = projectionDifference(tested, other, options);
  judgement.significance = significanceOf(*judgement.difference, tested, other, options.freed);
}

// What a change would do, where it is worth mentioning.
NeededChange measured(CameraChange change, const StepEstimate& estimate, const ComparedCamera& tested,
                      const ChangeEvidence& evidence, const std::vector<Eigen::Vector2d>& covered) {
  NeededChange needed{.change = change, .estimate = estimate};
  if (!needed.isHint()) return needed;
  needed.p95_px = std::numeric_limits<double>::infinity();
  if (const auto refit = refitChange(*tested.camera, change, evidence)) {
    needed.refined = refit->estimate;
    needed.refined_rms_px = refit->rms_px;
  }
  const auto other = changed(*tested.camera, change, estimate.amount);
  if (!other) return needed;
  const ProjectionDifference difference =
      projectionDifference({tested.camera, tested.size}, {&*other, tested.size}, {.pixels = covered});
  if (isComparable(difference)) needed.p95_px = difference.p95_px;
  return needed;
}

void testAsItIs(const ComparedCamera& tested, const HeldViews& held,
                const std::vector<Eigen::Vector2d>& covered, HeldOutJudgement& judgement) {
  if (covered.size() < kFewestPixels || !std::isfinite(judgement.noise_sigma_px)) return;
  std::optional<PosedViews> freed;
  if (judgement.freed) freed = posedByFreed(held, *judgement.freed);
  const double sigma_px = std::max(judgement.noise_sigma_px, kFinestPx);
  const auto scores = HeldScores::make(*tested.camera, held.posed, freed ? &*freed : nullptr,
                                       sigma_px * sigma_px, tested.covariance);
  if (!scores) return;
  judgement.overall = scores->overall();
  const ChangeEvidence evidence{.held = &held.posed,
                                .freed = freed ? &*freed : nullptr,
                                .noise_variance = sigma_px * sigma_px,
                                .covariance = tested.covariance};
  for (const CameraChange change : kAllCameraChanges) {
    const Eigen::VectorXd direction = directionOf(change, *tested.camera);
    const auto estimate = direction.size() > 0 ? scores->along(direction) : std::nullopt;
    if (estimate) judgement.changes.push_back(measured(change, *estimate, tested, evidence, covered));
  }
  std::stable_sort(
      judgement.changes.begin(), judgement.changes.end(),
      [](const NeededChange& a, const NeededChange& b) { return a.estimate.sigmas > b.estimate.sigmas; });
}

}  // namespace

HeldOutJudgement judgeOnImages(const ComparedCamera& camera, const Checkerboard& board,
                               std::vector<View> views, const HeldOutOptions& options) {
  if (views.empty()) {
    throw inputError({.where = "held-out images",
                      .found = "no view of the board",
                      .expected = "images of the board that the camera was not calibrated from"});
  }
  for (const View& view : views) {
    if (view.size == camera.size) continue;
    const bool is_swapped = view.size.width == camera.size.height && view.size.height == camera.size.width;
    throw inputError(
        {.where = view.image,
         .found = "an image of " + sizeText(view.size) + " px",
         .expected = sizeText(camera.size) + " px, the camera's image size",
         .next_step = is_swapped ? "one is the other lying on its side: width and height may be swapped "
                                   "in the camera file; if the images were turned, alidade convert "
                                   "--rotate 90 or 270"
                                 : "images of this camera as it is, or alidade convert --resize or "
                                   "--crop to theirs"});
  }
  std::sort(views.begin(), views.end(),
            [](const View& a, const View& b) { return naturalLess(a.image, b.image); });
  HeldOutJudgement judgement;
  judgement.num_views_given = static_cast<int>(views.size());
  judgement.freed = calibrated(camera, board, views, options, judgement.freed_complaint);
  const std::vector<View> used = usedViews(views, judgement.freed);
  const HeldViews held = predictCorners(camera, board, used, judgement);
  const MatchedGrid grid = matchedGrid(camera.size, camera.size, matchImages(camera.size, camera.size, 0));
  const std::vector<Eigen::Vector2d> covered = coveredPixels(grid.pixels, used);
  judgement.covered_share = static_cast<double>(covered.size()) / static_cast<double>(grid.pixels.size());
  // A file that states its uncertainty by noise alone was made from images like these.
  ComparedCamera tested = camera;
  if (judgement.freed) judgement.variance_ratio = varianceRatio(*judgement.freed);
  if (tested.covariance && !options.is_covariance_by_views) *tested.covariance *= judgement.variance_ratio;
  if (judgement.freed) compareWithFreed(tested, covered, judgement);
  testAsItIs(tested, held, covered, judgement);
  return judgement;
}

}  // namespace alidade
