// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

struct PoseDistance {
  double rotation_rad = 0;
  double translation = 0;  // m

  // In a limit, the translation is a share of the distance to the board.
  [[nodiscard]] bool isWithin(const PoseDistance& limit, double distance_m) const {
    return rotation_rad < limit.rotation_rad && translation < limit.translation * distance_m;
  }
  [[nodiscard]] double cost(double distance_m) const { return rotation_rad + translation / distance_m; }
};

// Largest difference of poses that count as the same: single views are rough, grazing ones very rough.
constexpr PoseDistance kSame = {0.05, 0.05};
constexpr PoseDistance kPossible = {0.4, 0.3};  // the joint fit decides whether they are the same

PoseDistance between(const SE3& a, const SE3& b) {
  const SE3 difference = a.inverse() * b;
  return {.rotation_rad = difference.rotation.log().norm(), .translation = difference.translation.norm()};
}

// Poses of camera b relative to a by one frame: a candidate for each turn of the board.
struct FramePoses {
  std::vector<SE3> b_from_a;
  double distance_m = 0;  // to the board
};

struct Link {
  SE3 b_from_a = {};
  std::size_t num_frames = 0;
};

// The candidate of a frame nearest to a pose.
const SE3& nearest(const FramePoses& frame, const SE3& pose) {
  return *std::ranges::min_element(frame.b_from_a, {}, [&](const SE3& candidate) {
    return between(pose, candidate).cost(frame.distance_m);
  });
}

// A mean of the candidates, with weights that fall with their distance from it in units of the nearest
// quarter's distance: if the camera moved, candidates from before and after do not bias each other.
SE3 meanAround(SE3 pose, const std::vector<FramePoses>& frames) {
  constexpr int kRounds = 5;
  constexpr std::size_t kQuarter = 4;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> costs;
    for (const FramePoses& frame : frames)
      costs.push_back(between(pose, nearest(frame, pose)).cost(frame.distance_m));
    std::vector<double> sorted = costs;
    const auto quartile = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / kQuarter);
    std::ranges::nth_element(sorted, quartile);
    const double scale = std::max(*quartile, 1e-9);
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    double weights = 0;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      const double ratio = costs[f] / scale;
      const double weight = 1 / (1 + ratio * ratio * ratio * ratio);
      sum += weight * (pose.inverse() * nearest(frames[f], pose)).log();
      weights += weight;
    }
    pose = pose * SE3::exp(sum / weights);
  }
  return pose;
}

Link agreedPose(const std::vector<FramePoses>& frames) {
  constexpr std::size_t kMostTried = 60;  // if there are many frames, an even selection
  const std::size_t step = (frames.size() + kMostTried - 1) / kMostTried;
  Link best;
  double best_cost = std::numeric_limits<double>::max();
  for (std::size_t f = 0; f < frames.size(); f += step) {
    for (const SE3& candidate : frames[f].b_from_a) {
      std::size_t count = 0;
      double cost = 0;
      for (const FramePoses& frame : frames) {
        const PoseDistance distance = between(candidate, nearest(frame, candidate));
        if (!distance.isWithin(kSame, frame.distance_m)) continue;
        ++count;
        cost += distance.cost(frame.distance_m);
      }
      if (count < best.num_frames || (count == best.num_frames && cost >= best_cost)) continue;
      best = {.b_from_a = candidate, .num_frames = count};
      best_cost = cost;
    }
  }
  best.b_from_a = meanAround(best.b_from_a, frames);
  return best;
}

// Views of one board in one frame.
using Placements = std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>>;

Placements placementsOf(std::span<const PosedView> views) {
  Placements placements;
  for (std::size_t v = 0; v < views.size(); ++v) placements[{views[v].frame, views[v].board}].push_back(v);
  return placements;
}

using Links = std::map<std::pair<std::size_t, std::size_t>, Link>;

Links linksOf(std::span<const PosedView> views, const Placements& placements,
              const std::vector<std::vector<BoardTurn>>& turns) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<FramePoses>> poses;
  for (const auto& [place, of_place] : placements) {
    for (std::size_t i = 0; i < of_place.size(); ++i) {
      for (std::size_t k = i + 1; k < of_place.size(); ++k) {
        const PosedView* a = &views[of_place[i]];
        const PosedView* b = &views[of_place[k]];
        if (a->camera > b->camera) std::swap(a, b);
        FramePoses frame{.b_from_a = {},
                         .distance_m = std::max(a->camera_from_board.translation.norm(),
                                                b->camera_from_board.translation.norm())};
        for (const BoardTurn& turn : turns[place.second]) {
          frame.b_from_a.push_back(b->camera_from_board * turn.turned_from_board.inverse() *
                                   a->camera_from_board.inverse());
        }
        poses[{a->camera, b->camera}].push_back(std::move(frame));
      }
    }
  }
  Links links;
  for (const auto& [pair, frames] : poses) links[pair] = agreedPose(frames);
  return links;
}

// Reaches each camera of a part from the first one, along the links with most frames.
void placeCameras(std::size_t num_cameras, const Links& links, JointViews& start) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  start.part_of.assign(num_cameras, kNone);
  start.camera_from_rig.assign(num_cameras, SE3());
  for (std::size_t first = 0; first < num_cameras; ++first) {
    if (start.part_of[first] != kNone) continue;
    start.part_of[first] = start.num_parts;
    for (;;) {
      const Link* best = nullptr;
      std::pair<std::size_t, std::size_t> best_pair;
      for (const auto& [pair, link] : links) {
        const bool has_first = start.part_of[pair.first] == start.num_parts;
        const bool has_second = start.part_of[pair.second] == start.num_parts;
        if (has_first == has_second || (best != nullptr && link.num_frames <= best->num_frames)) continue;
        best = &link;
        best_pair = pair;
      }
      if (best == nullptr) break;
      const auto [a, b] = best_pair;
      if (start.part_of[a] == start.num_parts) {
        start.camera_from_rig[b] = best->b_from_a * start.camera_from_rig[a];
        start.part_of[b] = start.num_parts;
      } else {
        start.camera_from_rig[a] = best->b_from_a.inverse() * start.camera_from_rig[b];
        start.part_of[a] = start.num_parts;
      }
    }
    ++start.num_parts;
  }
}

// Numbers all views of a placement like its first one. With more than two, the majority decides.
void numberViews(std::span<const PosedView> views, const std::vector<std::size_t>& of_place,
                 const std::vector<BoardTurn>& turns, JointViews& start) {
  const auto rigFromBoard = [&](std::size_t v, const BoardTurn& turn) {
    return start.camera_from_rig[views[v].camera].inverse() * views[v].camera_from_board *
           turn.turned_from_board.inverse();
  };
  std::size_t most = 0;
  for (const std::size_t base : of_place) {
    const SE3 expected = rigFromBoard(base, turns.front());
    const double distance_m = views[base].camera_from_board.translation.norm();
    std::vector<std::size_t> turn_of;
    std::vector<bool> agrees;
    for (const std::size_t v : of_place) {
      const auto best = std::ranges::min_element(turns, {}, [&](const BoardTurn& turn) {
        return between(expected, rigFromBoard(v, turn)).cost(distance_m);
      });
      turn_of.push_back(static_cast<std::size_t>(best - turns.begin()));
      agrees.push_back(between(expected, rigFromBoard(v, *best)).isWithin(kPossible, distance_m));
    }
    const auto count = static_cast<std::size_t>(std::ranges::count(agrees, true));
    if (count <= most) continue;
    most = count;
    for (std::size_t i = 0; i < of_place.size(); ++i) {
      start.turn_of[of_place[i]] = turn_of[i];
      start.agrees[of_place[i]] = agrees[i];
    }
  }
}

using Frames = std::set<std::size_t>;

// True if a camera has separate views in several of these frames.
bool isToldApart(const Frames& frames, const Frames& of_camera) {
  return std::ranges::count_if(frames, [&](std::size_t frame) { return of_camera.contains(frame); }) > 1;
}

// For each board and frame: the first of the frames that count as one because the board did not move.
std::vector<std::vector<std::size_t>> firstFrames(const RigFrames& frames, std::span<const RigViews> given,
                                                  std::span<const Calibration> alone) {
  std::vector<std::vector<std::size_t>> all(alone.front().fit.boards.size(),
                                            std::vector<std::size_t>(frames.names.size()));
  for (std::size_t b = 0; b < all.size(); ++b) {
    std::vector<std::size_t>& first_of = all[b];
    std::iota(first_of.begin(), first_of.end(), 0);
    std::vector<Frames> together;  // for each frame that is the first of a group
    for (std::size_t frame = 0; frame < first_of.size(); ++frame) together.push_back({frame});
    std::vector<Frames> of_camera(alone.size());
    for (std::size_t c = 0; c < alone.size(); ++c) {
      const Fit& fit = alone[c].fit;
      for (const FitView& view : fit.views) {
        if (boardIndex(fit, view) == b) of_camera[c].insert(frames.frame_of[c][view.source]);
      }
    }
    for (std::size_t c = 0; c < alone.size(); ++c) {
      std::map<std::string, std::size_t> frame_of_image;
      for (std::size_t v = 0; v < given[c].views.size(); ++v)
        frame_of_image[given[c].views[v].image] = frames.frame_of[c][v];
      for (const RepeatedView& repeated : alone[c].dropped.repeated) {
        if (repeated.board != b) continue;
        const std::size_t one = first_of[frame_of_image.at(repeated.image)];
        const std::size_t other = first_of[frame_of_image.at(repeated.same_as)];
        if (one == other) continue;
        Frames both = together[one];
        both.insert(together[other].begin(), together[other].end());
        if (std::ranges::any_of(of_camera, [&](const Frames& own) { return isToldApart(both, own); }))
          continue;
        const std::size_t first = std::min(one, other);
        for (const std::size_t frame : both) first_of[frame] = first;
        together[first] = std::move(both);
      }
    }
  }
  return all;
}

}  // namespace

std::string partsText(std::span<const std::string> names, std::span<const std::size_t> part_of) {
  std::map<std::size_t, std::vector<std::string>> parts;
  for (std::size_t c = 0; c < names.size(); ++c) parts[part_of[c]].push_back(names[c]);
  return join(mapped(parts, [](const auto& part) { return join(part.second, ", "); }), " | ");
}

double poseCost(const SE3& a, const SE3& b, double distance_m) {
  return between(a, b).cost(distance_m);
}

JointViews jointViews(std::span<const Board> boards, const RigFrames& frames, std::span<const RigViews> given,
                      std::vector<Calibration> cameras) {
  JointViews all;
  all.alone = std::move(cameras);
  const std::vector<std::vector<std::size_t>> first_of = firstFrames(frames, given, all.alone);
  for (std::size_t c = 0; c < all.alone.size(); ++c) {
    const Calibration& alone = all.alone[c];
    all.sigma_px.push_back(std::max(alone.uncertainty.coordinate_sigma_px, kMinSigmaPx));
    for (const FitView& view : alone.fit.views) {
      all.poses.push_back({.camera = c,
                           .frame = first_of[boardIndex(alone.fit, view)][frames.frame_of[c][view.source]],
                           .board = boardIndex(alone.fit, view),
                           .camera_from_board = cameraFromBoard(alone.fit, view),
                           .view = &view});
    }
  }
  for (const Board& board : boards) all.turns.push_back(boardTurns(board));
  all.turn_of.resize(all.poses.size());
  all.agrees.resize(all.poses.size());
  const Placements placements = placementsOf(all.poses);
  placeCameras(all.alone.size(), linksOf(all.poses, placements, all.turns), all);
  for (const auto& [place, of_place] : placements)
    numberViews(all.poses, of_place, all.turns[place.second], all);
  return all;
}

}  // namespace alidade
