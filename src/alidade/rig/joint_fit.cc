// SPDX-License-Identifier: MIT
#include "alidade/rig/joint_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/pose_deviations.h"
#include "alidade/adjust/noise/robust_weighting.h"
#include "alidade/calibrate/bend/flex_fit.h"
#include "alidade/core/mapped.h"
#include "alidade/rig/exposure.h"

namespace alidade {
namespace {

// Corners of a turned board, with weights in units of 1 / px^2.
std::vector<Observation> renumbered(const std::vector<Observation>& corners, const Board& board,
                                    const BoardTurn& turn, double sigma_px) {
  std::vector<Observation> result = corners;
  for (Observation& corner : result) {
    corner.id = turn.id_of[static_cast<std::size_t>(corner.id)];
    corner.p_board = board.corner(corner.id);
    corner.weight /= sigma_px * sigma_px;
  }
  std::ranges::sort(result, {}, &Observation::id);
  return result;
}

// A camera with weights in units of 1 / px^2, at its pose in the rig.
FitCamera placed(const Calibration& alone, double sigma_px, const SE3& camera_from_rig, bool is_first) {
  FitCamera joint = onlyCamera(alone.fit);
  for (double& precision : joint.weak_prior.prior.precision) precision /= sigma_px * sigma_px;
  joint.weak_prior.guard.sigma_px /= sigma_px;
  joint.camera_from_rig = camera_from_rig;
  joint.is_rig_pose_fixed = is_first;
  return joint;
}

// The largest flex that a camera alone finds; corners are in units of their noise.
Flex flexOf(const JointViews& views, std::size_t board) {
  Flex flex;
  for (const Calibration& alone : views.alone)
    flex.std_m = std::max(flex.std_m, alone.fit.boards[board].flex.std_m);
  if (flex.std_m > 0) flex.precision = 1 / (flex.std_m * flex.std_m);
  return flex;
}

// Starts the bends of a flexible board in each placement at the mean of those that its cameras alone find.
void startFlex(const JointViews& views, Fit& fit) {
  std::map<std::pair<std::size_t, std::size_t>, Eigen::Vector3d> sums;  // by placement and board; and number
  const auto bendOf = [](const BoardShape& shape) { return Eigen::Vector2d(shape.bend_x_m, shape.bend_y_m); };
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    const FitBoard& joint = boardOf(fit, fit.views[v]);
    const FitBoard& alone = views.alone[views.poses[v].camera].fit.boards[views.poses[v].board];
    if (!joint.isFlexible() || !alone.isFlexible()) continue;
    const Eigen::Vector2d bend = bendOf(shapeIn(alone, *views.poses[v].view)) - bendOf(joint.shape);
    sums.try_emplace({fit.views[v].placement, fit.views[v].board}, Eigen::Vector3d::Zero()).first->second +=
        Eigen::Vector3d(bend.x(), bend.y(), 1);
  }
  for (FitView& view : fit.views) {
    const auto sum = sums.find({view.placement, view.board});
    if (sum != sums.end()) view.flex_m = sum->second.head<2>() / sum->second.z();
  }
}

// The pose of a view's body as this view alone has it, with cameras and boards at their places in the fit.
SE3 rigFromBody(const Fit& fit, const JointViews& views, std::size_t v) {
  const PosedView& pose = views.poses[v];
  return fit.cameras[pose.camera].camera_from_rig.inverse() * pose.camera_from_board *
         (fit.boards[pose.board].poseOf({}) * views.turnOf(v).turned_from_board).inverse();
}

// Initial fit of all cameras together.
Fit startOf(const JointViews& views) {
  Fit fit{.boards = views.alone.front().fit.boards, .loss = {.threshold_px = kLossSigmas}};
  for (std::size_t c = 0; c < views.alone.size(); ++c) {
    fit.cameras.push_back(placed(views.alone[c], views.sigma_px[c], views.camera_from_rig[c], c == 0));
    for (std::size_t b = 0; b < fit.boards.size(); ++b) {
      const FitBoard& board = views.alone[c].fit.boards[b];
      if (fit.boards[b].is_shape_fixed && !board.is_shape_fixed) fit.boards[b] = board;
    }
  }
  // Each camera estimates the points differently and may number them differently.
  for (FitBoard& board : fit.boards) makeEven(board);
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    FitBoard& board = fit.boards[b];
    board.flex = flexOf(views, b);
    board.is_shape_fixed = board.is_shape_fixed || board.isFlexible();  // bends in each placement suffice
  }
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    if (views.body_of[b] != b) fit.boards[b].body_from_board = views.body_from_board[b];
  }
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> placement_of;  // by frame and body
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    const PosedView& pose = views.poses[v];
    const BoardTurn& turn = views.turnOf(v);
    const std::size_t body = views.body_of[pose.board];
    std::size_t placement = fit.placements.size();
    if (views.agrees[v]) placement = placement_of.try_emplace({pose.frame, body}, placement).first->second;
    if (placement == fit.placements.size())
      fit.placements.push_back(
          {.frame = pose.frame, .body = body, .rig_from_body = rigFromBody(fit, views, v)});
    fit.views.push_back({.camera = pose.camera,
                         .board = pose.board,
                         .placement = placement,
                         .source = v,
                         .corners = renumbered(views.poses[v].view->corners, fit.boards[pose.board].target,
                                               turn, views.sigma_px[pose.camera]),
                         .image = views.poses[v].view->image});
  }
  startFlex(views, fit);
  return fit;
}

// Estimates the positions of these boards' points with everything else. Contradicting views may make this
// fail and unlinking them may make it succeed, so each solve starts from scratch.
void solveUneven(std::span<const std::size_t> boards, JointFit& joint, const CancelFlag* cancel) {
  Fit& fit = joint.fit;
  std::vector<std::size_t> even;
  for (const std::size_t b : boards) {
    if (!fit.boards[b].isUneven()) even.push_back(b);
  }
  auto uneven = withOffsets(startedUneven(fit, even), OffsetScatter::kEstimate, cancel);
  joint.are_points_lost = !uneven;
  if (uneven) {
    fit = *std::move(uneven);
    return;
  }
  for (FitBoard& board : fit.boards) makeEven(board);
  fit = solve(std::move(fit), {.cancel = cancel});
}

// Mean square of a view's errors in units of its camera's noise.
double meanSquare(const FitView& view) {
  double sum = 0;
  for (std::size_t i = 0; i < view.corners.size(); ++i)
    sum += view.corners[i].weight * view.errors[i].squaredNorm();
  return sum / (2 * static_cast<double>(view.corners.size()));
}

std::vector<SE3> placedByEach(const Fit& fit, const JointViews& views) {
  std::vector<SE3> rig_from_body;
  for (std::size_t v = 0; v < views.poses.size(); ++v) rig_from_body.push_back(rigFromBody(fit, views, v));
  return rig_from_body;
}

// RMS of a view's errors, with the body's pose from a second view, px.
double transferRms(const Fit& fit, const FitView& view, const SE3& rig_from_body) {
  const FitCamera& camera = fit.cameras[view.camera];
  const SE3 rig_from_board = boardOf(fit, view).poseOf(rig_from_body);
  double sum = 0;
  for (const Eigen::Vector2d& error : reprojectionErrors(
           camera.model, camera.params, camera.camera_from_rig * rig_from_board, cornersOnShape(fit, view)))
    sum += error.squaredNorm();
  const double square = sum / static_cast<double>(view.corners.size());
  return std::isfinite(square) ? std::sqrt(square) : std::numeric_limits<double>::max();
}

// Smallest error of each view over the other views of its placement; 0 if it is the only one.
using Transfers = std::vector<double>;

void updateTransfers(const Fit& fit, const std::vector<std::size_t>& of_placement,
                     const std::vector<SE3>& rig_from_body, Transfers& transfers) {
  for (const std::size_t v : of_placement) {
    double least = std::numeric_limits<double>::max();
    for (const std::size_t w : of_placement)
      if (w != v) least = std::min(least, transferRms(fit, fit.views[v], rig_from_body[w]));
    transfers[v] = of_placement.size() > 1 ? least : 0;
  }
}

Transfers transfersOf(const JointFit& joint, const std::vector<std::vector<std::size_t>>& placements) {
  Transfers transfers(joint.fit.views.size());
  for (const std::vector<std::size_t>& of_placement : placements)
    updateTransfers(joint.fit, of_placement, joint.rig_from_body, transfers);
  return transfers;
}

// The fit without placements that no view uses any more.
Fit withoutEmptyPlacements(const Fit& fit) {
  return withoutViews(fit, std::vector<bool>(fit.views.size(), false));
}

// Gives a view its own placement with its own pose of the body. A view that remains alone also gets its own
// pose, because the shared one may be far from it.
void unlink(std::size_t v, JointFit& joint) {
  Fit& fit = joint.fit;
  const std::size_t left = fit.views[v].placement;
  FitPlacement own = fit.placements[left];
  own.rig_from_body = joint.rig_from_body[v];
  fit.views[v].placement = fit.placements.size();
  fit.placements.push_back(own);
  fit.views[v].deviation.reset();
  joint.unlinked.push_back(v);
  const auto isLeft = [&](const FitView& view) { return view.placement == left; };
  if (std::ranges::count_if(fit.views, isLeft) != 1) return;
  const auto last = static_cast<std::size_t>(std::ranges::find_if(fit.views, isLeft) - fit.views.begin());
  fit.placements[left].rig_from_body = joint.rig_from_body[last];
  fit.views[last].deviation.reset();
}

bool hasBodies(const Fit& fit) {
  return std::ranges::any_of(fit.boards, &FitBoard::isBodyPoseFree);
}

// Error limit of each camera's views when poses come from single views: far above most errors.
std::vector<double> transferLimits(const Fit& fit, const Transfers& transfers) {
  constexpr double kFactor = 4;
  constexpr double kFactorByMotion = 12;  // a small error of one board's tilt moves the others far
  constexpr double kLeastPx = 2;
  constexpr std::size_t kQuarter = 4;  // if a camera moved, half of its views may be wrong
  const bool are_bodies = hasBodies(fit);
  std::vector<std::vector<double>> of_camera(fit.cameras.size());
  for (std::size_t v = 0; v < transfers.size(); ++v) {
    if (transfers[v] > 0) of_camera[fit.views[v].camera].push_back(transfers[v]);
  }
  std::vector<double> limits;
  for (std::vector<double>& own : of_camera) {
    const auto quartile = own.begin() + static_cast<std::ptrdiff_t>(own.size() / kQuarter);
    if (!own.empty()) std::ranges::nth_element(own, quartile);
    limits.push_back(
        std::max(kLeastPx, own.empty() ? 0 : (are_bodies ? kFactorByMotion : kFactor) * *quartile));
  }
  return limits;
}

// Unlinks contradictions of many pixels, which would mislead the solver.
void unlinkGrossContradictions(JointFit& joint) {
  std::vector<std::vector<std::size_t>> placements = viewsOfPlacements(joint.fit);
  Transfers transfers = transfersOf(joint, placements);
  const std::vector<double> limits = transferLimits(joint.fit, transfers);
  const auto excess = [&](std::size_t v) { return transfers[v] / limits[joint.fit.views[v].camera]; };
  for (std::vector<std::size_t>& of_placement : placements) {
    while (of_placement.size() > 1) {
      // The later of two equal ones.
      const auto worst =
          std::ranges::max_element(of_placement, {}, [&](std::size_t v) { return std::pair(excess(v), v); });
      if (excess(*worst) <= 1) break;
      unlink(*worst, joint);
      of_placement.erase(worst);
      updateTransfers(joint.fit, of_placement, joint.rig_from_body, transfers);
    }
  }
}

// The view whose own pose is farthest from those of the others; of two, the second one.
std::size_t oddOne(const std::vector<std::size_t>& of_placement, const JointViews& views,
                   const std::vector<SE3>& rig_from_body) {
  const auto distanceOf = [&](std::size_t v) { return views.poses[v].camera_from_board.translation.norm(); };
  std::size_t odd = of_placement.front();
  double most = -1;
  for (const std::size_t v : of_placement) {
    double sum = 0;
    for (const std::size_t other : of_placement)
      sum += between(rig_from_body[v], rig_from_body[other]).cost(std::max(distanceOf(v), distanceOf(other)));
    if (sum < most) continue;
    most = sum;
    odd = v;
  }
  return odd;
}

// RMS of errors, in units of the noise, that counts as a contradiction.
constexpr double kContradiction = 3;

bool isContradictory(const Fit& fit, const std::vector<std::size_t>& of_placement,
                     const std::vector<double>& alone) {
  return of_placement.size() > 1 && std::ranges::any_of(of_placement, [&](std::size_t v) {
           return meanSquare(fit.views[v]) > kContradiction * kContradiction * std::max(1.0, alone[v]);
         });
}

// Gives views that contradict the others of their frame their own poses. Returns true if there were any.
bool unlinkContradictions(const JointViews& views, const std::vector<double>& alone, JointFit& joint) {
  Fit& fit = joint.fit;
  bool is_any = false;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    if (!isContradictory(fit, of_placement, alone)) continue;
    if (!is_any) joint.rig_from_body = placedByEach(fit, views);
    unlink(oddOne(of_placement, views, joint.rig_from_body), joint);
    is_any = true;
  }
  return is_any;
}

bool isAnyContradictory(const Fit& fit, const std::vector<double>& alone) {
  return std::ranges::any_of(viewsOfPlacements(fit), [&](const std::vector<std::size_t>& of_placement) {
    return isContradictory(fit, of_placement, alone);
  });
}

// Unlinks the views of a camera with a pose step, on the side of the step with fewer views. Returns true if
// there were any.
bool unlinkMovedViews(const JointViews& views, JointFit& joint, std::vector<std::size_t>& moved) {
  const std::vector<Eigen::Vector2d> errors = weightedErrors(joint.fit);
  const auto step = likeliestPoseStep(joint.fit, coordinateVariance(errors, joint.fit.loss, 0));
  if (!step) return false;
  std::array<std::vector<std::size_t>, 2> sides;
  const std::vector<std::vector<std::size_t>> placements = viewsOfPlacements(joint.fit);
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    if (views.poses[v].camera == step->camera && placements[joint.fit.views[v].placement].size() > 1)
      sides[views.poses[v].frame < step->first_frame ? 0 : 1].push_back(v);
  }
  joint.rig_from_body = placedByEach(joint.fit, views);
  const std::vector<std::size_t>& side = sides[0].size() < sides[1].size() ? sides[0] : sides[1];
  for (const std::size_t v : side) unlink(v, joint);
  moved.insert(moved.end(), side.begin(), side.end());
  return !side.empty();
}

// Links views with the others of their frames again, where `doesAgree` is true for view and other. Returns
// true if there were any.
template <typename DoesAgree>
bool linkAgain(const JointViews& views, const DoesAgree& doesAgree, JointFit& joint) {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> linked;  // a view of each body in each frame
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    if (std::ranges::find(joint.unlinked, v) == joint.unlinked.end())
      linked[{views.poses[v].frame, views.body_of[views.poses[v].board]}] = v;
  }
  return std::erase_if(joint.unlinked, [&](std::size_t v) {
           const auto other = linked.find({views.poses[v].frame, views.body_of[views.poses[v].board]});
           if (other == linked.end() || !doesAgree(v, joint.fit.views[other->second])) return false;
           if (joint.fit.views[v].board == joint.fit.views[other->second].board)
             joint.fit.views[v].flex_m = joint.fit.views[other->second].flex_m;
           joint.fit.views[v].placement = joint.fit.views[other->second].placement;
           return true;
         }) > 0;
}

// Links views again, except those in `moved`, that agree with the others now that the cameras are known.
// Returns true if there were any.
bool relink(const JointViews& views, const std::vector<std::size_t>& moved, JointFit& joint) {
  joint.rig_from_body = placedByEach(joint.fit, views);
  const std::vector<double> limits =
      transferLimits(joint.fit, transfersOf(joint, viewsOfPlacements(joint.fit)));
  // The pose of a body by one view may be poor, and the fit tells better whether others contradict.
  const double more = hasBodies(joint.fit) ? 4 : 1;
  const auto doesAgree = [&](std::size_t v, const FitView& other) {
    const FitView& view = joint.fit.views[v];
    return std::ranges::find(moved, v) == moved.end() &&
           transferRms(joint.fit, view, joint.fit.placements[other.placement].rig_from_body) <=
               more * limits[view.camera];
  };
  return linkAgain(views, doesAgree, joint);
}

bool hasFailed(const JointFit& joint) {
  return joint.fit.summary.termination == Termination::kFailed;
}

JointFit startedFit(const JointViews& views) {
  JointFit joint{.fit = startOf(views)};
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    if (!views.agrees[v]) joint.unlinked.push_back(v);
  }
  joint.rig_from_body = placedByEach(joint.fit, views);
  return joint;
}

void solveOnce(std::span<const std::size_t> uneven, JointFit& joint, const CancelFlag* cancel) {
  const SolveOptions options{.cancel = cancel};
  const std::vector<FitCamera> start = joint.fit.cameras;
  joint.fit = solve(withoutEmptyPlacements(joint.fit), options);
  const bool was_flexible = isAnyFlexible(joint.fit);
  for (int step = 0; updateFlex(joint.fit) > kFlexAtRest; ++step) {
    joint.fit = solve(std::move(joint.fit), options);
    if (step < kMostFlexSteps) continue;
    joint.fit.summary.termination = Termination::kIterationLimit;
    joint.fit.summary.reason = "the board's bends do not come to rest";
    break;
  }
  if (was_flexible && !isAnyFlexible(joint.fit)) joint.fit = solve(std::move(joint.fit), options);
  if (!hasFailed(joint)) solveUneven(uneven, joint, cancel);
  if (std::ranges::all_of(joint.fit.cameras, hasFocalLengths)) return;
  joint.fit.cameras = start;
  joint.fit.summary.termination = Termination::kFailed;
  joint.fit.summary.reason = "a focal length is no longer positive";
}

// Keeps lenses from folding inside their images, unless the corners contradict.
void keepUnfolded(std::span<const std::size_t> uneven, JointFit& joint, const CancelFlag* cancel) {
  constexpr int kMostRounds = 8;
  constexpr double kMostRise = 25;  // of twice the cost, for each lens: five standard deviations
  const JointFit free = joint;
  std::set<std::size_t> guarded;
  for (int round = 0; round < kMostRounds && !hasFailed(joint); ++round) {
    bool is_any = false;
    for (std::size_t c = 0; c < joint.fit.cameras.size(); ++c) {
      FitCamera& camera = joint.fit.cameras[c];
      const bool is_given = camera.constraint.held.size() == camera.params.size();
      if (is_given || !guardFold(1, camera)) continue;
      guarded.insert(c);
      is_any = true;
    }
    if (!is_any) break;
    solveOnce(uneven, joint, cancel);
  }
  const double rise = 2 * (joint.fit.summary.cost - free.fit.summary.cost);
  if (hasFailed(joint) || rise > kMostRise * static_cast<double>(guarded.size())) joint = free;
}

// Mean square of the errors of each view in the fit of its camera alone, in units of its noise.
std::vector<double> meanSquaresAlone(const JointViews& views) {
  std::vector<double> alone;
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    const double sigma_px = views.sigma_px[views.poses[v].camera];
    alone.push_back(meanSquare(*views.poses[v].view) / (sigma_px * sigma_px));
  }
  return alone;
}

// The cameras as they are alone, each view with its own pose and errors: what a fit that failed leaves.
JointFit separateFit(JointViews views, const JointFit& failed) {
  views.agrees.assign(views.poses.size(), false);
  JointFit joint = startedFit(views);
  joint.unlinked = failed.unlinked;
  joint.fit.summary = failed.fit.summary;
  joint.are_points_lost = failed.are_points_lost;
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    const FitView& alone = *views.poses[v].view;
    std::map<int, Eigen::Vector2d> error_of;
    for (std::size_t i = 0; i < alone.corners.size(); ++i)
      error_of[views.turnOf(v).id_of[static_cast<std::size_t>(alone.corners[i].id)]] = alone.errors[i];
    joint.fit.views[v].errors =
        mapped(joint.fit.views[v].corners, [&](const Observation& corner) { return error_of[corner.id]; });
  }
  return joint;
}

// The fit in which all views of a frame were taken at one instant.
JointFit rigidFit(const JointViews& views, std::span<const std::size_t> uneven,
                  const std::vector<double>& alone, const CancelFlag* cancel) {
  JointFit joint = startedFit(views);
  unlinkGrossContradictions(joint);
  std::vector<std::size_t> moved;
  // Any camera may have moved.
  std::size_t num_motions = 0;
  do {
    solveOnce(uneven, joint, cancel);
  } while (!hasFailed(joint) && num_motions++ < views.alone.size() && isAnyContradictory(joint.fit, alone) &&
           unlinkMovedViews(views, joint, moved));
  const auto solveAll = [&] {
    while (!hasFailed(joint) && unlinkContradictions(views, alone, joint)) solveOnce(uneven, joint, cancel);
  };
  solveAll();
  if (!hasFailed(joint) && relink(views, moved, joint)) {
    solveOnce(uneven, joint, cancel);
    solveAll();
  }
  return joint;
}

// Unlinks the odd view of each placement with one that deviates by more than `most`, in units of the scatter.
// Returns true if there were any.
bool unlinkFarViews(const DeviationScatter& scatter, double most, const JointViews& views, JointFit& joint) {
  bool is_any = false;
  joint.rig_from_body = placedByEach(joint.fit, views);
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(joint.fit)) {
    const auto sizeOf = [&](std::size_t v) { return scatter.sizes[v]; };
    const auto farthest = std::ranges::max_element(of_placement, {}, sizeOf);
    if (!(sizeOf(*farthest) > most)) continue;
    unlink(of_placement.size() > 2 ? *farthest : oddOne(of_placement, views, joint.rig_from_body), joint);
    is_any = true;
  }
  return is_any;
}

bool areDelaysFound(const Fit& fit) {
  constexpr double kMostIntervals = 1;  // beyond the frames that the path is known from
  return std::ranges::all_of(fit.cameras,
                             [](const FitCamera& camera) { return std::abs(camera.delay) < kMostIntervals; });
}

// Estimates the deviations of views from their placements, and their scatter, until they come to rest. False
// if they do not, if corners move by no more than half their noise, if times differ by more than a frame
// explains, or if as many views contradict as without deviations.
bool settleDeviations(const JointViews& views, const std::vector<double>& alone, std::size_t most_unlinked,
                      Scatter& scatter, JointFit& joint, const CancelFlag* cancel) {
  constexpr int kMostRounds = 60;
  constexpr double kNearRest = 0.25;
  constexpr double kAtRest = 0.01;
  constexpr double kLeastShift = 0.5;
  constexpr double kGross = 6;
  // Images of different frames are not taken at one instant; and what leaves the path has another cause.
  constexpr Scatter kMost = {.std_intervals = 0.3, .path = 8};
  constexpr double kRoundTolerance = 1e-8;
  constexpr Scatter kLeast = {.std_intervals = 1e-3,
                              .path = 0.3};  // with less, errors of the path would tilt it again and again
  for (int round = 0; round < kMostRounds; ++round) {
    joint.fit =
        solve(withoutEmptyPlacements(joint.fit), {.function_tolerance = kRoundTolerance, .cancel = cancel});
    if (hasFailed(joint)) return false;
    const DeviationScatter found = deviationScatter(joint.fit);
    if (!(found.num_free > 0) || !areDelaysFound(joint.fit)) return false;
    scatter.std_intervals = std::max(kLeast.std_intervals, scatter.std_intervals * found.time_factor);
    scatter.path = std::max(kLeast.path, scatter.path * found.path_factor);
    followPaths(scatter, views.frames.times, joint.fit);
    const double step =
        std::max(scatter.std_intervals > kLeast.std_intervals ? std::abs(found.time_factor - 1) : 0,
                 scatter.path > kLeast.path ? std::abs(found.path_factor - 1) : 0);
    if (found.shift_sigmas < kLeastShift && found.time_factor < 1) return false;
    if (step > kNearRest) {
      // Views that are far from all others would mislead the scatter.
      unlinkFarViews(found, std::max(kContradiction, kGross * found.usual_size), views, joint);
      continue;
    }
    if (scatter.std_intervals > kMost.std_intervals || scatter.path > kMost.path) return false;
    const bool are_any_far =
        unlinkFarViews(found, kContradiction, views, joint) || unlinkContradictions(views, alone, joint);
    if (joint.unlinked.size() >= most_unlinked) return false;
    if (!are_any_far && step < kAtRest) return true;
  }
  return false;
}

// The fit in which views of a frame were not taken at one instant: each may deviate from its placement along
// the board's motion. Views that do so by more than three times the scatter contradict the others. Nothing if
// the views were taken at one instant, if the motion does not explain their differences, if as many views
// contradict, or if boards flex, whose bends are estimated for simultaneous views.
// @param most_unlinked  number of views that contradict without deviations
std::optional<JointFit> looseFit(const JointViews& views, std::span<const std::size_t> uneven,
                                 const std::vector<double>& alone, std::size_t most_unlinked,
                                 const CancelFlag* cancel) {
  JointFit joint = startedFit(views);
  joint.fit = withoutEmptyPlacements(joint.fit);
  if (views.frames.are_simultaneous || isAnyFlexible(joint.fit) || joint.unlinked.size() >= most_unlinked)
    return std::nullopt;
  Scatter scatter = startDeviations(joint.rig_from_body, views.frames.times, joint.fit);
  if (!(scatter.std_intervals > 0) || !settleDeviations(views, alone, most_unlinked, scatter, joint, cancel))
    return std::nullopt;
  // Views that contradicted while delays were unknown.
  JointFit again = joint;
  Scatter scatter_again = scatter;
  if (linkAgain(
          views, [](std::size_t, const FitView&) { return true; }, again)) {
    followPaths(scatter, views.frames.times, again.fit);
    if (settleDeviations(views, alone, joint.unlinked.size(), scatter_again, again, cancel)) {
      joint = std::move(again);
      scatter = scatter_again;
    }
  }
  solveOnce(uneven, joint, cancel);
  if (hasFailed(joint) || joint.fit.summary.termination == Termination::kIterationLimit) return std::nullopt;
  joint.exposure = exposureScatter(scatter.std_intervals, joint.fit);
  return joint;
}

}  // namespace

std::vector<std::size_t> unevenBoards(std::span<const Fit* const> fits) {
  std::set<std::size_t> uneven;
  for (const Fit* fit : fits) {
    for (std::size_t b = 0; b < fit->boards.size(); ++b) {
      if (fit->boards[b].isUneven()) uneven.insert(b);
    }
  }
  return {uneven.begin(), uneven.end()};
}

JointFit jointFit(const JointViews& views, std::span<const std::size_t> uneven, const CancelFlag* cancel) {
  const std::vector<double> alone = meanSquaresAlone(views);
  JointFit joint = rigidFit(views, uneven, alone, cancel);
  keepUnfolded(uneven, joint, cancel);
  const std::size_t most_unlinked = hasFailed(joint) ? views.poses.size() : joint.unlinked.size();
  if (auto loose = looseFit(views, uneven, alone, most_unlinked, cancel)) {
    joint = *std::move(loose);
    keepUnfolded(uneven, joint, cancel);
  }
  if (!hasFailed(joint) && !std::isfinite(rms(joint.fit))) {
    joint.fit.summary.termination = Termination::kFailed;
    joint.fit.summary.reason = "a corner cannot be projected";
  }
  if (hasFailed(joint)) joint = separateFit(views, joint);
  std::ranges::sort(joint.unlinked);
  joint.rig_from_body = placedByEach(joint.fit, views);
  return joint;
}

double rmsOfCamera(const Fit& fit, std::size_t camera) {
  double sum = 0;
  double count = 0;
  for (const FitView& view : fit.views) {
    if (view.camera != camera) continue;
    for (const Eigen::Vector2d& error : view.errors) sum += error.squaredNorm();
    count += static_cast<double>(view.errors.size());
  }
  return std::sqrt(sum / count);
}

}  // namespace alidade
