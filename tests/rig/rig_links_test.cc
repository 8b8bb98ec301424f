// SPDX-License-Identifier: MIT
// Cameras that few frames link, cameras that are one camera, and the accuracy of a link.
#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include <gmock/gmock.h>

#include "rig_scene.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

constexpr double kLinkNoise = 0.1;

RigCalibration calibrated(const RigScene& scene) {
  return calibrate(std::span(&kCharuco, 1), scene.views, optionsFor(scene));
}

// Equal cameras side by side.
RigScene rowOf(int num_cameras, double step_m, int num_frames, std::uint64_t seed) {
  const std::vector<double> pinhole = {600, 600, 320, 240};
  std::vector<TrueCamera> cameras;
  for (int c = 0; c < num_cameras; ++c)
    cameras.push_back({AnyCamera::make("pinhole", pinhole), {640, 480}, {SO3(), {-step_m * c, 0, 0}}});
  return sceneOf(std::move(cameras), kCharuco, num_frames, kLinkNoise, seed);
}

// Only the first frames are common to all cameras; the others are each camera's own.
void keepCommon(RigScene& scene, std::size_t num_common) {
  for (std::size_t c = 1; c < scene.views.size(); ++c) {
    std::vector<View>& views = scene.views[c].views;
    for (std::size_t v = num_common; v < views.size(); ++v)
      views[v].image = "frame" + std::to_string(1000 * c + v) + ".png";
  }
}

// The corners of these views are those of the frames `by` later, as from a camera that lags.
void shift(std::vector<View>& views, std::size_t count, std::size_t by) {
  for (std::size_t v = 0; v < count; ++v) std::swap(views[v].corners, views[v + by].corners);
}

// The board moved before the second camera saw it.
void moveBoard(View& view, double motion_m, Random& random) {
  const Eigen::Vector3d turn(random.normal(), random.normal(), random.normal());
  const Eigen::Vector2d by_px = 600 * motion_m * Eigen::Vector2d(random.normal(), random.normal());
  const Eigen::Vector2d middle(320, 240);
  const Eigen::Rotation2Dd rotation(motion_m * turn.z());
  for (Corner& corner : view.corners) corner.pixel = middle + by_px + rotation * (corner.pixel - middle);
}

TEST(RigLinks, AreUncheckedByASingleFrame) {
  int num_rigs = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    RigScene scene = rowOf(2, 0.1, 24, 60 + seed);
    Random random(seed);
    keepCommon(scene, 1);
    std::vector<View>& views = scene.views[1].views;
    if (seed % 2 == 0)
      shift(views, 1, 2 + seed);
    else
      moveBoard(views[0], 0.01 * static_cast<double>(seed), random);
    const RigCalibration rig = calibrated(scene);
    EXPECT_NE(rig.verdict(), Verdict::kTrustworthy) << seed;
    const auto found = std::ranges::find(rig.diagnoses, "unchecked_link", &Diagnosis::id);
    ASSERT_NE(found, rig.diagnoses.end()) << seed;
    EXPECT_THAT(found->cause, AllOf(HasSubstr("frame frame0 "), HasSubstr("camera0 | camera1")));
    ++num_rigs;
  }
  EXPECT_EQ(num_rigs, 8);
}

// Two frames that contradict each other do not tell which of them is wrong.
TEST(RigLinks, AreUncheckedByTwoFramesOfWhichOneIsWrong) {
  int num_rigs = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    RigScene scene = rowOf(2, 0.1, 24, 80 + seed);
    Random random(seed);
    keepCommon(scene, 2);
    std::vector<View>& views = scene.views[1].views;
    if (seed % 3 == 0)
      shift(views, 2, 3);  // both are wrong
    else if (seed % 3 == 1)
      shift(views, 1, 2 + seed);
    else
      moveBoard(views[seed % 2], 0.005 * static_cast<double>(seed), random);
    const RigCalibration rig = calibrated(scene);
    EXPECT_NE(rig.verdict(), Verdict::kTrustworthy) << seed;
    EXPECT_THAT(rig, hasDiagnosis("unchecked_link")) << seed;
    ++num_rigs;
  }
  EXPECT_EQ(num_rigs, 12);
}

TEST(RigLinks, AreCheckedByThreeFrames) {
  int num_trusted = 0;
  int num_rigs = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    RigScene scene = rowOf(2 + static_cast<int>(seed % 3), 0.06, 24, 100 + seed);
    keepCommon(scene, 3 + seed);
    const RigCalibration rig = calibrated(scene);
    EXPECT_THAT(rig, Not(hasDiagnosis("unchecked_link"))) << seed;
    EXPECT_THAT(rig, Not(hasDiagnosis("no_baseline"))) << seed;
    num_trusted += rig.verdict() == Verdict::kTrustworthy ? 1 : 0;
    ++num_rigs;
  }
  EXPECT_EQ(num_rigs, 20);
  EXPECT_GE(num_trusted, 10);
}

// The second of three cameras links the others, once with many frames and once with a single one.
TEST(RigLinks, OfAChainAreCheckedOneByOne) {
  for (const bool is_lone : {false, true}) {
    RigScene scene = rowOf(3, 0.06, 30, 140);
    const auto frameOf = [](const View& view) { return std::stoi(view.image.substr(5)); };
    std::erase_if(scene.views[0].views, [&](const View& view) { return frameOf(view) >= 15; });
    for (View& view : scene.views[2].views) {
      if (frameOf(view) < (is_lone ? 29 : 15))
        view.image = std::string(1 + static_cast<std::size_t>(frameOf(view)), 'x');
    }
    const RigCalibration rig = calibrated(scene);
    if (!is_lone) {
      EXPECT_THAT(rig, Not(hasDiagnosis("unchecked_link")));
      EXPECT_EQ(rig.verdict(), Verdict::kTrustworthy) << rig.diagnoses.front().message();
      continue;
    }
    const auto found = std::ranges::find(rig.diagnoses, "unchecked_link", &Diagnosis::id);
    ASSERT_NE(found, rig.diagnoses.end());
    EXPECT_THAT(found->cause, AllOf(HasSubstr("frame frame29 "), HasSubstr("camera0, camera1 | camera2")));
  }
}

// Pictures of the second camera, stored again, serve as those of the third.
TEST(RigBaselines, AreNoneIfACameraIsGivenTwice) {
  int num_rigs = 0;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    RigScene scene = rowOf(3, 0.005, 24, 160 + seed);
    EXPECT_THAT(calibrated(scene), Not(hasDiagnosis("no_baseline"))) << seed;
    Random random(seed);
    scene.views[2].views = scene.views[1].views;
    for (View& view : scene.views[2].views) addCornerNoise(view, 0.02, random);
    for (View& view : scene.views[2].views) {
      for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
    }
    const RigCalibration twice = calibrated(scene);
    EXPECT_NE(twice.verdict(), Verdict::kTrustworthy) << seed;
    const auto found = std::ranges::find(twice.diagnoses, "no_baseline", &Diagnosis::id);
    ASSERT_NE(found, twice.diagnoses.end()) << seed;
    EXPECT_THAT(found->cause, HasSubstr("camera1 and camera2 may be the same camera twice"));
    ++num_rigs;
  }
  EXPECT_EQ(num_rigs, 3);
}

// 95 % of the true errors of transferring the middles of boards from the first camera to the second.
double trueTransferPx(const RigScene& scene, const RigCalibration& rig, const std::vector<SE3>& boards) {
  const auto lens = [&](std::size_t c) {
    return AnyCamera::make(rig.fit.cameras[c].model, rig.fit.cameras[c].params);
  };
  std::vector<double> errors;
  for (const SE3& board : boards) {
    const Eigen::Vector3d p = board * kCharuco.middle();
    const Projection seen = scene.cameras[0].camera.project(p);
    const Projection truth = scene.cameras[1].camera.project(scene.cameras[1].camera_from_rig * p);
    const auto ray = lens(0).unproject(seen.pixel);
    const Projection found = lens(1).project(rig.fit.cameras[1].camera_from_rig * (p.norm() * *ray));
    errors.push_back((found.pixel - truth.pixel).norm());
  }
  std::ranges::sort(errors);
  return errors.at(errors.size() * 95 / 100);
}

// A fixed lens that is wrong by 1 %, and a board that is 0.5 % too wide; without them the accuracy is small.
TEST(RigAccuracy, ContainsWhatIsFound) {
  constexpr int kNumFrames = 24;
  int num_rigs = 0;
  for (std::uint64_t seed = 201; seed < 204; ++seed) {
    for (const bool is_wide : {false, true}) {
      BoardShape wide;
      for (const Eigen::Vector3d& corner : kCharuco.corners())
        wide.offsets_m.emplace_back(is_wide ? 0.005 * corner.x() : 0, 0, 0);
      const std::vector<TrueCamera> cameras = rowOf(2, 0.1, 4, 1).cameras;
      const RigScene scene = sceneOf(cameras, kCharuco, kNumFrames, kLinkNoise, seed, wide);
      Random random(seed);
      const std::vector<SE3> boards =
          randomViews(cameras[0].camera, cameras[0].size, kCharuco, kNumFrames, random);
      RigOptions options = optionsFor(scene);
      const RigCalibration free = calibrate(std::span(&kCharuco, 1), scene.views, options);
      ++num_rigs;
      if (is_wide) {
        EXPECT_GT(free.cameras[1].link.transfer_px, trueTransferPx(scene, free, boards)) << seed;
        continue;
      }
      EXPECT_LT(free.cameras[1].link.transfer_px, 0.2) << seed;
      const std::vector<double> wrong = {606, 606, 320, 240};
      options.given = {bareRecord(AnyCamera::make("pinhole", wrong), cameras[0].size, ""), std::nullopt};
      const RigCalibration fixed = calibrate(std::span(&kCharuco, 1), scene.views, options);
      EXPECT_GT(trueTransferPx(scene, fixed, boards), 0.5) << seed;
      EXPECT_GT(fixed.cameras[1].link.transfer_px, trueTransferPx(scene, fixed, boards)) << seed;
      ++num_rigs;
    }
  }
  EXPECT_EQ(num_rigs, 9);
}

}  // namespace
}  // namespace alidade
