// SPDX-License-Identifier: MIT
// Rigs whose cameras do not take a frame at one instant.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rig_scene.h"
#include "support/message_of.h"

namespace alidade {
namespace {

using testing::Contains;
using testing::Field;
using testing::Not;

// Times within a frame, in intervals between frames.
struct Times {
  std::vector<double> delays = {0, 0, 0};
  double jitter = 0;
};

struct WavedBoard {
  int num_frames = 40;
  double step_m = 0.05;  // mean motion from frame to frame
  Times times = {};
  int moved_from = 1000;  // the first frame after the last camera moved
  double moved_m = 0.003;
};

// Three equal cameras on an arc of 1 m around a board that a hand waves.
RigScene wavedScene(const WavedBoard& wave, std::uint64_t seed) {
  constexpr double kNoisePx = 0.06;
  Random random(seed);
  const std::vector<double> lens = {900, 900, 640, 360, -0.28, 0.09, 0, 0, 0};
  RigScene scene;
  for (int c = 0; c < 3; ++c) {
    const SE3 turned = {SO3::exp(Eigen::Vector3d(0, 0.45 * (c - 1), 0)), Eigen::Vector3d(0, 0, 1)};
    scene.cameras.push_back({AnyCamera::make("radtan", lens), {1280, 720}, turned});
    scene.views.push_back({.name = std::string(1, static_cast<char>('a' + c)), .views = {}});
  }
  std::vector<Eigen::Vector4d> waves;  // two frequencies and phases of each coordinate
  for (int i = 0; i < 6; ++i)
    waves.emplace_back(random.uniform(0.5, 1), random.uniform(1, 1.7), random.uniform(0, 6),
                       random.uniform(0, 6));
  const auto poseAtTime = [&](double time) {
    constexpr double kSizes[] = {0.16, 0.09, 0.12, 0.45, 0.45, 0.4};  // m, rad
    const double phase = time * wave.step_m / 0.18;
    SE3::Tangent xi;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector4d& w = waves[static_cast<std::size_t>(i)];
      xi(i) = kSizes[i] * (std::sin(w(0) * phase + w(2)) + std::sin(w(1) * phase + w(3)));
    }
    const Eigen::Vector3d middle = kCharuco.middle();
    return SE3{SO3(), xi.head<3>()} * SE3{SO3::exp(xi.tail<3>()), Eigen::Vector3d::Zero()} *
           SE3{SO3(), -middle};
  };
  for (int frame = 0; frame < wave.num_frames; ++frame) {
    for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
      const TrueCamera& camera = scene.cameras[c];
      const double time = frame + wave.times.delays[c] + wave.times.jitter * random.normal();
      SE3 camera_from_board = camera.camera_from_rig * poseAtTime(time);
      if (c == 2 && frame >= wave.moved_from)
        camera_from_board = SE3{SO3(), Eigen::Vector3d(wave.moved_m, 0, 0)} * camera_from_board;
      View view = exactView(camera.camera, camera.size, kCharuco, camera_from_board,
                            "frame" + std::to_string(1000 + frame) + ".png");
      const Eigen::Vector3d normal = camera_from_board.rotation * Eigen::Vector3d::UnitZ();
      if (view.corners.size() < 12 || normal.z() < 0.35) continue;
      addCornerNoise(view, kNoisePx, random);
      for (Corner& corner : view.corners) corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
      scene.views[c].views.push_back(std::move(view));
    }
  }
  return scene;
}

// Errors of the places of the cameras in the frame of the first one, m, and in their standard deviations.
struct PlaceErrors {
  double squares_m2 = 0;
  double squares = 0;
  int count = 0;
};

void addPlaceErrors(const RigScene& scene, const RigCalibration& rig, PlaceErrors& errors) {
  for (std::size_t c = 1; c < scene.cameras.size(); ++c) {
    const SE3 truth = scene.cameras[c].camera_from_rig * scene.cameras.front().camera_from_rig.inverse();
    const Eigen::Vector3d error =
        rig.fit.cameras[c].camera_from_rig.inverse().translation - truth.inverse().translation;
    errors.squares_m2 += error.squaredNorm();
    errors.squares += error.cwiseQuotient(rig.cameras[c].link.position_std_m).squaredNorm();
    errors.count += 3;
  }
}

bool isMotionNamed(const RigCalibration& rig) {
  return !rig.motions.empty() && std::ranges::any_of(rig.diagnoses, [](const Diagnosis& diagnosis) {
    return diagnosis.id == DiagnosisId("camera_moved");
  });
}

TEST(Exposure, DelaysAndJitterAreEstimated) {
  constexpr int kNumSets = 12;
  PlaceErrors errors;
  double delay_squares = 0;
  for (std::uint64_t seed = 1; seed <= kNumSets; ++seed) {
    const WavedBoard wave{.times = {.delays = {0, 0.3, -0.12}, .jitter = 0.02}};
    const RigScene scene = wavedScene(wave, seed);
    const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
    ASSERT_TRUE(rig.exposure.has_value()) << seed;
    EXPECT_THAT(rig.diagnoses, Contains(Field(&Diagnosis::id, testing::Eq("exposures_differ"))));
    EXPECT_TRUE(rig.links.unlinked.empty()) << seed;
    EXPECT_THAT(rig.diagnoses, Not(Contains(Field(&Diagnosis::id, testing::Eq("camera_moved"))))) << seed;
    EXPECT_TRUE(rig.isUsable()) << seed;
    for (const std::size_t c : {1U, 2U}) {
      const double error = rig.fit.cameras[c].delay - wave.times.delays[c];
      delay_squares += std::pow(error / rig.cameras[c].link.delay_std_intervals, 2);
      EXPECT_LT(std::abs(error), 0.03) << seed;
    }
    addPlaceErrors(scene, rig, errors);
  }
  ASSERT_EQ(errors.count, 6 * kNumSets);
  std::printf("places: RMS %.2f mm, in deviations %.2f; delays, in deviations %.2f\n",
              1e3 * std::sqrt(errors.squares_m2 / errors.count), std::sqrt(errors.squares / errors.count),
              std::sqrt(delay_squares / (2 * kNumSets)));
  EXPECT_LT(std::sqrt(errors.squares_m2 / errors.count), 0.0012);
  EXPECT_GT(std::sqrt(errors.squares / errors.count), 0.7);
  EXPECT_LT(std::sqrt(errors.squares / errors.count), 1.3);
  // Errors of the path are common to all frames and not part of the deviations of the delays.
  EXPECT_LT(std::sqrt(delay_squares / (2 * kNumSets)), 1.6);
}

TEST(Exposure, SynchronousCamerasHaveNone) {
  int num_sets = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RigScene scene = wavedScene({}, seed);
    if (seed > 3)
      std::swap(scene.views[1].views[5].corners, scene.views[1].views[6].corners);  // two wrong frames
    const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
    EXPECT_FALSE(rig.exposure.has_value()) << seed;
    EXPECT_EQ(rig.links.unlinked.size(), seed > 3 ? 2U : 0U) << seed;
    ++num_sets;
  }
  EXPECT_EQ(num_sets, 6);
}

TEST(Exposure, DelaysWithoutJitterAreFound) {
  int num_found = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const RigScene scene = wavedScene({.times = {.delays = {0, 0.3, -0.12}}}, seed);
    const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
    ASSERT_TRUE(rig.exposure.has_value()) << seed;
    EXPECT_NEAR(rig.fit.cameras[1].delay, 0.3, 0.01) << seed;
    EXPECT_NEAR(rig.fit.cameras[2].delay, -0.12, 0.01) << seed;
    EXPECT_LT(rig.exposure->std_intervals, 0.006) << seed;
    num_found += rig.isUsable() && rig.links.unlinked.empty() ? 1 : 0;
  }
  EXPECT_EQ(num_found, 4);
}

TEST(Exposure, WrongFramesAreFoundAmongJitter) {
  int num_found = 0;
  int num_others = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    RigScene scene = wavedScene({.times = {.delays = {0, 0.1, 0}, .jitter = 0.02}}, seed);
    std::swap(scene.views[1].views[9].corners, scene.views[1].views[14].corners);
    const std::string& first = scene.views[1].views[9].image;
    const std::string& second = scene.views[1].views[14].image;
    const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
    // Of two views that contradict each other, either may be wrong.
    for (const RigImage& image : rig.links.unlinked)
      ++(image.frame + ".png" == first || image.frame + ".png" == second ? num_found : num_others);
  }
  std::printf("wrong frames found: %d of 12; others: %d\n", num_found, num_others);
  EXPECT_EQ(num_found, 12);
  EXPECT_EQ(num_others, 0);
}

TEST(Exposure, MovedCameraOfTwoIsFound) {
  int num_found = 0;
  int num_sets = 0;
  for (const double moved_m : {0.003, 0.01, 0.03}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      RigScene scene = wavedScene({.moved_from = 20, .moved_m = moved_m}, seed);
      scene.cameras.erase(scene.cameras.begin());
      scene.views.erase(scene.views.begin());
      const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
      ++num_sets;
      num_found += !rig.isUsable() || isMotionNamed(rig) ? 1 : 0;
    }
  }
  std::printf("moved cameras found: %d of %d\n", num_found, num_sets);
  EXPECT_EQ(num_found, 18);
}

TEST(Exposure, MovedCameraIsFoundAmongJitter) {
  int num_found = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const RigScene scene = wavedScene({.times = {.jitter = 0.02}, .moved_from = 20}, seed);
    const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
    num_found += isMotionNamed(rig) ? 1 : 0;
  }
  std::printf("moved cameras found: %d of 8\n", num_found);
  EXPECT_GE(num_found, 7);
}

TEST(Starts, AreFoundByTheMotion) {
  int num_sets = 0;
  std::size_t num_unlinked = 0;
  PlaceErrors errors;
  for (const double step_m : {0.012, 0.05}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const WavedBoard wave{.num_frames = 50, .step_m = step_m, .times = {.delays = {0, 7.3, -12.1}}};
      const RigScene scene = wavedScene(wave, seed);
      const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
      // The image that shows an instant has a smaller number if the recording started later.
      EXPECT_EQ(rig.frames.leads[1] - rig.frames.leads[0], -7) << step_m << " " << seed;
      EXPECT_EQ(rig.frames.leads[2] - rig.frames.leads[0], 12) << step_m << " " << seed;
      EXPECT_THAT(rig.diagnoses, Contains(Field(&Diagnosis::id, testing::Eq("starts_differ"))));
      EXPECT_NEAR(rig.fit.cameras[1].delay, 0.3, 0.03) << step_m << " " << seed;
      EXPECT_NEAR(rig.fit.cameras[2].delay, -0.1, 0.03) << step_m << " " << seed;
      num_unlinked += rig.links.unlinked.size();
      addPlaceErrors(scene, rig, errors);
      ++num_sets;
    }
  }
  EXPECT_EQ(num_sets, 8);
  std::printf("places: RMS %.2f mm, in deviations %.2f; %zu views contradict\n",
              1e3 * std::sqrt(errors.squares_m2 / errors.count), std::sqrt(errors.squares / errors.count),
              num_unlinked);
  EXPECT_LE(num_unlinked, 2U);
  EXPECT_LT(std::sqrt(errors.squares_m2 / errors.count), 0.0015);
}

// Before a camera that never sees the board together with another one, it moves like before any other.
TEST(Starts, AreUnknownWithoutCommonFrames) {
  int num_parts = 0;
  for (const double step_m : {0.004, 0.01, 0.03}) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      RigScene scene = wavedScene({.num_frames = 80, .step_m = step_m}, seed);
      for (std::size_t c = 0; c < 2; ++c) {
        std::erase_if(scene.views[c].views,
                      [&](const View& view) { return (view.image < "frame1040.png") != (c == 0); });
      }
      scene.views.pop_back();
      scene.cameras.pop_back();
      const std::string message =
          messageOf([&] { (void)calibrate(kCharuco, scene.views, optionsFor(scene)); });
      num_parts += message.find("nothing links") != std::string::npos ? 1 : 0;
    }
  }
  std::printf("parts told: %d of 24\n", num_parts);
  EXPECT_EQ(num_parts, 24);
}

TEST(Starts, AreEqualForPhotographsAndForBoardsThatStandStill) {
  int num_sets = 0;
  const auto expectNone = [&](const RigScene& scene) {
    const RigCalibration rig = calibrate(kCharuco, scene.views, optionsFor(scene));
    EXPECT_FALSE(rig.frames.areShifted()) << num_sets;
    ++num_sets;
  };
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
    expectNone(sceneOf(threeCameras(), kCharuco, 12 + static_cast<int>(seed), 0.1, seed));
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    expectNone(wavedScene({.num_frames = 60, .step_m = 0.008}, seed));
    expectNone(wavedScene({.num_frames = 30, .times = {.delays = {0, 0.3, -0.3}, .jitter = 0.05}}, seed));
  }
  EXPECT_EQ(num_sets, 20);
}

}  // namespace
}  // namespace alidade
