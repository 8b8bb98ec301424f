// SPDX-License-Identifier: MIT
#include "alidade/footage/map/path_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "alidade/core/median.h"

namespace alidade {
namespace {

constexpr std::size_t kFewestShared = 30;  // tracks
// Parallax required in the first and the last trial, in units of SightScale::key_rad.
constexpr double kStartShare = 0.25;
constexpr double kMostShare = 4;
// Largest standard deviation of the direction of motion; the second applies if no better pair will come.
constexpr double kSureRad = 0.02;
constexpr double kMostSureRad = 0.06;
constexpr std::size_t kMostWaiting = 600;  // frames, a bound for the memory

// The tracks of two frames that have rays.
struct SharedRays {
  std::vector<RayPair> rays;
  double moved_px = 0;  // median
};

SharedRays sharedRays(const AnyCamera& camera, const std::vector<TrackPixel>& a,
                      const std::vector<TrackPixel>& b) {
  SharedRays shared;
  std::vector<double> moves;
  for (const auto& [i, j] : commonTracks(a, b)) {
    const auto ray_a = camera.unproject(a[i].pixel);
    const auto ray_b = camera.unproject(b[j].pixel);
    if (!ray_a || !ray_b) continue;
    shared.rays.push_back({*ray_a, *ray_b});
    moves.push_back((a[i].pixel - b[j].pixel).norm());
  }
  if (!moves.empty()) shared.moved_px = medianOf(std::move(moves));
  return shared;
}

}  // namespace

std::string_view obstacleId(StartObstacle obstacle) {
  constexpr std::array<std::string_view, 5> kIds = {"none", "few_points", "still", "rotation", "no_motion"};
  return kIds.at(static_cast<std::size_t>(obstacle));
}

PathStart::PathStart(const AnyCamera& camera, ImageSize size, const SightScale& scale, std::uint64_t seed)
    : camera_(camera), size_(size), scale_(scale), seed_(seed), wanted_rad_(kStartShare * scale.key_rad) {}

std::optional<StartingPair> PathStart::add(std::size_t index, std::span<const TrackPixel> tracks) {
  waiting_.push_back({index, {tracks.begin(), tracks.end()}});
  forgetUnconnected();
  return tryPair(wanted_rad_, kSureRad);
}

std::optional<StartingPair> PathStart::lastChance() {
  constexpr double kLeast = 0.1;
  return waiting_.size() < 2 ? std::nullopt : tryPair(kLeast * scale_.key_rad, kMostSureRad);
}

bool PathStart::isCutOff(std::span<const TrackPixel> tracks) const {
  return !waiting_.empty() &&
         commonTracks(waiting_.back().tracks, {tracks.begin(), tracks.end()}).size() < kFewestShared;
}

void PathStart::reject() {
  obstacle_ = StartObstacle::kNoMotion;
  constexpr double kMore = 1.25;
  wanted_rad_ *= kMore;
  if (wanted_rad_ > kMostShare * scale_.key_rad) wanted_rad_ = kStartShare * scale_.key_rad;
}

// The oldest frame is one half of the pair, so it must share enough points with the newest.
void PathStart::forgetUnconnected() {
  // Descriptors match fewer of an image's points than flow does.
  constexpr double kShared = 0.4;
  constexpr double kSurely = 60;
  const std::vector<TrackPixel>& newest = waiting_.back().tracks;
  while (waiting_.size() > 1) {
    const std::vector<TrackPixel>& oldest = waiting_.front().tracks;
    const std::size_t num_shared = commonTracks(oldest, newest).size();
    if (num_shared >= kFewestShared &&
        static_cast<double>(num_shared) >= std::min(kSurely, kShared * static_cast<double>(oldest.size())))
      break;
    earlier_.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
    wanted_rad_ = kStartShare * scale_.key_rad;
  }
  while (earlier_.size() > kMostWaiting) earlier_.pop_front();
  if (waiting_.size() > kMostWaiting) waiting_.erase(waiting_.begin() + 1);
}

std::optional<StartingPair> PathStart::tryPair(double least_rad, double sure_rad) {
  if (waiting_.size() < 2) {
    obstacle_ = StartObstacle::kFewPoints;
    return std::nullopt;
  }
  const std::vector<TrackPixel>& a = waiting_.front().tracks;
  const std::vector<TrackPixel>& b = waiting_.back().tracks;
  const SharedRays shared = sharedRays(camera_, a, b);
  if (shared.rays.size() < kFewestShared) {
    obstacle_ = StartObstacle::kFewPoints;
    return std::nullopt;
  }
  constexpr double kStillPx = 1;
  if (shared.moved_px < kStillPx) {
    obstacle_ = StartObstacle::kStill;
    return std::nullopt;
  }
  if (parallaxAngle(shared.rays) < least_rad) {
    obstacle_ = StartObstacle::kRotation;
    return std::nullopt;
  }
  StartingPair pair{.a = 0, .b = waiting_.size() - 1, .motion = {}, .tracks = {}};
  const std::vector<PixelMatch> matches = matchesOf(a, b, pair.tracks);
  pair.motion = estimateTwoView(
      camera_, matches,
      {.threshold_px = scale_.threshold_px, .seed = seed_ + waiting_.back().index, .size = size_});
  const bool is_motion = pair.motion.kind == TwoViewKind::kGeneral || pair.motion.kind == TwoViewKind::kPlane;
  const Eigen::Matrix3d covariance = pair.motion.covariance.topLeftCorner<3, 3>();
  const bool is_sure = covariance.trace() < sure_rad * sure_rad;
  if (is_motion && is_sure && 2 * pair.motion.num_inliers > matches.size()) return pair;
  reject();
  if (pair.motion.kind == TwoViewKind::kRotation) obstacle_ = StartObstacle::kRotation;
  return std::nullopt;
}

}  // namespace alidade
