// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/correction_field.h"

namespace alidade {

AnyCamera cameraOf(const Fit& fit) {
  return cameraOf(onlyCamera(fit));
}

AnyCamera cameraOf(std::string_view model, std::span<const double> params) {
  const std::size_t num_lens = parameterNames(model).size();
  const AnyCamera lens = AnyCamera::make(model, params.first(num_lens));
  const auto pupil = params.subspan(num_lens);
  if (pupil.empty()) return lens;
  return lens.withPupil({.s1_m = pupil[0], .s2_m = pupil.size() > 1 ? pupil[1] : 0.0});
}

AnyCamera cameraOf(const FitCamera& camera) {
  return cameraOf(camera.model, camera.params).withCorrection(camera.correction);
}

Eigen::Vector2d seenPixel(const FitCamera& camera, const Eigen::Vector2d& of_corner) {
  return camera.correction == nullptr ? of_corner : of_corner + camera.correction->at(of_corner);
}

std::size_t numPupil(const AnyCamera& camera) {
  return camera.pupil().isFixed() ? 0 : camera.pupil().s2_m == 0 ? 1 : 2;
}

std::vector<double> fitParams(const AnyCamera& camera) {
  camera.requireUncorrected();
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  const std::array pupil = {camera.pupil().s1_m, camera.pupil().s2_m};
  params.insert(params.end(), pupil.begin(), pupil.begin() + numPupil(camera));
  return params;
}

void setLens(std::string_view model, std::span<const double> lens, FitCamera& camera) {
  const auto pupil = camera.params.begin() + static_cast<std::ptrdiff_t>(camera.numLensParams());
  std::vector<double> params(lens.begin(), lens.end());
  params.insert(params.end(), pupil, camera.params.end());
  camera.model = model;
  camera.params = std::move(params);
}

std::size_t FitCamera::numLensParams() const {
  return parameterNames(model).size();
}

Eigen::MatrixXd freeDirections(int num_params, const ParamConstraint& constraint) {
  std::vector<Eigen::VectorXd> columns;
  const auto unit = [&](int i) { return Eigen::VectorXd::Unit(num_params, i); };
  if (constraint.same_focal && !constraint.holds(0) && !constraint.holds(1))
    columns.emplace_back(unit(0) + unit(1));
  for (int i = constraint.same_focal ? 2 : 0; i < num_params; ++i) {
    if (!constraint.holds(i)) columns.emplace_back(unit(i));
  }
  Eigen::MatrixXd directions(num_params, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) directions.col(static_cast<Eigen::Index>(i)) = columns[i];
  return directions;
}

std::string_view terminationName(Termination termination) {
  constexpr std::array<std::string_view, 4> kNames = {"converged", "iteration_limit", "stalled", "failed"};
  return kNames.at(static_cast<std::size_t>(termination));
}

SE3::Tangent deviationTangent(const Fit& fit, const FitView& view) {
  return view.deviation->tangent(fit.cameras[view.camera].delay);
}

SE3 rigFromBoard(const Fit& fit, const FitView& view) {
  return boardOf(fit, view).poseOf(fit.placements[view.placement].rig_from_body);
}

SE3 cameraFromBoard(const Fit& fit, const FitView& view) {
  const SE3 placed = fit.cameras[view.camera].camera_from_rig * rigFromBoard(fit, view);
  return view.deviation ? placed * SE3::exp(deviationTangent(fit, view)) : placed;
}

void setCameraFromBoard(Fit& fit, const FitView& view, const SE3& camera_from_board) {
  const SE3 seen = fit.cameras[view.camera].camera_from_rig.inverse() * camera_from_board;
  const SE3 rig_from_board = view.deviation ? seen * SE3::exp(-deviationTangent(fit, view)) : seen;
  const std::optional<SE3>& body_from_board = boardOf(fit, view).body_from_board;
  fit.placements[view.placement].rig_from_body =
      body_from_board ? rig_from_board * body_from_board->inverse() : rig_from_board;
}

std::vector<Observation> onShape(const Board& board, const BoardShape& shape,
                                 std::span<const Observation> flat) {
  std::vector<Observation> corners(flat.begin(), flat.end());
  if (shape == BoardShape{}) return corners;
  for (Observation& corner : corners) corner.p_board = pointOn(board, shape, corner.id);
  return corners;
}

std::vector<Observation> cornersOnShape(const Fit& fit, const FitView& view) {
  const FitBoard& board = boardOf(fit, view);
  return onShape(board.target, shapeIn(board, view), view.corners);
}

void stiffen(Fit& fit) {
  for (FitBoard& board : fit.boards) board.flex = {};
  for (FitView& view : fit.views) view.flex_m.setZero();
}

BoardShape shapeIn(const FitBoard& board, const FitView& view) {
  BoardShape shape = board.shape;
  shape.bend_x_m += view.flex_m.x();
  shape.bend_y_m += view.flex_m.y();
  return shape;
}

std::string boardSuffix(const Fit& fit, std::size_t board) {
  return fit.boards.size() > 1 ? " (" + fit.boards[board].target.spec() + ")" : std::string();
}

std::vector<std::vector<std::size_t>> viewsOfPlacements(const Fit& fit) {
  std::vector<std::vector<std::size_t>> views(fit.placements.size());
  for (std::size_t v = 0; v < fit.views.size(); ++v) views[fit.views[v].placement].push_back(v);
  return views;
}

std::size_t numViews(const Fit& fit, std::size_t board) {
  return static_cast<std::size_t>(
      std::ranges::count_if(fit.views, [&](const FitView& view) { return view.board == board; }));
}

bool isAnyFlexible(const Fit& fit) {
  return std::ranges::any_of(fit.boards, &FitBoard::isFlexible);
}

bool isAnyUneven(const Fit& fit) {
  return std::ranges::any_of(fit.boards, &FitBoard::isUneven);
}

double numFreeOffsets(const Fit& fit) {
  double sum = 0;
  for (const FitBoard& board : fit.boards) sum += board.num_free_offsets + board.flex.num_free;
  return sum;
}

void fixShapes(Fit& fit) {
  for (FitBoard& board : fit.boards) board.is_shape_fixed = true;
}

std::size_t numCorners(const Fit& fit) {
  std::size_t count = 0;
  for (const FitView& view : fit.views) count += view.corners.size();
  return count;
}

Fit emptyFit(std::string model, ImageSize size, std::vector<double> params, std::span<const Board> boards,
             HuberLoss loss) {
  Fit fit{.loss = loss};
  fit.cameras.push_back({.model = std::move(model), .size = size, .params = std::move(params)});
  for (const Board& board : boards) fit.boards.push_back({.target = board});
  return fit;
}

Fit emptyFit(std::string model, ImageSize size, std::vector<double> params, const Board& board,
             HuberLoss loss) {
  return emptyFit(std::move(model), size, std::move(params), std::span(&board, 1), loss);
}

double cornersCost(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  return fit.summary.cost - camera.weak_prior.prior.cost(camera.params) - foldGuardCost(camera);
}

void addView(Fit& fit, std::size_t source, std::vector<Observation> corners, const SE3& camera_from_board,
             std::size_t board) {
  fit.placements.push_back({.frame = fit.placements.size(), .body = board});
  FitView view{.board = board,
               .placement = fit.placements.size() - 1,
               .source = source,
               .corners = std::move(corners)};
  setCameraFromBoard(fit, view, camera_from_board);
  const auto at = std::upper_bound(fit.views.begin(), fit.views.end(), source,
                                   [](std::size_t s, const FitView& other) { return s < other.source; });
  fit.views.insert(at, std::move(view));
}

Fit withoutViews(const Fit& fit, const std::vector<bool>& is_out) {
  constexpr std::size_t kGone = static_cast<std::size_t>(-1);
  Fit left{.cameras = fit.cameras, .boards = fit.boards, .loss = fit.loss, .summary = fit.summary};
  std::vector<std::size_t> placement_of(fit.placements.size(), kGone);
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    if (is_out[v]) continue;
    left.views.push_back(fit.views[v]);
    placement_of[fit.views[v].placement] = 0;
  }
  for (std::size_t p = 0; p < placement_of.size(); ++p) {
    if (placement_of[p] == kGone) continue;
    placement_of[p] = left.placements.size();
    left.placements.push_back(fit.placements[p]);
  }
  for (FitView& view : left.views) view.placement = placement_of[view.placement];
  return left;
}

Fit withoutView(const Fit& fit, std::size_t view) {
  std::vector<bool> is_out(fit.views.size());
  is_out[view] = true;
  return withoutViews(fit, is_out);
}

double updateWeights(Fit& fit) {
  double change = 0;
  for (FitView& view : fit.views) {
    for (Observation& corner : view.corners) {
      const double weight = fit.cameras[view.camera].noise.weight(corner.sigma_px);
      change = std::max(change, std::abs(weight / corner.weight - 1));
      corner.weight = weight;
    }
  }
  return change;
}

}  // namespace alidade
