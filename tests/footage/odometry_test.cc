// SPDX-License-Identifier: MIT
#include "alidade/footage/map/odometry.h"

#include <gtest/gtest.h>

#include "footage/walk_tracks.h"

namespace alidade {
namespace {

using testing::footageCameras;
using testing::pathError;
using testing::PathError;
using testing::pathOf;
using testing::smoothWalk;
using testing::walkTracks;

// The cameras of the other tests, and an equidistant lens whose image is 185 degrees wide.
std::vector<AnyCamera> walkCameras() {
  std::vector<AnyCamera> cameras = footageCameras();
  constexpr double kFocal = 640 / (185 * std::numbers::pi / 180);
  cameras.push_back(
      AnyCamera::make("kannala_brandt", std::vector<double>{kFocal, kFocal, 319.5, 239.5, 0, 0, 0, 0}));
  return cameras;
}

// Of a walk that is found in one piece; the limit for footage is 2 %.
constexpr double kMostShare = 0.005;
constexpr double kMostTurnDeg = 1;

TEST(Odometry, FindsThePathOfAnyCamera) {
  int num_cases = 0;
  for (const AnyCamera& camera : walkCameras()) {
    for (const std::uint64_t seed : {1, 2}) {
      SCOPED_TRACE(std::string(camera.modelId()) + " " + std::to_string(seed));
      const auto poses = smoothWalk(150, seed);
      const Path path = pathOf(camera, walkTracks(camera, poses, {.seed = seed}));
      ASSERT_EQ(path.segments.size(), 1u);
      EXPECT_EQ(path.numPosed(), poses.size());
      EXPECT_EQ(path.obstacle, StartObstacle::kNone);
      EXPECT_TRUE(path.segments[0].scale_breaks.empty());
      EXPECT_GT(path.segments[0].points.size(), 100u);
      EXPECT_LT(path.rms_px, 0.9);  // the noise is 0.42 px, and tracks drift
      const PathError error = pathError(path, 0, poses);
      EXPECT_LT(error.share, kMostShare);
      EXPECT_LT(error.turn_deg, kMostTurnDeg);
      ++num_cases;
    }
  }
  EXPECT_EQ(num_cases, 10);
}

TEST(Odometry, StandsFalseTracks) {
  const AnyCamera camera = walkCameras()[1];
  const auto poses = smoothWalk(150, 3);
  const Path path =
      pathOf(camera, walkTracks(camera, poses, {.noise_px = 0.7, .drift_px = 0.1, .false_share = 0.02}));
  ASSERT_EQ(path.segments.size(), 1u);
  EXPECT_EQ(path.numPosed(), poses.size());
  EXPECT_LT(pathError(path, 0, poses).share, 2 * kMostShare);
}

// Along a wall, then a turn in place, and on in the other direction.
std::vector<SE3> walkWithTurn(double turn_rad) {
  std::vector<SE3> poses;
  SE3 at;
  const auto push = [&](const SO3& rotation, const Eigen::Vector3d& place) {
    at = {rotation, place};
    poses.push_back(at.inverse());
  };
  for (int f = 0; f < 60; ++f)
    push(SO3::exp({0, 0.1 * std::sin(0.05 * f), 0}), {-1 + 0.025 * f, 0.1 * std::sin(0.1 * f), 0});
  const SE3 before = at;
  constexpr int kTurn = 50;
  for (int f = 1; f <= kTurn; ++f)
    push(before.rotation * SO3::exp({0, turn_rad * f / kTurn, 0}), before.translation);
  const SE3 after = at;
  for (int f = 1; f <= 60; ++f)
    push(after.rotation, after.translation + Eigen::Vector3d(0, 0.1 * std::sin(0.1 * f), 0) +
                             after.rotation * Eigen::Vector3d(0.02 * f, 0, 0));
  return poses;
}

// Beyond the field of view of the narrow ones: then the scale is assumed to go on, which is told.
TEST(Odometry, GoesOnAfterATurnInPlace) {
  int num_told = 0;
  int num_cases = 0;
  for (const AnyCamera& camera : walkCameras()) {
    SCOPED_TRACE(camera.modelId());
    const auto poses = walkWithTurn(0.8 * std::numbers::pi);
    const Path path = pathOf(camera, walkTracks(camera, poses));
    ASSERT_EQ(path.segments.size(), 1u);
    EXPECT_EQ(path.numPosed(), poses.size());
    const auto turned = [](const SE3& first, const SE3& last) {
      return last.rotation * first.rotation.inverse();
    };
    const SO3 truth = turned(poses.front(), poses.back());
    const SO3 found = turned(path.frames.front().camera_from_world, path.frames.back().camera_from_world);
    EXPECT_LT((truth.inverse() * found).log().norm(), 0.03);
    // Each stretch has one scale.
    std::vector<std::size_t> ends = path.segments[0].scale_breaks;
    num_told += static_cast<int>(ends.size());
    ends.push_back(poses.size());
    std::size_t begin = 0;
    for (const std::size_t end : ends) {
      EXPECT_GT(end, 60u);
      EXPECT_LT(pathError(path, 0, poses, begin, end).share, 0.02) << begin;
      begin = end;
    }
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 5);
  EXPECT_GE(num_told, 2);
}

TEST(Odometry, SaysWhyItCannotStart) {
  int num_cases = 0;
  for (const AnyCamera& camera : walkCameras()) {
    SCOPED_TRACE(camera.modelId());
    std::vector<SE3> turning;
    for (int f = 0; f < 40; ++f)
      turning.push_back({SO3::exp({0.02 * std::sin(0.1 * f), 0.01 * f, 0}), Eigen::Vector3d::Zero()});
    const Path turned = pathOf(camera, walkTracks(camera, turning));
    EXPECT_EQ(turned.numPosed(), 0u);
    EXPECT_TRUE(turned.segments.empty());
    EXPECT_EQ(turned.obstacle, StartObstacle::kRotation);
    const Path still = pathOf(camera, walkTracks(camera, std::vector<SE3>(20)));
    EXPECT_EQ(still.numPosed(), 0u);
    EXPECT_EQ(still.obstacle, StartObstacle::kStill);
    FootageTracks dark = walkTracks(camera, turning);
    for (auto& frame : dark.frames) frame.clear();
    EXPECT_EQ(pathOf(camera, dark).obstacle, StartObstacle::kFewPoints);
    ++num_cases;
  }
  EXPECT_EQ(num_cases, 5);
  EXPECT_EQ(pathOf(walkCameras()[0], {.size = testing::kFootageSize, .numbers = {}, .frames = {}}).numPosed(),
            0u);
}

// Points that move at random.
TEST(Odometry, FindsNoPathWhereNothingIsRigid) {
  const AnyCamera camera = walkCameras()[0];
  FootageTracks tracks = walkTracks(camera, std::vector<SE3>(30));
  Random random(4);
  std::map<std::uint32_t, Eigen::Vector2d> moves;
  for (std::size_t f = 0; f < tracks.frames.size(); ++f) {
    for (TrackPixel& at : tracks.frames[f]) {
      if (!moves.contains(at.track)) moves[at.track] = 3 * Eigen::Vector2d(random.normal(), random.normal());
      at.pixel += static_cast<double>(f) * moves[at.track];
    }
  }
  EXPECT_EQ(pathOf(camera, tracks).numPosed(), 0u);
}

TEST(Odometry, BeginsWithTheFirstFrameHoweverLateTheCameraMoves) {
  const AnyCamera camera = walkCameras()[0];
  const auto walk = smoothWalk(80, 2);
  std::vector<SE3> poses(40, walk.front());
  poses.insert(poses.end(), walk.begin(), walk.end());
  const Path path = pathOf(camera, walkTracks(camera, poses));
  ASSERT_EQ(path.segments.size(), 1u);
  EXPECT_EQ(path.numPosed(), poses.size());
  EXPECT_LT(pathError(path, 0, poses).share, kMostShare);
}

// Five dark frames. Flow has lost all its points then; descriptors find them again.
TEST(Odometry, TellsPiecesThatNothingConnects) {
  const AnyCamera camera = walkCameras()[2];
  const auto poses = smoothWalk(160, 2);
  FootageTracks found_again = walkTracks(camera, poses);
  FootageTracks lost = found_again;
  constexpr std::size_t kDark = 80;
  constexpr std::size_t kLight = 85;
  for (std::size_t f = kDark; f < poses.size(); ++f) {
    for (TrackPixel& at : lost.frames[f]) at.track += 100000;
    if (f >= kLight) continue;
    lost.frames[f].clear();
    found_again.frames[f].clear();
  }
  const Path in_two = pathOf(camera, lost);
  ASSERT_EQ(in_two.segments.size(), 2u);
  EXPECT_EQ(in_two.numPosed(), poses.size() - (kLight - kDark));
  EXPECT_EQ(in_two.segments[0].end, kDark);
  EXPECT_EQ(in_two.segments[1].begin, kLight);
  for (std::size_t f = kDark; f < kLight; ++f) EXPECT_FALSE(in_two.frames[f].segment) << f;
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_LT(pathError(in_two, s, poses).share, kMostShare);
    EXPECT_GT(in_two.segments[s].length, 0);
  }
  // Each segment begins with its own world.
  EXPECT_LT(in_two.frames[kLight].camera_from_world.log().norm(), 1e-12);

  const Path in_one = pathOf(camera, found_again);
  ASSERT_EQ(in_one.segments.size(), 1u);
  EXPECT_EQ(in_one.numPosed(), poses.size() - (kLight - kDark));
  EXPECT_LT(pathError(in_one, 0, poses).share, kMostShare);
}

TEST(Odometry, IsTheSameEachTime) {
  const AnyCamera camera = walkCameras()[3];
  const FootageTracks tracks = walkTracks(camera, smoothWalk(60, 4));
  const Path one = pathOf(camera, tracks);
  const Path other = pathOf(camera, tracks);
  ASSERT_EQ(one.numPosed(), 60u);
  for (std::size_t i = 0; i < one.frames.size(); ++i) {
    EXPECT_EQ(one.frames[i].camera_from_world.matrix(), other.frames[i].camera_from_world.matrix());
    EXPECT_EQ(one.frames[i].is_key, other.frames[i].is_key);
  }
}

}  // namespace
}  // namespace alidade
