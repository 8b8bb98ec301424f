// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_start.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
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
  double lag = 0;  // time of b minus that of a at one instant, in intervals between frames
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

FramePoses framePoses(const SE3& a_from_board, const SE3& b_from_board, const std::vector<BoardTurn>& turns) {
  FramePoses frame{.b_from_a = {},
                   .distance_m = std::max(a_from_board.translation.norm(), b_from_board.translation.norm())};
  for (const BoardTurn& turn : turns)
    frame.b_from_a.push_back(b_from_board * turn.turned_from_board.inverse() * a_from_board.inverse());
  return frame;
}

// How well frames agree on one pose of two cameras: from 0 to 1 for each frame.
struct Agreement {
  double sum = 0;
  double mean = 0;
  double variance = 0;  // of the mean
};

// @param most  frames that are looked at, evenly chosen
Agreement agreementOf(const std::vector<FramePoses>& frames, std::size_t most) {
  constexpr std::size_t kTried = 8;
  const double limit = kSame.cost(1);
  const std::size_t step = (frames.size() + most - 1) / most;
  const std::size_t step_tried = (frames.size() + kTried - 1) / kTried;
  Agreement best;
  for (std::size_t f = 0; f < frames.size(); f += step_tried) {
    for (const SE3& candidate : frames[f].b_from_a) {
      double count = 0;
      double sum = 0;
      double squares = 0;
      for (std::size_t i = 0; i < frames.size(); i += step) {
        const double cost = between(candidate, nearest(frames[i], candidate)).cost(frames[i].distance_m);
        const double agreement = std::max(0.0, 1 - cost / limit);
        sum += agreement;
        squares += agreement * agreement;
        ++count;
      }
      const double mean = sum / count;
      if (mean <= best.mean) continue;
      best = {.sum = mean * static_cast<double>(frames.size()),
              .mean = mean,
              .variance = (squares / count - mean * mean) / count};
    }
  }
  return best;
}

// The poses of one board before a camera, by time in intervals.
class Track {
 public:
  void add(std::int64_t time, const SE3& camera_from_board) { poses_.emplace(time, camera_from_board); }

  // Interpolated between successive frames, by a cubic if those before and after them are known too.
  [[nodiscard]] std::optional<SE3> at(double time) const {
    const double before = std::floor(time);
    const auto start = static_cast<std::int64_t>(before);
    const auto from = poses_.find(start);
    if (from == poses_.end()) return std::nullopt;
    const double t = time - before;
    if (t == 0) return from->second;
    const auto to = std::next(from);
    if (to == poses_.end() || to->first != start + 1) return std::nullopt;
    const SE3::Tangent step = (from->second.inverse() * to->second).log();
    SE3::Tangent moved = t * step;
    const auto after = std::next(to);
    if (from != poses_.begin() && std::prev(from)->first == start - 1 && after != poses_.end() &&
        after->first == start + 2) {
      const SE3::Tangent step_before = (std::prev(from)->second.inverse() * from->second).log();
      const SE3::Tangent step_after = (to->second.inverse() * after->second).log();
      const double rest = 1 - t;
      moved += t * rest / 2 * (t * (step - step_after) - rest * (step - step_before));
    }
    return from->second * SE3::exp(moved);
  }
  [[nodiscard]] const std::map<std::int64_t, SE3>& poses() const { return poses_; }

 private:
  std::map<std::int64_t, SE3> poses_;
};

using Tracks = std::map<std::size_t, Track>;  // by board

// The tracks before each camera; none unless the frames are evenly spaced, except for gaps.
std::vector<Tracks> tracksOf(std::span<const PosedView> views, const RigFrames& frames,
                             std::size_t num_cameras) {
  constexpr double kEven = 0.1;
  constexpr double kMostTime = 1e5;
  const bool is_even = frames.step > 0 && frames.time_spread == 0 && frames.times.back() < kMostTime &&
                       std::ranges::all_of(frames.times, [](double time) {
                         return std::abs(time - std::round(time)) < kEven;
                       });
  std::vector<Tracks> tracks(num_cameras);
  if (!is_even) return tracks;
  for (const PosedView& view : views)
    tracks[view.camera][view.board].add(std::llround(frames.times[view.frame]), view.camera_from_board);
  return tracks;
}

// The search for the time by which one camera is ahead of another.
class LagSearch {
 public:
  LagSearch(const Tracks& a, const Tracks& b, const std::vector<std::vector<BoardTurn>>& turns)
      : a_(a), b_(b), turns_(turns) {}

  // The frames of the first camera, with the second one's poses later by `lag`.
  [[nodiscard]] std::vector<FramePoses> framesAt(double lag) const {
    std::vector<FramePoses> frames;
    for (const auto& [board, track] : a_) {
      const auto other = b_.find(board);
      if (other == b_.end()) continue;
      for (const auto& [time, pose] : track.poses()) {
        if (const auto later = other->second.at(static_cast<double>(time) + lag))
          frames.push_back(framePoses(pose, *later, turns_[board]));
      }
    }
    return frames;
  }

  // The lag at which most frames agree on one pose; 0 unless they agree clearly better than without.
  [[nodiscard]] double find() const {
    constexpr double kStep = 0.25;
    constexpr std::size_t kRough = 48;
    const auto [first, last] = range();
    double best_lag = 0;
    double most = 0;
    const auto consider = [&](double lag, std::size_t num_looked_at) {
      const std::vector<FramePoses> frames = framesAt(lag);
      if (frames.size() < kFewest) return;
      const double sum = agreementOf(frames, num_looked_at).sum;
      if (sum <= most) return;
      most = sum;
      best_lag = lag;
    };
    for (double lag = first; lag <= last; lag += kStep) consider(lag, kRough);
    most = 0;
    for (const double step : {kStep / 4, kStep / 16}) {
      const double middle = best_lag;
      for (int k = -4; k <= 4; ++k) consider(middle + k * step, kAll);
    }
    return isBetter(best_lag) ? best_lag : 0;
  }

 private:
  static constexpr std::size_t kFewest = 8;
  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max() / 2;

  // The first and last lag with a common frame.
  [[nodiscard]] std::pair<double, double> range() const {
    std::pair<double, double> result = {0, 0};
    for (const auto& [board, track] : a_) {
      const auto other = b_.find(board);
      if (other == b_.end()) continue;
      const auto& a = track.poses();
      const auto& b = other->second.poses();
      result.first = std::min(result.first, static_cast<double>(b.begin()->first - a.rbegin()->first));
      result.second = std::max(result.second, static_cast<double>(b.rbegin()->first - a.begin()->first));
    }
    return result;
  }

  [[nodiscard]] bool isBetter(double lag) const {
    constexpr double kLeastMean = 0.3;
    constexpr double kSure = 5;  // standard deviations
    const std::vector<FramePoses> frames = framesAt(0);
    const Agreement without = frames.empty() ? Agreement() : agreementOf(frames, kAll);
    const Agreement with = agreementOf(framesAt(lag), kAll);
    return with.sum > without.sum && with.mean > kLeastMean &&
           with.mean - without.mean > kSure * std::sqrt(with.variance + without.variance);
  }

  const Tracks& a_;
  const Tracks& b_;
  const std::vector<std::vector<BoardTurn>>& turns_;
};

Links linksOf(std::span<const PosedView> views, const Placements& placements,
              const std::vector<std::vector<BoardTurn>>& turns, const std::vector<Tracks>& tracks) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<FramePoses>> poses;
  for (const auto& [place, of_place] : placements) {
    for (std::size_t i = 0; i < of_place.size(); ++i) {
      for (std::size_t k = i + 1; k < of_place.size(); ++k) {
        const PosedView* a = &views[of_place[i]];
        const PosedView* b = &views[of_place[k]];
        if (a->camera > b->camera) std::swap(a, b);
        poses[{a->camera, b->camera}].push_back(
            framePoses(a->camera_from_board, b->camera_from_board, turns[place.second]));
      }
    }
  }
  Links links;
  for (std::size_t b = 1; b < tracks.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const LagSearch search(tracks[a], tracks[b], turns);
      const double lag = search.find();
      const std::vector<FramePoses>& frames = std::round(lag) == 0 ? poses[{a, b}] : search.framesAt(lag);
      if (frames.empty()) continue;
      links[{a, b}] = agreedPose(frames);
      links[{a, b}].lag = lag;
    }
  }
  return links;
}

// Reaches each camera of a part from the first one, along the links with most frames.
void placeCameras(std::size_t num_cameras, const Links& links, JointViews& start) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  start.part_of.assign(num_cameras, kNone);
  start.camera_from_rig.assign(num_cameras, SE3());
  start.lags.assign(num_cameras, 0);
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
        start.lags[b] = start.lags[a] + best->lag;
      } else {
        start.camera_from_rig[a] = best->b_from_a.inverse() * start.camera_from_rig[b];
        start.part_of[a] = start.num_parts;
        start.lags[a] = start.lags[b] - best->lag;
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
  all.times = frames.times;
  const std::vector<Tracks> tracks = tracksOf(all.poses, frames, all.alone.size());
  placeCameras(all.alone.size(), linksOf(all.poses, placements, all.turns, tracks), all);
  for (const auto& [place, of_place] : placements)
    numberViews(all.poses, of_place, all.turns[place.second], all);
  return all;
}

}  // namespace alidade
