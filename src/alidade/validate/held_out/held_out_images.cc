// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_out_images.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/pose_search.h"
#include "alidade/adjust/board/view_pose.h"
#include "alidade/adjust/noise/correction_fit.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// The fewest pixels over which a camera is compared.
constexpr std::size_t kFewestPixels = 20;

// The views and corners that the freed calibration used, one per view of its fit; without a freed
// calibration, all of them.
std::vector<View> usedViews(const std::vector<View>& views, const std::optional<Calibration>& freed) {
  if (!freed) return views;
  std::vector<View> used;
  for (const FitView& view : freed->fit.views) {
    used.push_back(views[view.source]);
    used.back().corners = mapped(view.corners, [](const Observation& corner) {
      return Corner{.id = corner.id, .pixel = corner.pixel, .sigma_px = corner.sigma_px};
    });
  }
  return used;
}

// RMS of errors on the other half of a view's corners, for noise of the given sigma per axis: the pose has
// six parameters from half of the corners' coordinates.
double heldOutNoise(double sigma_px, const Fit& fit) {
  double sum = 0;
  for (const FitView& view : fit.views)
    sum += 2 * sigma_px * sigma_px * (static_cast<double>(view.corners.size()) + 6);
  return std::sqrt(sum / static_cast<double>(numCorners(fit)));
}

// True if either colour of the board's corners in this view determines a pose to predict the other colour
// from: at least four corners, not all in one row or column.
bool isTestable(const Board& board, const View& view) {
  constexpr std::size_t kFewestCorners = 4;
  for (const int colour : {0, 1}) {
    std::set<int> columns;
    std::set<int> rows;
    std::size_t count = 0;
    for (const Corner& corner : view.corners) {
      const int column = corner.id % board.columns();
      const int row = corner.id / board.columns();
      if ((column + row) % 2 != colour) continue;
      columns.insert(column);
      rows.insert(row);
      ++count;
    }
    if (count < kFewestCorners || columns.size() < 2 || rows.size() < 2) return false;
  }
  return true;
}

// The best pose of a view for the unchanged camera; nothing if it sees the corners from no pose.
std::optional<SE3> poseOf(const AnyCamera& camera, const Board& board, std::span<const Observation> corners,
                          HuberLoss loss) {
  const auto start = poseFromCorners(camera, corners);
  if (!start) return std::nullopt;
  const std::vector<double> params = fitParams(camera);
  std::optional<SE3> best;
  double best_cost = std::numeric_limits<double>::infinity();
  // From afar two tilts look alike, and only the cost decides between them.
  for (const SE3& from : {*start, mirroredTilt(*start, board.middle())}) {
    const auto pose = refitPose(camera.modelId(), params, corners, loss, from);
    const double cost = pose ? viewCost(camera.modelId(), params, *pose, corners, loss)
                             : std::numeric_limits<double>::quiet_NaN();
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best = pose;
  }
  return best;
}

// Weight of a view; blurred or moved views count less. The inverse of the variance of its corners in the
// freed calibration, shrunk towards the mean of all.
double weightOf(const Fit& freed, std::size_t view) {
  constexpr double kSharedCorners = 10;
  const double mean_square = rms(freed) * rms(freed);
  const std::vector<Eigen::Vector2d>& errors = freed.views[view].errors;
  double sum = kSharedCorners * mean_square;
  for (const Eigen::Vector2d& error : errors) sum += error.squaredNorm();
  const double num_corners = static_cast<double>(errors.size()) + kSharedCorners;
  return sum > 0 ? mean_square * num_corners / sum : 1.0;
}

// The same views, posed with the freed camera.
// @param held  its views' sources are indices into those of `freed`
PosedViews posedByFreed(const PosedViews& held, const Fit& freed) {
  PosedViews posed = held;
  onlyCamera(posed.fit).params = onlyCamera(freed).params;
  for (FitView& view : posed.fit.views) {
    setCameraFromBoard(posed.fit, view, cameraFromBoard(freed, freed.views[view.source]));
    view.errors = viewErrors(posed.fit, view);
  }
  return posed;
}

// Poses the views with the unchanged camera.
PosedViews poseViews(const ComparedCamera& camera, std::span<const Board> boards,
                     const std::vector<View>& views, HuberLoss loss, HeldOutJudgement& judgement) {
  const std::vector<double> given = fitParams(*camera.camera);
  PosedViews posed;
  Fit& fit = posed.fit;
  fit = emptyFit(std::string(camera.camera->modelId()), camera.size, given, boards, kNoLoss);
  FitCamera& fixed = onlyCamera(fit);
  fixed.constraint.held.resize(given.size());
  std::iota(fixed.constraint.held.begin(), fixed.constraint.held.end(), 0);
  for (std::size_t b = 0; judgement.freed && b < fit.boards.size(); ++b) {
    fit.boards[b].target = judgement.freed->fit.boards[b].target;
    fit.boards[b].shape = judgement.freed->fit.boards[b].shape;
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    judgement.views.push_back({.image = views[v].image, .board = views[v].board});
    HeldOutView& view = judgement.views.back();
    const FitBoard& of = fit.boards[views[v].board];
    const Board& board = of.target;
    view.is_testable = isTestable(board, views[v]);
    std::vector<Observation> corners = observationsOf(board, views[v]);
    const auto pose = poseOf(*camera.camera, board, onShape(board, of.shape, corners), loss);
    if (!pose) {
      if (view.is_testable) view.num_unseen = static_cast<int>(views[v].corners.size());
      continue;
    }
    addView(fit, v, std::move(corners), *pose, views[v].board);
    posed.weights.push_back(judgement.freed ? weightOf(judgement.freed->fit, v) : 1);
  }
  for (FitView& view : fit.views) view.errors = viewErrors(fit, view);
  return posed;
}

double rmsOf(const FitView& view) {
  double sum = 0;
  for (const Eigen::Vector2d& error : view.errors) sum += error.squaredNorm();
  return std::sqrt(sum / static_cast<double>(view.errors.size()));
}

// Tests whether the camera predicts corners.
void predictCorners(const PosedViews& held, const PosedViews* freed, HuberLoss loss,
                    HeldOutJudgement& judgement) {
  const Fit& fit = held.fit;
  Fit robust = fit;
  robust.loss = loss;
  const auto held_out = heldOutErrors(robust);
  expect(held_out.has_value(), "a camera that is held has held-out errors");
  double held_out_sum = 0;
  for (std::size_t i = 0; i < fit.views.size(); ++i) {
    HeldOutView& view = judgement.views[fit.views[i].source];
    view.camera_from_board = cameraFromBoard(fit, fit.views[i]);
    view.fixed_rms_px = rmsOf(fit.views[i]);
    if (freed != nullptr) view.freed_rms_px = rmsOf(freed->fit.views[i]);
    double sum = 0;
    for (std::size_t k = 0; k < held_out->px[i].size(); ++k) {
      const Eigen::Vector2d& error = held_out->px[i][k];
      if (error.allFinite()) {
        sum += error.squaredNorm();
        ++view.num_corners;
        const Observation& corner = fit.views[i].corners[k];
        view.corners.push_back({.id = corner.id, .pixel = corner.pixel, .error_px = error});
      } else if (view.is_testable) {
        ++view.num_unseen;
      }
    }
    if (view.num_corners > 0) view.rms_px = std::sqrt(sum / view.num_corners);
    held_out_sum += sum;
  }
  const int count = judgement.numCorners();
  if (count > 0) judgement.held_out_rms_px = std::sqrt(held_out_sum / count);
  if (numCorners(fit) == 0) return;
  judgement.fixed_rms_px = rms(fit);
  judgement.noise_sigma_px = localSigma(fit);
  if (freed != nullptr) {
    judgement.noise_sigma_px = std::min(judgement.noise_sigma_px, localSigma(freed->fit));
    judgement.misfit_sigmas = misfitSigmas(held, *freed);
  }
  judgement.noise_rms_px = heldOutNoise(judgement.noise_sigma_px, fit);
}

void compareWithFreed(const ComparedCamera& tested, const std::vector<Eigen::Vector2d>& covered,
                      double variance_ratio, HeldOutJudgement& judgement) {
  const Calibration& freed = *judgement.freed;
  const Uncertainty& known = freed.uncertainty;
  if (!known.covariance || covered.size() < kFewestPixels) return;
  const AnyCamera camera = freed.camera();
  const ComparedCamera other{&camera, freed.imageSize(),
                             known.isNoiseExceeded()
                                 ? known.statedCovariance()
                                 : DenseMatrix(variance_ratio * known.covariance->view())};
  const DifferenceOptions options{.pixels = covered};
  judgement.difference = projectionDifference(tested, other, options);
  judgement.significance = significanceOf(*judgement.difference, tested, other, options.freed);
}

// The effect of a change, if worth mentioning.
NeededChange measured(CameraChangeKind change, const StepEstimate& estimate, const ComparedCamera& tested,
                      const PosedViews* freed, double noise_variance,
                      const std::vector<Eigen::Vector2d>& covered) {
  NeededChange needed{.change = change, .estimate = estimate};
  if (!needed.isHint()) return needed;
  needed.p95_px = std::numeric_limits<double>::infinity();
  if (freed != nullptr)
    needed.refined = refitChange(*tested.camera, change, *freed, noise_variance, tested.covariance);
  const auto other = changed(*tested.camera, change, estimate.amount);
  if (!other) return needed;
  const ProjectionDifference difference =
      projectionDifference({tested.camera, tested.size}, {&*other, tested.size}, {.pixels = covered});
  if (isComparable(difference)) needed.p95_px = difference.p95_px;
  return needed;
}

void testAsItIs(const ComparedCamera& tested, const PosedViews& held, const PosedViews* freed,
                const std::vector<Eigen::Vector2d>& covered, HeldOutJudgement& judgement) {
  if (covered.size() < kFewestPixels || !std::isfinite(judgement.noise_sigma_px)) return;
  const double sigma_px = std::max(judgement.noise_sigma_px, kFinestPx);
  const double variance = sigma_px * sigma_px;
  const auto scores = HeldScores::make(*tested.camera, held, freed, variance, tested.covariance);
  if (!scores) return;
  judgement.overall = scores->overall();
  for (const CameraChangeKind change : kIntrinsicsChanges) {
    const Eigen::VectorXd direction = directionOf(change, *tested.camera);
    const auto estimate = direction.size() > 0 ? scores->along(direction) : std::nullopt;
    if (estimate) judgement.changes.push_back(measured(change, *estimate, tested, freed, variance, covered));
  }
  std::ranges::stable_sort(judgement.changes, [](const NeededChange& a, const NeededChange& b) {
    return a.estimate.sigmas > b.estimate.sigmas;
  });
}

}  // namespace

int HeldOutJudgement::numCorners() const {
  int sum = 0;
  for (const HeldOutView& view : views) sum += view.num_corners;
  return sum;
}

int HeldOutJudgement::numUnseen() const {
  int sum = 0;
  for (const HeldOutView& view : views) sum += view.num_unseen;
  return sum;
}

double HeldOutJudgement::freedRmsPx() const {
  return freed ? rms(freed->fit) : std::numeric_limits<double>::quiet_NaN();
}

HeldOutJudgement judgeOnImages(const ComparedCamera& camera, std::span<const Board> boards,
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
         .next_step =
             is_swapped
                 ? "one is the other rotated by 90 degrees: width and height may be swapped in the camera "
                   "file; if the images were rotated, use alidade convert --rotate 90 or 270"
                 : "use images of this size, or adapt the camera with alidade convert --resize or --crop"});
  }
  if (const auto& field = camera.camera->correction()) {
    const AnyCamera plain = camera.camera->withCorrection(nullptr);
    HeldOutJudgement judgement =
        judgeOnImages({.camera = &plain, .size = camera.size, .covariance = camera.covariance}, boards,
                      freeOf(*field, std::move(views)), options);
    if (judgement.freed) onlyCamera(judgement.freed->fit).correction = field;
    return judgement;
  }
  std::ranges::sort(views, [](const View& a, const View& b) {
    return a.image == b.image ? a.board < b.board : naturalLess(a.image, b.image);
  });
  HeldOutJudgement judgement;
  judgement.num_views_given = static_cast<int>(views.size());
  CalibratorOptions how{.model = std::string(camera.camera->modelId())};
  how.num_pupil = numPupil(*camera.camera);
  how.jobs = options.jobs;
  how.cancel = options.cancel;
  try {
    judgement.freed = calibrate(boards, views, how);
  } catch (const Error& error) {
    judgement.freed_complaint = error.what();
  }
  const HuberLoss loss = judgement.freed ? judgement.freed->fit.loss : startLoss(camera.size);
  const std::vector<View> used = usedViews(views, judgement.freed);
  const PosedViews held = poseViews(camera, boards, used, loss, judgement);
  std::optional<PosedViews> posed_by_freed;
  if (judgement.freed) posed_by_freed = posedByFreed(held, judgement.freed->fit);
  const PosedViews* const freed = posed_by_freed ? &*posed_by_freed : nullptr;
  predictCorners(held, freed, loss, judgement);
  const MatchedGrid grid = matchedGrid(camera.size, camera.size, matchImages(camera.size, camera.size, 0));
  const std::vector<Eigen::Vector2d> covered = coveredPixels(grid.pixels, isCovered(grid.pixels, used));
  judgement.covered_share = static_cast<double>(covered.size()) / static_cast<double>(grid.pixels.size());
  // Variance of the freed parameters from disagreement between views over that from corner noise: errors
  // common to the corners of one view (blur, the shape of the board) make views agree less than noise would.
  const bool is_by_views = judgement.freed && judgement.freed->uncertainty.by_views;
  // Not that frames are alike, which is a property of these images.
  const double variance_ratio = is_by_views
                                    ? std::max(1.0, judgement.freed->uncertainty.by_views->excess /
                                                        judgement.freed->uncertainty.by_views->serial_factor)
                                    : 1.0;
  // A file with an uncertainty by noise alone was made from images like these.
  ComparedCamera tested = camera;
  if (tested.covariance && !options.is_covariance_by_views)
    tested.covariance = DenseMatrix(variance_ratio * tested.covariance->view());
  if (judgement.freed) compareWithFreed(tested, covered, variance_ratio, judgement);
  testAsItIs(tested, held, freed, covered, judgement);
  if (judgement.freed) {
    PosedViews all{.fit = judgement.freed->fit, .weights = {}};
    all.fit.loss = kNoLoss;
    judgement.slips = mendedSlips(*camera.camera, all);
  }
  return judgement;
}

HeldOutJudgement judgeOnImages(const ComparedCamera& camera, const Board& board, std::vector<View> views,
                               const HeldOutOptions& options) {
  return judgeOnImages(camera, std::span(&board, 1), std::move(views), options);
}

}  // namespace alidade
