// SPDX-License-Identifier: MIT
#include "alidade/footage/check/camera_check.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "footage/points_scene.h"
#include "footage/simulated_tracks.h"

namespace alidade {
namespace {

using testing::footageCameras;
using testing::kFootageSize;
using testing::simulatedTracks;

FootageScene sceneOf(const AnyCamera& camera) {
  return {.camera = camera, .image_size = kFootageSize, .num_frames = 25, .flow_px = 12, .num_jobs = 1};
}

FootageTracks tracksOf(const FootageScene& scene) {
  return simulatedTracks(FootageSimulator(scene), {.noise_px = 0.1, .drift_px = 0.02}, 51);
}

AnyCamera changed(const AnyCamera& camera, const std::function<void(std::vector<double>&)>& change) {
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  change(params);
  return AnyCamera::make(camera.modelId(), params);
}

TEST(CameraCheck, ChangesAreFoundAndNamed) {
  const AnyCamera camera = footageCameras()[1];
  const FootageTracks tracks = tracksOf(sceneOf(camera));
  EXPECT_EQ(checkOnFootage(camera, tracks).verdict, FootageVerdict::kConsistent);

  const auto crop = checkOnFootage(changed(camera, [](auto& p) { p[0] *= 0.9, p[1] *= 0.9; }), tracks);
  ASSERT_EQ(crop.verdict, FootageVerdict::kInconsistent);
  const CameraChange& longer = crop.changes[crop.explanation.value()];
  EXPECT_EQ(longer.kind, CameraChangeKind::kFocalLength);
  EXPECT_NEAR(longer.amounts[0], 1 / 0.9 - 1, 0.03);
  EXPECT_EQ(describe(longer).substr(0, 14), "focal length +");

  const auto shifted = checkOnFootage(changed(camera, [](auto& p) { p[2] += 20; }), tracks);
  ASSERT_EQ(shifted.verdict, FootageVerdict::kInconsistent);
  const CameraChange& back = shifted.changes[shifted.explanation.value()];
  EXPECT_EQ(back.kind, CameraChangeKind::kPrincipalPoint);
  EXPECT_NEAR(back.amounts[0], -20, 6);
  EXPECT_NEAR(back.amounts[1], 0, 6);

  const auto bent = checkOnFootage(changed(camera,
                                           [](auto& p) {
                                             for (std::size_t i = 4; i < p.size(); ++i) p[i] *= 0.5;
                                           }),
                                   tracks);
  ASSERT_EQ(bent.verdict, FootageVerdict::kInconsistent);
  const CameraChangeKind kind = bent.changes[bent.explanation.value()].kind;
  EXPECT_TRUE(kind == CameraChangeKind::kDistortion || kind == CameraChangeKind::kFirstRadial);
}

TEST(CameraCheck, TrueCamerasAreNotDoubted) {
  int num_consistent = 0;
  int num_checked = 0;
  for (const AnyCamera& camera : footageCameras()) {
    SCOPED_TRACE(camera.modelId());
    const FootageCheck check = checkOnFootage(camera, tracksOf(sceneOf(camera)));
    EXPECT_NE(check.verdict, FootageVerdict::kInconsistent);
    num_consistent += check.verdict == FootageVerdict::kConsistent ? 1 : 0;
    EXPECT_GE(check.num_windows, 1);
    EXPECT_GT(check.num_points, 200);
    int num_pixels = 0;
    for (const FootageCell& cell : check.cells) num_pixels += cell.num_pixels;
    EXPECT_GT(num_pixels, 0.8 * check.num_pixels);
    EXPECT_LT(check.noise_px, 0.2);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);
  EXPECT_GE(num_consistent, 3);
}

// Points of a car's bonnet, as many as a fifth of all.
FootageTracks withBonnet(FootageTracks tracks) {
  Random random(61);
  std::vector<Eigen::Vector2d> bonnet;
  while (5 * bonnet.size() < tracks.frames.front().size())
    bonnet.emplace_back(random.uniform(0, 639), random.uniform(400, 479));
  for (auto& frame : tracks.frames) {
    std::uint32_t track = 1000000;
    std::erase_if(frame, [](const TrackPixel& at) { return at.pixel.y() > 400; });
    for (const Eigen::Vector2d& pixel : bonnet) {
      const Eigen::Vector2d noise(random.normal(), random.normal());
      frame.push_back({.track = track++, .pixel = pixel + 0.1 * noise});
    }
  }
  return tracks;
}

TEST(CameraCheck, PointsFixedToTheImageDoNotCount) {
  int num_checked = 0;
  for (const AnyCamera& camera : footageCameras()) {
    const FootageTracks with = withBonnet(tracksOf(sceneOf(camera)));
    const FootageTracks without = withoutFixed(with);
    for (std::size_t i = 0; i < with.frames.size(); ++i) {
      EXPECT_TRUE(
          std::ranges::none_of(without.frames[i], [](const TrackPixel& at) { return at.track >= 1000000; }));
      EXPECT_GE(without.frames[i].size(), 0.78 * static_cast<double>(with.frames[i].size()));
    }
    EXPECT_NE(checkOnFootage(camera, with).verdict, FootageVerdict::kInconsistent) << camera.modelId();
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);
}

TEST(CameraCheck, AnUndecidedChangeIsNoGapBesideACertainOne) {
  const ChangeFit undecided{.kind = CameraChangeKind::kAspect,
                            .cost_drop = 0.3,
                            .score = 20,
                            .needed_score = 25,
                            .effect_px = 9,
                            .sure_px = 8};
  ChangeFit certain = undecided;
  certain.kind = CameraChangeKind::kFocalLength;
  certain.needed_score = 0;
  certain.gain = certain.cost_drop;
  FootageOutcome alone{.tolerance_px = 1};
  EXPECT_FALSE(explain(alone, {&undecided}, false));
  EXPECT_EQ(alone.gap, FootageGap::kWeak);
  FootageOutcome both{.tolerance_px = 1};
  EXPECT_TRUE(explain(both, {&undecided, &certain}, false));
  EXPECT_EQ(both.gap, FootageGap::kNone);
  EXPECT_EQ(both.explanation, 1U);
}

TEST(CameraCheck, FootageThatCannotTellSaysWhy) {
  struct Case {
    FootageGap gap;
    std::function<void(FootageScene&)> apply;
  };
  const std::vector<Case> cases = {
      {FootageGap::kNoParallax, [](FootageScene& s) { s.path = FootagePath::kRotation; }},
      {FootageGap::kNoMotion, [](FootageScene& s) {
         s.path = FootagePath::kStatic;
         s.flow_px = 0;
       }}};
  const AnyCamera camera = footageCameras()[0];
  int num_checked = 0;
  for (const Case& c : cases) {
    SCOPED_TRACE(gapId(c.gap));
    FootageScene scene = sceneOf(camera);
    c.apply(scene);
    const FootageCheck check = checkOnFootage(camera, tracksOf(scene));
    EXPECT_EQ(check.verdict, FootageVerdict::kCannotTell);
    EXPECT_EQ(check.gap, c.gap) << gapId(check.gap);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 2);

  // One plane leaves the lens undetermined, or says no more than the truth.
  FootageScene plane = sceneOf(camera);
  plane.surroundings = FootageSurroundings::kPlane;
  EXPECT_NE(checkOnFootage(camera, tracksOf(plane)).verdict, FootageVerdict::kInconsistent);

  // Ten points in each frame.
  FootageTracks few = tracksOf(sceneOf(camera));
  for (auto& frame : few.frames)
    std::erase_if(frame, [](const TrackPixel& at) { return at.track % 30 != 0; });
  const FootageCheck check = checkOnFootage(camera, few);
  EXPECT_EQ(check.verdict, FootageVerdict::kCannotTell);
  EXPECT_EQ(check.gap, FootageGap::kFewPoints);
  // Four frames may show an error, but never that there is none.
  const AnyCamera wide = footageCameras()[2];
  FootageTracks short_walk = tracksOf(sceneOf(wide));
  short_walk.frames.resize(4);
  short_walk.numbers.resize(4);
  const FootageCheck of_four = checkOnFootage(wide, short_walk);
  EXPECT_EQ(of_four.verdict, FootageVerdict::kCannotTell);
  EXPECT_EQ(of_four.gap, FootageGap::kFewFrames) << gapId(of_four.gap);

  FootageTracks none;
  none.size = kFootageSize;
  EXPECT_EQ(checkOnFootage(camera, none).gap, FootageGap::kFewPoints);
}

}  // namespace
}  // namespace alidade
