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

}  // namespace

std::string_view obstacleId(StartObstacle obstacle) {
  constexpr std::array<std::string_view, 5> kIds = {"none", "few_points", "still", "rotation", "no_motion"};
  return kIds.at(static_cast<std::size_t>(obstacle));
}

PathStart::PathStart(const AnyCamera& camera, ImageSize size, const SightScale& scale)
    : camera_(camera), size_(size), scale_(scale), wanted_rad_(kStartShare * scale.key_rad) {}

std::optional<TwoView> PathStart::add(std::size_t index, std::span<const TrackPixel> tracks) {
  waiting_.push_back({index, {tracks.begin(), tracks.end()}});
  forgetUnconnected();
  return tryPair(wanted_rad_, kSureRad);
}

std::optional<TwoView> PathStart::lastChance() {
  constexpr double kLeast = 0.1;
  return waiting_.size() < 2 ? std::nullopt : tryPair(kLeast * scale_.key_rad, kMostSureRad);
}

bool PathStart::isCutOff(std::span<const TrackPixel> tracks) const {
  return !waiting_.empty() &&
         commonTracks(waiting_.back().tracks, {tracks.begin(), tracks.end()}).size() < kFewestShared;
}

void PathStart::reject() {
  obstacle_ = StartObstacle::kNoMotion;
  constexpr double kWider = 1.25;
  wanted_rad_ *= kWider;
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

std::nullopt_t PathStart::failed(StartObstacle obstacle) {
  obstacle_ = obstacle;
  return std::nullopt;
}

std::optional<TwoView> PathStart::tryPair(double least_rad, double sure_rad) {
  if (waiting_.size() < 2) return failed(StartObstacle::kFewPoints);
  const std::vector<TrackPixel>& a = waiting_.front().tracks;
  const std::vector<TrackPixel>& b = waiting_.back().tracks;
  std::vector<RayPair> rays;
  std::vector<double> moves;
  for (const auto& [i, j] : commonTracks(a, b)) {
    const auto ray_a = camera_.unproject(a[i].pixel);
    const auto ray_b = camera_.unproject(b[j].pixel);
    if (!ray_a || !ray_b) continue;
    rays.push_back({*ray_a, *ray_b});
    moves.push_back((a[i].pixel - b[j].pixel).norm());
  }
  if (rays.size() < kFewestShared) return failed(StartObstacle::kFewPoints);
  constexpr double kStillPx = 1;
  if (medianOf(std::move(moves)) < kStillPx) return failed(StartObstacle::kStill);
  if (parallaxAngle(rays) < least_rad) return failed(StartObstacle::kRotation);
  const std::vector<PixelMatch> matches = matchesOf(a, b);
  const TwoView motion = estimateTwoView(camera_, matches, size_, kPathSeed + waiting_.back().index);
  const bool is_motion = motion.kind == TwoViewKind::kGeneral || motion.kind == TwoViewKind::kPlane;
  const Eigen::Matrix3d covariance = motion.covariance.topLeftCorner<3, 3>();
  const bool is_sure = covariance.trace() < sure_rad * sure_rad;
  if (is_motion && is_sure && 2 * motion.num_inliers > matches.size()) return motion;
  reject();
  return motion.kind == TwoViewKind::kRotation ? failed(StartObstacle::kRotation) : std::nullopt;
}

}  // namespace alidade
