// SPDX-License-Identifier: MIT
#include "alidade/footage/map/reconstruction.h"

#include <numeric>

#include <gtest/gtest.h>

#include "footage/points_scene.h"
#include "footage/simulated_tracks.h"

namespace alidade {
namespace {

using testing::angleDeg;
using testing::footageCameras;
using testing::kFootageSize;
using testing::simulatedTracks;

FootageScene reconstructionScene(const AnyCamera& camera) {
  return {.camera = camera, .image_size = kFootageSize, .num_frames = 25, .flow_px = 9, .num_jobs = 1};
}

std::vector<std::size_t> firstFrames(std::size_t count) {
  std::vector<std::size_t> frames(count);
  std::iota(frames.begin(), frames.end(), std::size_t{0});
  return frames;
}

TEST(Reconstruction, PosesAreThoseOfTheSimulation) {
  int num_poses = 0;
  for (const AnyCamera& camera : footageCameras()) {
    SCOPED_TRACE(camera.modelId());
    const FootageSimulator simulator(reconstructionScene(camera));
    const FootageTracks tracks = simulatedTracks(simulator, {.noise_px = 0.1}, 41);
    ASSERT_GE(tracks.frames.size(), 6U);
    const Reconstruction found = reconstruct(camera, tracks, firstFrames(6));
    ASSERT_TRUE(found.fit);
    EXPECT_EQ(found.kind, TwoViewKind::kGeneral);
    EXPECT_EQ(found.frames.size(), 6U);
    EXPECT_NEAR(found.noise_px, 0.1, 0.015);
    EXPECT_LT(found.outlier_share, 0.05);
    const SE3 first = simulator.poseOf(static_cast<int>(tracks.numbers[0]));
    for (std::size_t i = 1; i < found.frames.size(); ++i) {
      const SE3 truth = simulator.poseOf(static_cast<int>(tracks.numbers[i])) * first.inverse();
      const SE3& pose = found.fit->camera_from_world[i];
      EXPECT_LT((truth.rotation.inverse() * pose.rotation).log().norm(), 2e-3);
      EXPECT_LT(angleDeg(truth.inverse().translation, pose.inverse().translation), 1.5);
      ++num_poses;
    }
  }
  EXPECT_EQ(num_poses, 4 * 5);
}

TEST(Reconstruction, JumpsOfTracksAreLeftOut) {
  const AnyCamera camera = footageCameras()[1];
  const FootageSimulator simulator(reconstructionScene(camera));
  FootageTracks tracks = simulatedTracks(simulator, {.noise_px = 0.1}, 42);
  Random random(43);
  int num_moved = 0;
  for (std::size_t f = 0; f < 6; ++f) {
    for (TrackPixel& at : tracks.frames[f]) {
      if (random.uniform() > 0.1) continue;
      at.pixel += Eigen::Vector2d(random.uniform(5, 40), random.uniform(5, 40));
      ++num_moved;
    }
  }
  const Reconstruction found = reconstruct(camera, tracks, firstFrames(6));
  ASSERT_TRUE(found.fit);
  EXPECT_GT(num_moved, 100);
  EXPECT_NEAR(found.noise_px, 0.1, 0.03);
  for (const SceneSighting& sighting : found.fit->sightings)
    EXPECT_LT(sightingError(*found.fit, sighting).norm(), 1);
}

TEST(Reconstruction, RotationHasNoPoints) {
  FootageScene scene = reconstructionScene(footageCameras()[0]);
  scene.path = FootagePath::kRotation;
  const FootageTracks tracks = simulatedTracks(FootageSimulator(scene), {.noise_px = 0.1}, 44);
  ASSERT_GE(tracks.frames.size(), 4U);
  const Reconstruction found = reconstruct(scene.camera, tracks, firstFrames(4));
  EXPECT_FALSE(found.fit);
  EXPECT_EQ(found.kind, TwoViewKind::kRotation);
}

}  // namespace
}  // namespace alidade
