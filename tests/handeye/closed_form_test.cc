// SPDX-License-Identifier: MIT
#include "alidade/geometry/hand_eye_form.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "alidade/core/degrees.h"
#include "robot_scenes.h"

namespace alidade {
namespace {

// Exact frames of some boards, which are seen in turn.
struct SeenSet {
  SE3 mount_from_camera;
  std::vector<SE3> world_from_boards;
  std::vector<SeenFrom> frames = {};
};

SeenSet seenSet(CameraOn camera_on, int num_frames, std::size_t num_boards, std::uint64_t seed) {
  const RobotSet set = simulateRobot(robotScene(camera_on, {}, 0, num_frames), seed);
  SeenSet seen{set.mount_from_camera, {}};
  for (std::size_t b = 0; b < num_boards; ++b) {
    const double step = 0.1 * static_cast<double>(b);
    seen.world_from_boards.push_back(set.world_from_boards[0] *
                                     SE3{SO3::exp({step, -step, 2 * step}), {step, 0, step}});
  }
  for (std::size_t i = 0; i < set.views.size(); ++i) {
    const std::size_t board = i % num_boards;
    seen.frames.push_back({.motion = motionOf(camera_on, set.base_from_gripper[i]),
                           .camera_from_board = cameraFromBoard(set, i, seen.world_from_boards[board]),
                           .board = board});
  }
  return seen;
}

// The largest difference of mount and boards, m and rad.
double errorOf(const ClosedForm& form, const SeenSet& seen) {
  double largest = differenceOf(seen.mount_from_camera, form.mount_from_camera).norm();
  EXPECT_EQ(form.world_from_boards.size(), seen.world_from_boards.size());
  for (std::size_t b = 0; b < seen.world_from_boards.size(); ++b)
    largest = std::max(largest, differenceOf(seen.world_from_boards[b], form.world_from_boards.at(b)).norm());
  return largest;
}

TEST(ClosedForm, FindsTheTruthOfExactFrames) {
  int num_sets = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (const std::size_t num_boards : {1U, 2U, 3U}) {
      for (const int per_board : {3, 4, 10, 33}) {
        SCOPED_TRACE(per_board);
        const int num_frames = per_board * static_cast<int>(num_boards);
        const SeenSet seen = seenSet(camera_on, num_frames, num_boards, 50 + num_frames);
        const ClosedForm form = closedForm(seen.frames, num_boards);
        EXPECT_LT(errorOf(form, seen), 1e-9);
        EXPECT_LT(form.misfit(), 1e-9);
        EXPECT_GT(form.rotation_firmness, 1e-3);
        for (const SeenFrom& frame : seen.frames) EXPECT_LT(leftOver(form, frame).norm(), 1e-9);
        ++num_sets;
      }
    }
  }
  EXPECT_EQ(num_sets, 2 * 3 * 4);
}

TEST(ClosedForm, IsHardlyMovedByAFifthOfWrongFrames) {
  int num_sets = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (std::uint64_t seed = 0; seed < 20; ++seed, ++num_sets) {
      SeenSet seen = seenSet(camera_on, 30, 1, seed);
      Random random(seed);
      for (std::size_t i = 0; i < seen.frames.size(); i += 5) {
        const SE3::Tangent wrong = SE3::Tangent::NullaryExpr([&](Eigen::Index) { return random.normal(); });
        seen.frames[i].motion = seen.frames[i].motion * SE3::exp(0.1 * wrong);
      }
      EXPECT_LT(errorOf(closedForm(seen.frames, 1), seen), 2e-3) << seed;
    }
  }
  EXPECT_EQ(num_sets, 40);
}

TEST(ClosedForm, KnowsTurnsAboutOneAxis) {
  int num_sets = 0;
  for (const CameraOn camera_on : kBothPlaces) {
    for (std::uint64_t seed = 0; seed < 10; ++seed, ++num_sets) {
      SeenSet seen = seenSet(camera_on, 12, 1, seed);
      const SE3 first = seen.frames[0].motion;
      const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 3).normalized();
      Random random(seed);
      for (SeenFrom& frame : seen.frames) {
        frame.motion = SE3{SO3::exp(random.uniform(-1, 1) * axis), {random.uniform(), 0, 0}} * first;
        frame.camera_from_board = seen.mount_from_camera.inverse() * frame.motion * seen.world_from_boards[0];
      }
      const ClosedForm form = closedForm(seen.frames, 1);
      EXPECT_LT(form.rotation_firmness, 1e-12);
      EXPECT_NEAR(std::abs(form.main_axis.dot(seen.mount_from_camera.rotation.inverse() * axis)), 1, 1e-9);
    }
  }
  EXPECT_EQ(num_sets, 20);
}

TEST(ClosedForm, TakesPartsAsOnesThatTellNothingAboutEachOther) {
  SeenSet seen = seenSet(CameraOn::kHand, 20, 1, 4);
  const SE3 moved{SO3::exp({0, 0, 0.1}), {0.1, 0.02, 0}};
  seen.world_from_boards.push_back(seen.world_from_boards[0] * moved);
  for (std::size_t i = 10; i < 20; ++i) {
    SeenFrom& frame = seen.frames[i];
    frame.camera_from_board = frame.camera_from_board * moved;
    frame.board = frame.part = 1;
  }
  EXPECT_LT(errorOf(closedForm(seen.frames, 2), seen), 1e-9);
}

}  // namespace
}  // namespace alidade
