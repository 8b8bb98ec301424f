// SPDX-License-Identifier: MIT
#include "alidade/footage/map/local_map.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "alidade/core/median.h"
#include "alidade/footage/geometry/resection.h"
#include "alidade/footage/geometry/two_view.h"
#include "alidade/footage/map/reconstruction.h"

namespace alidade {
namespace {

constexpr std::size_t kFewestAgreeing = 20;  // points for a pose
constexpr std::size_t kFewPlaced = 60;       // points, below which those of unknown distance help
constexpr int kMostMisses = 3;
constexpr int kMostFailures = 3;
constexpr std::size_t kIgnoredFrames = 60;  // before a failed track is tried again
constexpr std::size_t kProven = 4;          // key frames, after which earlier failures are forgotten
constexpr std::size_t kMostAdjusted = 300;  // points
constexpr std::size_t kWindow = 7;          // key frames that are adjusted together

double angleOf(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Eigen::Vector3d centreOf(const SE3& camera_from_world) {
  return camera_from_world.inverse().translation;
}

// Pixels per radian about the axis; if that has no pixel, from the mean of the focal lengths.
double resolutionOf(const AnyCamera& camera) {
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
  if (camera.project(Eigen::Vector3d(0, 0, 1), J_px_cam.data()).ok()) {
    const double area = std::abs(J_px_cam(0, 0) * J_px_cam(1, 1) - J_px_cam(0, 1) * J_px_cam(1, 0));
    if (area > 0) return std::sqrt(area);
  }
  return 0.5 * (camera.parameters()[0] + camera.parameters()[1]);
}

}  // namespace

SightScale::SightScale(const AnyCamera& camera, ImageSize size) {
  threshold_px = agreementPx(size);
  px_per_rad = resolutionOf(camera);
  constexpr double kKeyShare = 0.04;  // of the width
  constexpr double kLeastShare = 0.01;
  key_rad = kKeyShare * size.width / px_per_rad;
  least_rad = kLeastShare * size.width / px_per_rad;
}

void LocalMap::setPoint(std::uint32_t track, const Eigen::Vector4d& at) {
  Point& point = points_[track];
  point.at = at;
  point.is_placed = true;
}

const LocalMap::Point* LocalMap::find(std::uint32_t track) const {
  const auto found = points_.find(track);
  return found != points_.end() ? &found->second : nullptr;
}

bool LocalMap::isOfUse(const Point& point) const {
  return now_ >= point.ignored_until && (window_.empty() || point.last_frame >= window_.front().frame);
}

std::optional<PlacedFrame> LocalMap::place(std::span<const TrackPixel> tracks, const SE3& guess,
                                           std::size_t frame) {
  now_ = std::max(now_, frame);
  std::vector<KnownPoint> known;
  std::vector<std::uint32_t> ids;
  const auto add = [&](const TrackPixel& at, const Eigen::Vector4d& place, double sigma_px) {
    known.push_back({place, at.pixel, sigma_px});
    ids.push_back(at.track);
  };
  for (const TrackPixel& at : tracks) {
    const Point* point = find(at.track);
    if (point != nullptr && point->is_placed && isOfUse(*point)) add(at, point->at, at.sigma_px);
  }
  const std::size_t num_placed = known.size();
  if (num_placed < kFewPlaced) {
    // Points of unknown distance determine the camera's rotation as long as it stays near the place from
    // which they were first seen. They are assumed to be as far away as the others.
    constexpr double kMostDoubt = 2;
    const Eigen::Vector3d centre = centreOf(guess);
    for (const TrackPixel& at : tracks) {
      const Point* point = find(at.track);
      if (point == nullptr || point->is_placed || !isOfUse(*point) || point->direction.isZero()) continue;
      const double doubt_px = scale_.px_per_rad * (centre - point->anchor).norm() / depth_;
      if (doubt_px > kMostDoubt * scale_.threshold_px) continue;
      Eigen::Vector4d assumed;
      assumed << point->anchor + depth_ * point->direction, 1;
      add(at, assumed.normalized(), std::hypot(at.sigma_px, doubt_px));
    }
  }
  if (known.size() < kFewestAgreeing) return std::nullopt;
  const auto isEnough = [&](const std::optional<Resection>& pose) {
    return pose && pose->num_inliers >= kFewestAgreeing && 2 * pose->num_inliers > known.size();
  };
  auto pose = refinedPose(camera_, known, guess, scale_.threshold_px);
  if (!isEnough(pose)) {
    // Uses a wide threshold first, then the normal one.
    constexpr double kFarther = 10;
    pose = refinedPose(camera_, known, guess, kFarther * scale_.threshold_px);
    if (pose) pose = refinedPose(camera_, known, pose->camera_from_world, scale_.threshold_px);
  }
  if (!isEnough(pose) && num_placed >= kFewestAgreeing)
    pose = resect(camera_, known, std::nullopt, scale_.threshold_px, kPathSeed + frame);
  if (!isEnough(pose)) return std::nullopt;
  PlacedFrame placed{.camera_from_world = pose->camera_from_world};
  for (std::size_t i = 0; i < known.size(); ++i) {
    Point& point = points_.at(ids[i]);
    if (!pose->is_inlier[i]) {
      if (i < num_placed && ++point.num_misses >= kMostMisses) giveUp(point);
      continue;
    }
    point.num_misses = 0;
    if (point.num_keys >= kProven) point.num_failures = 0;
    point.last_frame = std::max(point.last_frame, frame);
    placed.num_points += i < num_placed ? 1 : 0;
    placed.num_distant += i < num_placed ? 0 : 1;
    placed.squared_error_px2 +=
        std::pow(errorOf(camera_, placed.camera_from_world, known[i].point, known[i].pixel), 2);
  }
  return placed;
}

std::optional<PlacedFrame> LocalMap::relocate(std::span<const TrackPixel> tracks, std::size_t frame) {
  now_ = std::max(now_, frame);
  std::vector<KnownPoint> known;
  for (const TrackPixel& at : tracks) {
    const Point* point = find(at.track);
    if (point == nullptr || !point->is_placed || now_ < point->ignored_until) continue;
    known.push_back({point->at, at.pixel, at.sigma_px});
  }
  constexpr std::size_t kFewest = 2 * kFewestAgreeing;
  if (known.size() < kFewest) return std::nullopt;
  const auto pose = resect(camera_, known, std::nullopt, scale_.threshold_px, kPathSeed + frame);
  if (!pose || pose->num_inliers < kFewest || 2 * pose->num_inliers < known.size()) return std::nullopt;
  for (const TrackPixel& at : tracks) {
    const auto found = points_.find(at.track);
    if (found == points_.end() || !found->second.is_placed) continue;
    found->second.last_frame = frame;
    found->second.num_misses = 0;
  }
  return place(tracks, pose->camera_from_world, frame);
}

// Treats the track as a different point from now on.
void LocalMap::giveUp(Point& point) {
  point.is_placed = false;
  point.is_far = false;
  point.num_misses = 0;
  point.num_keys = 0;
  point.direction.setZero();
  if (++point.num_failures < kMostFailures) return;
  point.num_failures = 0;
  point.ignored_until = now_ + kIgnoredFrames;
}

void LocalMap::addKeyFrame(std::size_t frame, std::span<const TrackPixel> tracks,
                           const SE3& camera_from_world) {
  now_ = std::max(now_, frame);
  KeyFrame& key = window_.emplace_back();
  key.frame = frame;
  key.camera_from_world = camera_from_world;
  key.tracks.assign(tracks.begin(), tracks.end());
  const SE3 world_from_camera = camera_from_world.inverse();
  for (const TrackPixel& at : tracks) {
    const auto ray = camera_.unproject(at.pixel);
    key.rays.push_back(ray);
    Point& point = points_[at.track];
    key.is_used.push_back(ray && now_ >= point.ignored_until ? 1 : 0);
    if (key.is_used.back() == 0) continue;
    if (point.is_placed &&
        !(errorOf(camera_, camera_from_world, point.at, at.pixel) < 2 * scale_.threshold_px)) {
      key.is_used.back() = 0;
      continue;
    }
    point.last_frame = frame;
    ++point.num_keys;
    if (!point.direction.isZero()) continue;
    point.anchor = world_from_camera.translation;
    point.direction = world_from_camera.rotation * *ray;
  }
  ++num_keys_;
  poses_[frame] = camera_from_world;
  while (window_.size() > kWindow) window_.pop_front();
}

void LocalMap::settle() {
  if (window_.size() >= 2) {
    for (const auto& [track, sightings] : sightingsInWindow()) {
      if (sightings.size() >= 2 && !points_.at(track).is_placed) triangulate(track, sightings);
    }
  }
  adjust();
  measureDepth();
}

std::map<std::uint32_t, LocalMap::Sightings> LocalMap::sightingsInWindow() const {
  std::map<std::uint32_t, Sightings> sightings;
  for (std::size_t k = 0; k < window_.size(); ++k) {
    for (std::size_t i = 0; i < window_[k].tracks.size(); ++i) {
      if (window_[k].is_used[i] != 0) sightings[window_[k].tracks[i].track].emplace_back(k, i);
    }
  }
  return sightings;
}

double LocalMap::widestAngle(const Sightings& sightings) const {
  std::vector<Eigen::Vector3d> directions;
  for (const auto& [k, i] : sightings)
    directions.emplace_back(window_[k].camera_from_world.rotation.inverse() * *window_[k].rays[i]);
  double widest = 0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (std::size_t j = i + 1; j < directions.size(); ++j)
      widest = std::max(widest, angleOf(directions[i], directions[j]));
  }
  return widest;
}

void LocalMap::triangulate(std::uint32_t track, const Sightings& sightings) {
  Point& point = points_.at(track);
  std::vector<SE3> poses;
  std::vector<Eigen::Vector3d> rays;
  double reach = 0;  // of the camera
  const Eigen::Vector3d first = centreOf(window_[sightings.front().first].camera_from_world);
  for (const auto& [k, i] : sightings) {
    poses.push_back(window_[k].camera_from_world);
    rays.push_back(*window_[k].rays[i]);
    reach = std::max(reach, (centreOf(poses.back()) - first).norm());
  }
  const double angle = widestAngle(sightings);
  // A point at the usual distance would have shown several times the needed parallax.
  constexpr double kSurely = 3;
  const bool is_far = angle < scale_.least_rad && reach / depth_ > kSurely * scale_.least_rad;
  if (angle < scale_.least_rad && !is_far) return;
  Eigen::Vector4d at = pointOnRays(poses, rays);
  if (at.w() < 0 && is_far) at.w() = 0;
  at.normalize();
  if (!is_far && !(at.w() > 0)) return;
  for (const auto& [k, i] : sightings) {
    const double error_px = errorOf(camera_, window_[k].camera_from_world, at, window_[k].tracks[i].pixel);
    if (!(error_px < 1.5 * scale_.threshold_px)) return;
  }
  point.at = at;
  point.is_placed = true;
  point.is_far = is_far;
}

void LocalMap::adjust() {
  if (window_.size() < 3) return;
  std::vector<std::pair<std::uint32_t, Sightings>> chosen;
  for (const auto& [track, sightings] : sightingsInWindow()) {
    const Point& point = points_.at(track);
    if (!point.is_placed || sightings.size() < 2) continue;
    if (!point.is_far && widestAngle(sightings) < scale_.least_rad) continue;
    chosen.emplace_back(track, sightings);
  }
  constexpr std::size_t kFewest = 20;  // fewer: a turn in place; resection finds its rotation
  if (chosen.size() < kFewest) return;
  std::ranges::stable_sort(chosen, std::greater(), [](const auto& point) { return point.second.size(); });
  if (chosen.size() > kMostAdjusted) chosen.resize(kMostAdjusted);

  const bool is_first_held = num_keys_ <= kWindow;
  SceneFit fit{.camera = camera_,
               .camera_from_world = {},
               .points = {},
               .sightings = {},
               .num_held_frames = is_first_held ? std::size_t{1} : std::size_t{2}};
  for (const KeyFrame& key : window_) fit.camera_from_world.push_back(key.camera_from_world);
  Sightings places;  // one per sighting
  for (const auto& [track, sightings] : chosen) {
    const auto id = static_cast<std::uint32_t>(fit.points.size());
    fit.points.push_back(points_.at(track).at);
    for (const auto& [k, i] : sightings) {
      const TrackPixel& seen = window_[k].tracks[i];
      const SceneSighting sighting{.frame = static_cast<std::uint32_t>(k),
                                   .point = id,
                                   .pixel = seen.pixel,
                                   .sigma_px = seen.sigma_px};
      if (!(sightingError(fit, sighting).norm() < 3 * scale_.threshold_px)) {
        window_[k].is_used[i] = 0;
        continue;
      }
      fit.sightings.push_back(sighting);
      places.emplace_back(k, i);
    }
  }
  constexpr double kHuber = 2.5;
  fit.loss = {.threshold_px = kHuber * noiseOf(fit)};
  fit = solveScene(std::move(fit), {.max_iterations = 5, .function_tolerance = 1e-3});
  if (fit.summary.termination == Termination::kFailed) return;
  constexpr double kOutlier = 5;
  const double limit = kOutlier * noiseOf(fit);
  for (std::size_t i = 0; i < fit.sightings.size(); ++i) {
    const double error = sightingError(fit, fit.sightings[i]).norm();
    if (!(error < limit * fit.sightings[i].sigma_px && error < scale_.threshold_px))
      window_[places[i].first].is_used[places[i].second] = 0;
  }
  for (std::size_t k = 0; k < window_.size(); ++k) {
    window_[k].camera_from_world = fit.camera_from_world[k];
    poses_[window_[k].frame] = fit.camera_from_world[k];
  }
  for (std::size_t p = 0; p < chosen.size(); ++p) {
    const auto& [track, sightings] = chosen[p];
    Point& point = points_.at(track);
    point.at = fit.points[p].normalized();
    const auto num_used = std::ranges::count_if(
        sightings, [&](const auto& at) { return window_[at.first].is_used[at.second] != 0; });
    if (num_used < 2 || (!point.is_far && !(point.at.w() > 0))) giveUp(point);
  }
}

void LocalMap::measureDepth() {
  KeyFrame& key = window_.back();
  const Eigen::Vector3d centre = centreOf(key.camera_from_world);
  std::vector<double> depths;
  key.num_points = 0;
  for (const TrackPixel& at : key.tracks) {
    const Point& point = points_.at(at.track);
    if (!point.is_placed) continue;
    ++key.num_points;
    if (!point.is_far) depths.push_back((point.place() - centre).norm());
  }
  if (depths.size() >= kFewestAgreeing) depth_ = medianOf(std::move(depths));
}

bool LocalMap::needsKeyFrame(std::span<const TrackPixel> tracks, const PlacedFrame& placed) const {
  const KeyFrame& key = window_.back();
  const SO3 key_from_frame = key.camera_from_world.rotation * placed.camera_from_world.rotation.inverse();
  std::vector<double> angles;
  std::size_t num_ready = 0;  // of unknown distance, but with parallax
  std::size_t num_new = 0;    // in no key frame
  std::size_t k = 0;
  for (const TrackPixel& at : tracks) {
    while (k < key.tracks.size() && key.tracks[k].track < at.track) ++k;
    const Point* point = find(at.track);
    if (point == nullptr || point->direction.isZero()) {
      num_new += point == nullptr || now_ >= point->ignored_until ? 1 : 0;
      continue;
    }
    if (k == key.tracks.size() || key.tracks[k].track != at.track || !key.rays[k]) continue;
    const auto ray = camera_.unproject(at.pixel);
    if (!ray) continue;
    const double angle = angleOf(key_from_frame * *ray, *key.rays[k]);
    angles.push_back(angle);
    if (!point->is_placed && angle > scale_.least_rad) ++num_ready;
  }
  if (angles.size() < kFewestAgreeing) return true;
  if (medianOf(std::move(angles)) > scale_.key_rad) return true;
  constexpr double kLeft = 0.7;
  const bool is_thin = placed.num_points < kFewPlaced ||
                       static_cast<double>(placed.num_points) < kLeft * static_cast<double>(key.num_points);
  return is_thin && (num_ready >= kFewestAgreeing || 6 * num_new > tracks.size());
}

std::optional<Eigen::Vector3d> LocalMap::placeOf(std::uint32_t track) const {
  const Point* point = find(track);
  if (point == nullptr || !point->isAtKnownDistance() || !isOfUse(*point)) return std::nullopt;
  return point->place();
}

std::vector<Eigen::Vector3d> LocalMap::points() const {
  constexpr std::size_t kFewestKeys = 3;
  std::vector<Eigen::Vector3d> points;
  for (const auto& [track, point] : points_) {
    if (point.isAtKnownDistance() && point.num_keys >= kFewestKeys) points.push_back(point.place());
  }
  return points;
}

}  // namespace alidade
