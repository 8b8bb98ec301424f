// SPDX-License-Identifier: MIT
#include "alidade/rig/exposure.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "alidade/adjust/noise/pose_deviations.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/median.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// A body's motion where it is in one placement, as tangents of rig_from_body per interval between frames.
struct Motion {
  Vector6d velocity = Vector6d::Zero();
  Vector6d acceleration = Vector6d::Zero();
  double doubt = 1;  // of the velocity, relative to that inside the path
};

using Placements = std::vector<std::vector<std::size_t>>;

// The placements of each body by their time in intervals: that of the frame, plus the delay of a camera that
// sees the body alone. Where views of a frame contradict each other, those that agree count.
std::vector<std::map<double, std::size_t>> pathsOf(const Fit& fit, const Placements& views,
                                                   std::span<const double> times) {
  std::vector<std::map<std::size_t, std::vector<std::size_t>>> frames(fit.boards.size());
  for (std::size_t p = 0; p < views.size(); ++p)
    frames[fit.placements[p].body][fit.placements[p].frame].push_back(p);
  std::vector<std::map<double, std::size_t>> paths(fit.boards.size());
  for (std::size_t b = 0; b < frames.size(); ++b) {
    for (const auto& [frame, placements] : frames[b]) {
      const std::size_t p =
          *std::ranges::max_element(placements, {}, [&](std::size_t at) { return views[at].size(); });
      const bool is_lone = views[p].size() == 1;
      if (is_lone && placements.size() > 1) continue;
      const double delay = is_lone ? fit.cameras[fit.views[views[p].front()].camera].delay : 0;
      const double time = times[frame] + delay;
      constexpr double kLeastStep = 0.1;  // between nodes
      const auto before = paths[b].empty() ? paths[b].end() : std::prev(paths[b].end());
      const bool is_near = before != paths[b].end() && time < before->first + kLeastStep;
      if (is_near && is_lone) continue;
      if (is_near) paths[b].erase(before);  // seen by one camera alone
      paths[b].emplace(time, p);
    }
  }
  return paths;
}

// The motions at the nodes of a path, by the steps to the nodes before and after, as a cubic through five of
// them: the velocity of a parabola is off by a sixth of the third derivative. At the ends, the acceleration
// is that next to them.
std::vector<Motion> motionsAlong(const std::vector<double>& times, const std::vector<SE3>& path) {
  std::vector<Motion> motions(path.size());
  std::vector<Vector6d> steps;  // per interval
  for (std::size_t i = 1; i < path.size(); ++i)
    steps.emplace_back((path[i - 1].inverse() * path[i]).log() / (times[i] - times[i - 1]));
  const std::size_t last = path.size() - 1;
  for (std::size_t i = 1; i < last; ++i) {
    const double both = times[i + 1] - times[i - 1];
    const double before = (times[i] - times[i - 1]) / both;
    motions[i] = {.velocity = (1 - before) * steps[i - 1] + before * steps[i],
                  .acceleration = 2 / both * (steps[i] - steps[i - 1])};
  }
  std::vector<Motion> corrected = motions;
  for (std::size_t i = 2; i + 1 < last; ++i) {
    const double area = (times[i] - times[i - 1]) * (times[i + 1] - times[i]);
    corrected[i].velocity -= area / 6 * (motions[i + 1].acceleration - motions[i - 1].acceleration) /
                             (times[i + 1] - times[i - 1]);
  }
  // With fewer nodes on one side, the third or the second derivative takes part in the error.
  for (const auto& [from_end, doubt] : {std::pair(1U, 2.0), std::pair(0U, 4.0)}) {
    corrected[std::min<std::size_t>(from_end, last)].doubt = doubt;
    corrected[last - std::min<std::size_t>(from_end, last)].doubt = doubt;
  }
  for (std::size_t i = 1; i <= last; ++i) {  // after a gap
    const double gap = std::max(1.0, times[i] - times[i - 1]);
    for (const std::size_t end : {i - 1, i}) corrected[end].doubt *= gap;
  }
  const std::size_t inner = last > 1 ? 1 : 0;
  corrected[0].acceleration = corrected[inner].acceleration;
  corrected[0].velocity = steps.front() - (times[1] - times[0]) / 2 * corrected[0].acceleration;
  corrected[last].acceleration = corrected[last - inner].acceleration;
  corrected[last].velocity =
      steps.back() + (times[last] - times[last - 1]) / 2 * corrected[last].acceleration;
  return corrected;
}

// The motions at all placements of boards that have placements in other frames.
std::vector<std::optional<Motion>> motionsOf(const Fit& fit, const Placements& views,
                                             std::span<const double> times) {
  std::vector<std::optional<Motion>> motions(fit.placements.size());
  constexpr double kLongestGap = 4;  // intervals; the motion across a longer one is unknown
  for (const auto& path : pathsOf(fit, views, times)) {
    for (auto node = path.begin(); node != path.end();) {
      std::vector<double> node_times;
      std::vector<SE3> poses;
      auto end = node;
      for (; end != path.end(); ++end) {
        if (!node_times.empty() && end->first > node_times.back() + kLongestGap) break;
        node_times.push_back(end->first);
        poses.push_back(fit.placements[end->second].rig_from_body);
      }
      if (poses.size() < 2) {
        node = end;
        continue;
      }
      for (const Motion& motion : motionsAlong(node_times, poses)) motions[(node++)->second] = motion;
    }
  }
  return motions;
}

// Median size of the translations and rotations of all velocities, per interval.
Eigen::Vector2d usualSpeeds(const std::vector<std::optional<Motion>>& motions) {
  std::vector<double> speeds;
  std::vector<double> turns;
  for (const auto& motion : motions) {
    if (!motion) continue;
    speeds.push_back(motion->velocity.head<3>().norm());
    turns.push_back(motion->velocity.tail<3>().norm());
  }
  if (speeds.empty()) return Eigen::Vector2d::Zero();
  return {medianOf(std::move(speeds)), medianOf(std::move(turns))};
}

// The effects of the scatter of a view: of its time along the board's velocity; and in all directions, for as
// long, half of the change of velocity between frames and a little of what is usual. A delay adds to this
// time, because the path is less certain farther from a frame.
Eigen::Matrix<double, 6, PoseDeviation::kSize> effectsOf(const Motion& motion, double delay,
                                                         const Eigen::Vector2d& usual,
                                                         const Scatter& scatter) {
  constexpr double kLeast = 0.1;  // of the usual speed
  constexpr double kOfDelay = 0.25;
  Eigen::Matrix<double, 6, PoseDeviation::kSize> effects =
      Eigen::Matrix<double, 6, PoseDeviation::kSize>::Zero();
  effects.col(0) = scatter.std_intervals * (motion.velocity + delay * motion.acceleration);
  const double time = motion.doubt * scatter.path * std::hypot(scatter.std_intervals, kOfDelay * delay);
  for (const Eigen::Index part : {0, 1}) {  // translation, rotation
    const double change = motion.acceleration.segment<3>(3 * part).norm() / 2;
    effects.block<3, 3>(3 * part, 1 + 3 * part)
        .diagonal()
        .setConstant(time * std::hypot(change, kLeast * usual(part)) / std::sqrt(3.0));
  }
  return effects;
}

}  // namespace

void followPaths(const Scatter& scatter, std::span<const double> times, Fit& fit) {
  const Placements placements = viewsOfPlacements(fit);
  const std::vector<std::optional<Motion>> motions = motionsOf(fit, placements, times);
  const Eigen::Vector2d usual = usualSpeeds(motions);
  std::vector<bool> is_seen(fit.cameras.size());
  for (std::size_t p = 0; p < placements.size(); ++p) {
    for (const std::size_t v : placements[p]) {
      FitView& view = fit.views[v];
      if (placements[p].size() < 2 || !motions[p] || !(usual.minCoeff() > 0)) {
        view.deviation.reset();
        continue;
      }
      const double delay = fit.cameras[view.camera].delay;
      const PoseDeviation::Normal normal = view.deviation.value_or(PoseDeviation()).normal;
      const Matrix6d to_board = boardOf(fit, view).tangentByBody();
      view.deviation = {.velocity = to_board * motions[p]->velocity,
                        .acceleration = to_board * motions[p]->acceleration,
                        .root = to_board * effectsOf(*motions[p], delay, usual, scatter),
                        .normal = normal};
      is_seen[view.camera] = true;
    }
  }
  for (std::size_t c = 1; c < fit.cameras.size(); ++c) {
    fit.cameras[c].is_delay_fixed = !is_seen[c];
    if (!is_seen[c]) fit.cameras[c].delay = 0;
  }
}

Scatter startDeviations(const std::vector<SE3>& rig_from_body, std::span<const double> times, Fit& fit) {
  followPaths({.std_intervals = 1, .path = 1}, times, fit);
  std::vector<double> sizes;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    for (const std::size_t v : of_placement) {
      if (v == of_placement.front() || !fit.views[v].deviation) continue;
      const auto& root = fit.views[v].deviation->root;
      const Vector6d apart = boardOf(fit, fit.views[v]).tangentByBody() *
                             (rig_from_body[of_placement.front()].inverse() * rig_from_body[v]).log();
      sizes.push_back(std::sqrt(apart.dot(solveSpd6(root * root.transpose(), apart)) / (2.0 * apart.size())));
    }
  }
  constexpr std::size_t kFewest = 8;  // pairs of views; a wrong one of a few would look like a delay
  if (sizes.size() < kFewest) return {};
  const Scatter scatter{.std_intervals = medianOf(std::move(sizes)), .path = 1};
  followPaths(scatter, times, fit);
  return scatter;
}

ExposureScatter exposureScatter(double std_intervals, const Fit& fit) {
  double num_views = 0;
  double num_corners = 0;
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();  // m^2, px^2
  for (const FitView& view : fit.views) {
    if (!view.deviation) continue;
    const Eigen::Vector3d& middle = boardOf(fit, view).target.middle();
    const SE3 change = SE3::exp(deviationTangent(fit, view));
    squares(0) += (change * middle - middle).squaredNorm();
    ++num_views;
    const FitCamera& camera = fit.cameras[view.camera];
    const AnyCamera lens = cameraOf(camera);
    const SE3 moved = cameraFromBoard(fit, view);
    const SE3 placed = moved * change.inverse();
    for (const Observation& corner : cornersOnShape(fit, view)) {
      const Projection before = lens.projectPoint(placed * corner.p_board);
      const Projection after = lens.projectPoint(moved * corner.p_board);
      if (!before.ok() || !after.ok()) continue;
      squares(1) += (after.pixel - before.pixel).squaredNorm();
      ++num_corners;
    }
  }
  return {.std_intervals = std_intervals,
          .shift_m = std::sqrt(squares(0) / std::max(1.0, num_views)),
          .shift_px = std::sqrt(squares(1) / std::max(1.0, num_corners))};
}

}  // namespace alidade
