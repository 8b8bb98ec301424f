// SPDX-License-Identifier: MIT
#include "alidade/rig/pair_link.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace alidade {
namespace {

constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max() / 2;

// Poses of camera b relative to a by one frame: a candidate for each turn of the board.
struct FramePoses {
  std::vector<SE3> b_from_a;
  double distance_m = 0;  // to the board
};

// Poses of the board before a camera with mirrored images. With markers, it is seen from behind; otherwise it
// looks like a board whose columns or rows are reversed.
std::vector<SE3> mirroredPoses(const SE3& camera_from_board, const Board& board) {
  const Eigen::DiagonalMatrix<double, 3> mirror(-1, 1, 1);
  std::vector<Eigen::Vector3d> flips = {{1, 1, -1}};
  if (!board.markers()) flips = {{-1, 1, 1}, {1, -1, 1}};
  std::vector<SE3> poses;
  for (const Eigen::Vector3d& flip : flips) {
    const Eigen::Vector3d middle = board.middle() - flip.cwiseProduct(board.middle());
    SE3& pose = poses.emplace_back();
    const Eigen::Matrix3d turned = mirror * camera_from_board.rotation.matrix() * flip.asDiagonal();
    pose.rotation = SO3::fromQuaternion(SO3::Quaternion(turned));
    pose.translation = mirror * (camera_from_board * middle);
  }
  return poses;
}

std::vector<FramePoses> framePoses(const std::vector<SharedBoard>& views, std::span<const LinkBoard> boards,
                                   bool is_mirrored) {
  std::vector<FramePoses> frames;
  for (const SharedBoard& view : views) {
    const LinkBoard& board = boards[view.board];
    FramePoses& frame = frames.emplace_back();
    frame.distance_m = std::max(view.a_from_board.translation.norm(), view.b_from_board.translation.norm());
    std::vector<SE3> b_from_board = {view.b_from_board};
    if (is_mirrored) b_from_board = mirroredPoses(view.b_from_board, board.board);
    for (const SE3& pose : b_from_board) {
      for (const BoardTurn& turn : board.turns)
        frame.b_from_a.push_back(pose * turn.turned_from_board.inverse() * view.a_from_board.inverse());
    }
  }
  return frames;
}

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

std::size_t strideFor(std::size_t count, std::size_t most) {
  return std::max<std::size_t>(1, (count + most - 1) / most);
}

// The pose on which most frames agree, and how well they do: from 0 to 1 for each frame.
struct PoseAgreement {
  SE3 b_from_a = {};
  std::size_t num_frames = 0;  // with the same pose
  double cost = std::numeric_limits<double>::max();
  double num_looked_at = 0;
  double mean = 0;
  double variance = 0;  // of the mean

  [[nodiscard]] double sum() const { return num_looked_at * mean; }
  // True if it is better by so much that chance does not explain it.
  [[nodiscard]] bool isClearlyBetterThan(const PoseAgreement& other) const {
    constexpr double kLeastMean = 0.3;
    constexpr double kSure = 5;  // standard deviations
    return mean > kLeastMean && mean - other.mean > kSure * std::sqrt(variance + other.variance);
  }
};

// @param num_tried  frames whose candidates are tried, evenly chosen
PoseAgreement poseAgreement(const std::vector<FramePoses>& frames, std::size_t num_tried) {
  const double limit = kSamePose.cost(1);
  const auto count = static_cast<double>(frames.size());
  PoseAgreement best;
  for (std::size_t f = 0; f < frames.size(); f += strideFor(frames.size(), num_tried)) {
    for (const SE3& candidate : frames[f].b_from_a) {
      PoseAgreement found{.b_from_a = candidate, .cost = 0, .num_looked_at = count};
      double squares = 0;
      for (const FramePoses& frame : frames) {
        const PoseDistance distance = between(candidate, nearest(frame, candidate));
        const double cost = distance.cost(frame.distance_m);
        const double agreement = std::max(0.0, 1 - cost / limit);
        found.mean += agreement / count;
        squares += agreement * agreement / count;
        if (!distance.isWithin(kSamePose, frame.distance_m)) continue;
        ++found.num_frames;
        found.cost += cost;
      }
      if (found.num_frames < best.num_frames ||
          (found.num_frames == best.num_frames && found.cost >= best.cost))
        continue;
      found.variance = (squares - found.mean * found.mean) / count;
      best = found;
    }
  }
  return best;
}

// The search for the time of one camera minus that of another.
class LagSearch {
 public:
  LagSearch(const Tracks& a, const Tracks& b, std::span<const LinkBoard> boards)
      : a_(a), b_(b), boards_(boards) {}

  // Views at the times of the first camera, with the second one's poses later by `lag`, interpolated.
  // @param most  evenly chosen
  [[nodiscard]] std::vector<SharedBoard> viewsAt(double lag, std::size_t most) const {
    const auto whole = static_cast<std::int64_t>(std::floor(lag));
    const double rest = lag - std::floor(lag);
    std::vector<Sighting> all;
    for (const auto& [board, track] : a_) {
      const auto other = b_.find(board);
      if (other == b_.end()) continue;
      auto at = other->second.begin();
      for (const auto& node : track) {
        while (at != other->second.end() && at->first < node.first + whole) ++at;
        if (at == other->second.end()) break;
        const bool is_last = at + 1 == other->second.end() || (at + 1)->first != at->first + 1;
        if (at->first == node.first + whole && (rest == 0 || !is_last))
          all.push_back({.a_from_board = &node.second, .b = &*at, .board = board});
      }
    }
    std::vector<SharedBoard> views;
    for (std::size_t i = 0; i < all.size(); i += strideFor(all.size(), most)) {
      SE3 pose = all[i].b->second;
      if (rest > 0) pose = pose * SE3::exp(rest * (pose.inverse() * (all[i].b + 1)->second).log());
      views.push_back({.a_from_board = *all[i].a_from_board, .b_from_board = pose, .board = all[i].board});
    }
    return views;
  }

  // The lag at which most frames agree on one pose; 0 unless they agree clearly better than without, and the
  // boards move.
  [[nodiscard]] double find() const {
    constexpr double kStep = 0.5;
    constexpr std::size_t kRough = 48;
    const double last = longest();
    Sums sums;
    for (double lag = -last; lag <= last; lag += kStep) {
      const std::vector<SharedBoard> views = viewsAt(lag, kRough);
      if (views.size() >= kFewest) sums.emplace_back(lag, agreementOf(views).sum());
    }
    if (sums.empty()) return 0;
    double best = peakOf(sums)->first;
    for (const double step : {kStep / 4, kStep / 16}) {
      sums.clear();
      for (int k = -4; k <= 4; ++k) sums.emplace_back(best + k * step, agreementAt(best + k * step).sum());
      best = peakOf(sums)->first;
    }
    constexpr double kLeastMean = 0.6;
    const PoseAgreement found = agreementAt(best);
    const bool is_clear = found.mean > kLeastMean && found.isClearlyBetterThan(agreementAt(0));
    return is_clear && isMoving(viewsAt(best, kAll)) ? best : 0;
  }

  static constexpr std::size_t kFewest = 8;  // common views

 private:
  static constexpr std::size_t kTried = 8;
  using Sums = std::vector<std::pair<double, double>>;  // by lag
  static Sums::const_iterator peakOf(const Sums& sums) {
    return std::ranges::max_element(sums, {}, &Sums::value_type::second);
  }
  // Poses of boards that hardly move agree at all lags.
  static bool isMoving(const std::vector<SharedBoard>& views) {
    const SharedBoard& middle = views[views.size() / 2];
    const auto count = std::ranges::count_if(views, [&](const SharedBoard& view) {
      const double distance_m = view.a_from_board.translation.norm();
      return view.board != middle.board ||
             between(middle.a_from_board, view.a_from_board).cost(distance_m) > 2 * kSamePose.cost(1);
    });
    return 2 * static_cast<std::size_t>(count) > views.size();
  }
  [[nodiscard]] PoseAgreement agreementOf(const std::vector<SharedBoard>& views) const {
    return poseAgreement(framePoses(views, boards_, false), kTried);
  }
  [[nodiscard]] PoseAgreement agreementAt(double lag) const { return agreementOf(viewsAt(lag, kAll)); }

  struct Sighting {
    const SE3* a_from_board;
    const Track::value_type* b;
    std::size_t board;
  };

  // The largest lag with a common frame.
  [[nodiscard]] double longest() const {
    std::int64_t result = 0;
    for (const auto& [board, track] : a_) {
      const auto other = b_.find(board);
      if (other == b_.end()) continue;
      result = std::max({result, other->second.back().first - track.front().first,
                         track.back().first - other->second.front().first});
    }
    return static_cast<double>(result);
  }

  const Tracks& a_;
  const Tracks& b_;
  std::span<const LinkBoard> boards_;
};

}  // namespace

PoseDistance between(const SE3& a, const SE3& b) {
  const SE3 difference = a.inverse() * b;
  return {.rotation_rad = difference.rotation.log().norm(), .translation = difference.translation.norm()};
}

std::optional<PairLink> linkOf(const std::vector<SharedBoard>& views, const Tracks& a, const Tracks& b,
                               std::span<const LinkBoard> boards) {
  constexpr std::size_t kMostTried = 60;
  const LagSearch search(a, b, boards);
  PairLink link{.lag = search.find()};
  const std::vector<SharedBoard> common = std::round(link.lag) == 0 ? views : search.viewsAt(link.lag, kAll);
  if (common.empty()) return std::nullopt;
  std::vector<FramePoses> frames = framePoses(common, boards, false);
  PoseAgreement agreement = poseAgreement(frames, kMostTried);
  if (common.size() >= LagSearch::kFewest && 2 * agreement.num_frames < common.size()) {
    std::vector<FramePoses> mirrored = framePoses(common, boards, true);
    const PoseAgreement other = poseAgreement(mirrored, kMostTried);
    link.is_mirrored = other.isClearlyBetterThan(agreement);
    if (link.is_mirrored) {
      frames = std::move(mirrored);
      agreement = other;
    }
  }
  link.num_frames = agreement.num_frames;
  link.b_from_a = meanAround(agreement.b_from_a, frames);
  return link;
}

}  // namespace alidade
