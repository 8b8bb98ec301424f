// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "alidade/footage/follow/tracks.h"
#include "alidade/footage/map/odometry.h"
#include "footage/points_scene.h"

namespace alidade::testing {

struct WalkOptions {
  std::uint64_t seed = 1;
  double noise_px = 0.3;
  double drift_px = 0.02;      ///< by which a track moves off its point in each frame
  double false_share = 0.002;  ///< of tracks that jump by several px in a frame
  std::size_t num_tracks = 300;
};

/// Points on the walls of a room of 8 x 5 x 8 m about the origin, and some within.
inline std::vector<Eigen::Vector3d> roomPoints(Random& random, std::size_t count = 6000) {
  const Eigen::Vector3d half(4, 2.5, 4);
  std::vector<Eigen::Vector3d> points;
  while (points.size() < count) {
    Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const std::uint64_t wall = random.index(8);
    if (wall < 6) p[static_cast<Eigen::Index>(wall / 2)] = wall % 2 == 0 ? -1 : 1;
    points.emplace_back(p.cwiseProduct(half));
  }
  return points;
}

/// What a tracker would follow on the way: tracks end where a point leaves the image, and new ones begin.
/// @param poses  camera_from_world of each frame
inline FootageTracks walkTracks(const AnyCamera& camera, std::span<const SE3> poses,
                                const WalkOptions& options = {}) {
  Random random(options.seed);
  const std::vector<Eigen::Vector3d> points = roomPoints(random);
  struct Followed {
    std::uint32_t track = 0;
    Eigen::Vector2d offset{0, 0};
  };
  FootageTracks tracks{.size = kFootageSize, .is_video = true, .numbers = {}, .frames = {}};
  std::map<std::size_t, Followed> followed;  // by point
  std::uint32_t next = 0;
  for (std::size_t f = 0; f < poses.size(); ++f) {
    std::map<std::size_t, Eigen::Vector2d> seen;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Projection projection = camera.project(poses[f] * points[i]);
      if (projection.ok() && isInFootage(projection.pixel)) seen[i] = projection.pixel;
    }
    std::erase_if(followed, [&](const auto& entry) { return !seen.contains(entry.first); });
    if (!seen.empty() && 5 * followed.size() < 4 * options.num_tracks) {
      std::vector<std::size_t> candidates;
      for (const auto& [i, pixel] : seen) candidates.push_back(i);
      for (std::size_t trial = 0; trial < 4 * options.num_tracks && followed.size() < options.num_tracks;
           ++trial) {
        const std::size_t i = candidates[random.index(candidates.size())];
        if (!followed.contains(i)) followed[i] = {.track = next++};
      }
    }
    std::vector<TrackPixel>& frame = tracks.frames.emplace_back();
    for (auto& [i, one] : followed) {
      one.offset += options.drift_px * Eigen::Vector2d(random.normal(), random.normal());
      if (random.uniform() < options.false_share)
        one.offset += 8 * Eigen::Vector2d(random.normal(), random.normal());
      frame.push_back({.track = one.track, .pixel = noisy(seen[i] + one.offset, options.noise_px, random)});
    }
    std::sort(frame.begin(), frame.end(),
              [](const TrackPixel& a, const TrackPixel& b) { return a.track < b.track; });
    tracks.numbers.push_back(f);
  }
  return tracks;
}

/// A smooth way through the middle of the room; the camera looks about.
inline std::vector<SE3> smoothWalk(std::size_t num_frames, std::uint64_t seed, double speed = 0.05) {
  Random random(seed);
  std::array<double, 6> size{};
  std::array<double, 6> rate{};
  std::array<double, 6> phase{};
  const std::array<double, 6> most = {1.2, 0.6, 1.2, 0.25, 0.6, 0.2};  // m and radians
  for (std::size_t k = 0; k < most.size(); ++k) {
    size[k] = most[k] * random.uniform(0.5, 1);
    rate[k] = speed * random.uniform(0.5, 1.2);
    phase[k] = random.uniform(0, 2 * std::numbers::pi);
  }
  std::vector<SE3> poses;
  for (std::size_t f = 0; f < num_frames; ++f) {
    const auto at = [&](std::size_t k) {
      return size[k] * std::sin(rate[k] * static_cast<double>(f) + phase[k]);
    };
    const SE3 world_from_camera{SO3::exp({at(3), at(4), at(5)}), {at(0), at(1), at(2)}};
    poses.push_back(world_from_camera.inverse());
  }
  return poses;
}

[[nodiscard]] inline Path pathOf(const AnyCamera& camera, const FootageTracks& tracks) {
  Odometry odometry(camera, tracks.size);
  for (std::size_t i = 0; i < tracks.frames.size(); ++i) odometry.add(tracks.numbers[i], tracks.frames[i]);
  return odometry.finish();
}

struct PathError {
  double share = 0;     ///< RMS distance of the camera from the truth after a similarity, of the way's length
  double turn_deg = 0;  ///< RMS
  std::size_t num_frames = 0;
};

/// Of the frames from begin to end that belong to a segment.
/// @param poses  the true ones, camera_from_world of each frame
[[nodiscard]] inline PathError pathError(const Path& path, std::size_t segment, std::span<const SE3> poses,
                                         std::size_t begin = 0, std::size_t end = SIZE_MAX) {
  std::vector<std::size_t> frames;
  for (std::size_t i = begin; i < std::min(end, path.frames.size()); ++i) {
    if (path.frames[i].segment == segment) frames.push_back(i);
  }
  Eigen::Matrix3Xd found(3, static_cast<Eigen::Index>(frames.size()));
  Eigen::Matrix3Xd truth(3, static_cast<Eigen::Index>(frames.size()));
  double length = 0;
  for (Eigen::Index k = 0; k < found.cols(); ++k) {
    const std::size_t i = frames[static_cast<std::size_t>(k)];
    found.col(k) = path.frames[i].camera_from_world.inverse().translation;
    truth.col(k) = poses[i].inverse().translation;
    if (k > 0) length += (truth.col(k) - truth.col(k - 1)).norm();
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(found, truth, true);
  const Eigen::Matrix3Xd moved = (similarity.topRows<3>() * found.colwise().homogeneous());
  const Eigen::Matrix3d turn =
      similarity.topLeftCorner<3, 3>() / std::cbrt(similarity.topLeftCorner<3, 3>().determinant());
  double turns = 0;
  for (const std::size_t i : frames) {
    const Eigen::Matrix3d off =
        turn * path.frames[i].camera_from_world.rotation.matrix().transpose() * poses[i].rotation.matrix();
    turns += std::pow(Eigen::AngleAxisd(off).angle(), 2);
  }
  const auto count = static_cast<double>(frames.size());
  return {.share = std::sqrt((moved - truth).squaredNorm() / count) / length,
          .turn_deg = 180 / std::numbers::pi * std::sqrt(turns / count),
          .num_frames = frames.size()};
}

}  // namespace alidade::testing
