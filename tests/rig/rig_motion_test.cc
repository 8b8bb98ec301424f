// SPDX-License-Identifier: MIT
// Cameras that never see one board at the same time, linked by boards that are fixed to each other.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gmock/gmock.h>

#include "body_scene.h"
#include "support/message_of.h"

namespace alidade {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

constexpr double kNoisePx = 0.1;
constexpr double kDegrees = 180 / std::numbers::pi;

RigCalibration calibrated(const RigScene& scene, const std::vector<Board>& boards) {
  return calibrate(boards, scene.views, optionsFor(scene));
}

struct Shape {
  const char* name;
  BodyRig rig;
  double rms_deg;  // bounds of the RMS error over cameras and sets
  double rms_mm;
};

std::vector<Shape> shapes() {
  return {{"facing apart", facingApart(), 0.015, 0.5},
          {"ring of six", ringOfSix(), 0.012, 0.35},
          {"car surround", carSurround(), 0.01, 0.4},
          {"two pairs", twoPairs(), 0.012, 0.45},
          {"around a body", aroundBody(), 0.016, 0.7}};
}

// Errors of the cameras' poses, and how many coordinates their 95 % intervals contain.
struct PoseErrors {
  double squares_rad = 0;
  double squares_m = 0;
  int num_poses = 0;
  int num_covered = 0;

  void add(const RigScene& scene, const RigCalibration& rig) {
    for (std::size_t c = 1; c < rig.cameras.size(); ++c) {
      const auto error = poseError(scene, rig, c);
      squares_m += error.head<3>().squaredNorm();
      squares_rad += error.tail<3>().squaredNorm();
      ++num_poses;
      const CameraLink& link = rig.cameras[c].link;
      for (int i = 0; i < 6; ++i) {
        const double std = i < 3 ? link.translation_std_m(i) : link.rotation_std_rad(i - 3);
        num_covered += std::abs(error(i)) < 1.96 * std ? 1 : 0;
      }
    }
  }
  [[nodiscard]] double degrees() const { return kDegrees * std::sqrt(squares_rad / num_poses); }
  [[nodiscard]] double millimetres() const { return 1000 * std::sqrt(squares_m / num_poses); }
  [[nodiscard]] double covered() const { return num_covered / (6.0 * num_poses); }
};

PoseErrors errorsOf(const Shape& shape, int num_sets, std::uint64_t first_seed) {
  PoseErrors errors;
  int num_noted = 0;
  for (int set = 0; set < num_sets; ++set) {
    const RigScene scene = sceneOf(shape.rig, 30, kNoisePx, first_seed + static_cast<std::uint64_t>(set));
    const RigCalibration rig = calibrated(scene, shape.rig.boards);
    EXPECT_NE(rig.verdict(), Verdict::kNo) << shape.name << " " << set << ": " << rig.diagnoses.front().cause;
    EXPECT_EQ(rig.links.unlinked.size(), 0U) << shape.name << " " << set;
    EXPECT_FALSE(rig.exposure) << shape.name << " " << set;
    num_noted += rig.links.common_part_of.empty() ? 0 : 1;
    EXPECT_EQ(!rig.links.common_part_of.empty(), testing::Matches(hasDiagnosis("linked_by_motion"))(rig));
    errors.add(scene, rig);
  }
  std::printf("%s: %.4f degrees, %.2f mm; %.1f %% of %d covered; %d of %d sets linked by motion\n",
              shape.name, errors.degrees(), errors.millimetres(), 100 * errors.covered(),
              6 * errors.num_poses, num_noted, num_sets);
  return errors;
}

TEST(RigMotion, LinksCamerasThatSeeNoBoardTogether) {
  int num_shapes = 0;
  for (const Shape& shape : shapes()) {
    const PoseErrors errors = errorsOf(shape, 2, 10);
    EXPECT_LT(errors.degrees(), 2 * shape.rms_deg) << shape.name;
    EXPECT_LT(errors.millimetres(), 2 * shape.rms_mm) << shape.name;
    EXPECT_GT(errors.covered(), 0.75) << shape.name;
    ++num_shapes;
  }
  EXPECT_EQ(num_shapes, 5);
}

TEST(ManyRigMotions, AreAsAccurateAsStated) {
  const char* given = std::getenv("ALIDADE_NUM_SETS");
  const int num_sets = given == nullptr ? 20 : std::atoi(given);
  double num_covered = 0;
  double count = 0;
  for (const Shape& shape : shapes()) {
    const PoseErrors errors = errorsOf(shape, num_sets, 1000);
    EXPECT_LT(errors.degrees(), shape.rms_deg) << shape.name;
    EXPECT_LT(errors.millimetres(), shape.rms_mm) << shape.name;
    EXPECT_GT(errors.covered(), 0.90) << shape.name;
    num_covered += errors.num_covered;
    count += 6 * errors.num_poses;
  }
  EXPECT_GE(count, 5 * 6 * num_sets);
  EXPECT_GT(num_covered / count, 0.92);
  EXPECT_LT(num_covered / count, 0.98);
}

// Turns about one axis leave the offset along it open, no turns everything.
TEST(RigMotion, IsNamedWhereItTellsTooLittle) {
  int num_named = 0;
  for (BodyRig rig : {facingApart(), aroundBody()}) {
    for (const Eigen::Vector3d& turns : {Eigen::Vector3d(0, 0.5, 0), Eigen::Vector3d(0, 0, 0)}) {
      rig.turns_rad = turns;
      rig.steps_m = {0.2, 0.2, 0.2};
      for (std::uint64_t seed = 0; seed < 3; ++seed) {
        const RigScene scene = sceneOf(rig, 30, kNoisePx, 50 + seed);
        const std::string message = messageOf([&] { (void)calibrated(scene, rig.boards); });
        EXPECT_THAT(message, HasSubstr("too little motion to link camera0 | camera1"));
        EXPECT_THAT(message, HasSubstr("see no board together"));
        if (turns.y() > 0) {
          EXPECT_THAT(message, HasSubstr("degrees about the vertical axis (y) of camera"));
        }
        num_named += message.find("too little motion") != std::string::npos ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(num_named, 12);
}

// The axis is named where the answer is uncertain for lack of turns about another one.
TEST(RigMotion, AdvisesTurnsAboutTheOtherAxis) {
  BodyRig rig = facingApart();
  rig.turns_rad = {0.05, 0.5, 0.05};
  int num_advised = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const RigCalibration found = calibrated(sceneOf(rig, 30, kNoisePx, 70 + seed), rig.boards);
    const auto weak = std::ranges::find(found.diagnoses, "weak_link", &Diagnosis::id);
    ASSERT_NE(weak, found.diagnoses.end());
    EXPECT_THAT(weak->next_step, HasSubstr("about a second axis, too: it turned by"));
    EXPECT_THAT(weak->next_step, HasSubstr("about the vertical axis (y) of camera0"));
    ++num_advised;
  }
  EXPECT_EQ(num_advised, 4);
}

// The middle boards alone, as each camera sees them in these frames.
RigScene middleBoards(const BodyRig& rig, std::uint64_t seed) {
  RigScene scene = sceneOf(rig, 30, kNoisePx, seed);
  for (RigViews& views : scene.views)
    std::erase_if(views.views, [](const View& view) { return view.board % 3 != 1; });
  return scene;
}

// A board for each camera, each moved by a hand of its own.
TEST(RigMotion, DoesNotLinkBoardsThatMoveApart) {
  BodyRig rig = facingApart();
  rig.num_own = 0;
  int num_refused = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    RigScene scene = middleBoards(rig, 100 + seed);
    scene.views[1] = middleBoards(rig, 200 + seed).views[1];
    const std::string message = messageOf([&] { (void)calibrated(scene, rig.boards); });
    EXPECT_THAT(message, HasSubstr("cameras that nothing links: camera0 | camera1")) << seed;
    num_refused += message.empty() ? 0 : 1;
  }
  EXPECT_EQ(num_refused, 12);
}

// A board that moves relative to the others in the middle of the frames is a contradiction.
TEST(RigMotion, IsContradictedByABoardThatMoves) {
  BodyRig rig = facingApart();
  rig.num_own = 0;
  int num_named = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    RigScene scene = middleBoards(rig, 300 + seed);
    BodyRig moved = rig;
    moved.body_from_board[4] =
        moved.body_from_board[4] * turnedAbout(Eigen::Vector3d::UnitX(), 5, {0.02, 0.05, 0});
    const RigScene later = middleBoards(moved, 300 + seed);
    for (std::size_t v = 0; v < scene.views[1].views.size(); ++v) {
      View& view = scene.views[1].views[v];
      for (const View& other : later.views[1].views) {
        if (v >= 15 && other.image == view.image) view = other;
      }
    }
    try {
      const RigCalibration found = calibrated(scene, rig.boards);
      EXPECT_NE(found.verdict(), Verdict::kTrustworthy) << seed;
      const bool is_named = testing::Matches(hasDiagnosis("not_simultaneous"))(found) ||
                            testing::Matches(hasDiagnosis("camera_moved"))(found);
      EXPECT_TRUE(is_named) << seed;
      num_named += is_named ? 1 : 0;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("nothing links")) << seed;
      ++num_named;
    }
  }
  EXPECT_EQ(num_named, 8);
}

// Prints of one board, one before each camera. One of the two looks the same after a half turn, and a fifth
// of its views are numbered from the other end.
TEST(RigMotion, LinksPrintsOfOneBoard) {
  int num_linked = 0;
  for (const Board& board :
       {wallBoard(0.1), Board(Checkerboard{.columns = 8, .rows = 6, .square_m = 0.12})}) {
    BodyRig rig{.cameras = {radtanAt({}), radtanAt(cameraAt({0.05, 0.02, -0.1}, 180))},
                .boards = {board, board},
                .body_from_board = {}};
    for (const TrueCamera& camera : rig.cameras)
      rig.body_from_board.push_back(boardBefore(camera, board, 1.6));
    rig.turns_rad = {0.45, 0.45, 0.6};
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      RigScene scene = sceneOf(rig, 30, kNoisePx, 400 + seed);
      for (RigViews& views : scene.views) {
        for (std::size_t v = 0; v < views.views.size(); ++v) {
          View& view = views.views[v];
          view.board = 0;
          if (board.markers() || v % 5 != 2) continue;
          for (Corner& corner : view.corners) corner.id = board.numCorners() - 1 - corner.id;
          std::ranges::sort(view.corners, {}, &Corner::id);
        }
      }
      const RigCalibration found = calibrated(scene, {board});
      EXPECT_NE(found.verdict(), Verdict::kNo) << seed;
      ASSERT_THAT(found, hasDiagnosis("linked_by_motion")) << seed;
      EXPECT_EQ(found.links.unlinked.size(), 0U) << seed;
      EXPECT_FALSE(found.exposure) << seed;
      const auto error = poseError(scene, found, 1);
      const CameraLink& link = found.cameras[1].link;
      EXPECT_LT(error.head<3>().norm(), 4 * link.translation_std_m.norm()) << seed;
      EXPECT_LT(error.head<3>().norm(), 0.02) << seed;
      ++num_linked;
    }
  }
  EXPECT_EQ(num_linked, 8);
}

}  // namespace
}  // namespace alidade
