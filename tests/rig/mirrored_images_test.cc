// SPDX-License-Identifier: MIT
// Rigs in which a camera's images are mirrored, and boards that are seen from both sides.
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "alidade/target/board_spec.h"
#include "rig_scene.h"
#include "support/message_of.h"

namespace alidade {
namespace {

using testing::HasSubstr;

// A detector of boards without markers numbers the corners of a mirrored one as those of another view: here,
// with the order of its columns or rows reversed, so that the colour at the first corner stays.
void mirror(const Board& board, View& view) {
  for (Corner& corner : view.corners) {
    corner.pixel.x() = view.size.width - 1 - corner.pixel.x();
    if (board.markers()) continue;
    int column = corner.id % board.columns();
    int row = corner.id / board.columns();
    if (board.columns() % 2 == 0)
      column = board.columns() - 1 - column;
    else
      row = board.rows() - 1 - row;
    corner.id = row * board.columns() + column;
  }
  std::ranges::sort(view.corners, {}, &Corner::id);
}

TEST(MirroredImages, AreNamed) {
  int num_rigs = 0;
  int num_named = 0;
  int num_sound = 0;
  for (const char* spec :
       {"charuco:9x7:30mm:22mm:DICT_5X5_100", "checkerboard:9x6:30mm", "checkerboard:8x5:30mm"}) {
    const Board board = parseBoardSpec(spec);
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      RigScene scene = sceneOf(threeCameras(), board, 14, 0.1, seed);
      ++num_rigs;
      num_sound += calibrate(board, scene.views, optionsFor(scene)).links.unlinked.empty() ? 1 : 0;
      RigViews& mirrored = scene.views[seed % 3];
      for (View& view : mirrored.views) mirror(board, view);
      const std::string message = messageOf([&] { (void)calibrate(board, scene.views, optionsFor(scene)); });
      num_named += message.find("mirrored images of " + mirrored.name + ":") != std::string::npos ? 1 : 0;
    }
  }
  std::printf("mirrored cameras named: %d of %d; sound rigs passed: %d\n", num_named, num_rigs, num_sound);
  EXPECT_EQ(num_rigs, 18);
  EXPECT_EQ(num_named, num_rigs);
  EXPECT_EQ(num_sound, num_rigs);
}

// Two cameras that face each other, with a board between them that is printed through.
TEST(MirroredImages, AreNotTheBacksOfBoards) {
  const Board board = parseBoardSpec("charuco:9x7:30mm:22mm:DICT_5X5_100");
  const SE3 turned = {SO3::exp(Eigen::Vector3d(0, std::numbers::pi, 0)), Eigen::Vector3d(0, 0, 1.2)};
  const std::vector<double> lens = {700, 700, 639.5, 399.5, -0.1, 0.02, 0, 0, 0};
  const std::vector<TrueCamera> cameras = {{AnyCamera::make("radtan", lens), {1280, 800}, SE3()},
                                           {AnyCamera::make("radtan", lens), {1280, 800}, turned}};
  int num_rigs = 0;
  double worst = 0;  // in standard deviations
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    std::vector<RigViews> views = {{.name = "front", .views = {}}, {.name = "back", .views = {}}};
    for (int frame = 0; frame < 25; ++frame) {
      const SE3 at = {SO3::exp({random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), random.uniform(-3, 3)}),
                      {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(0.5, 0.7)}};
      for (std::size_t c = 0; c < cameras.size(); ++c) {
        const SE3 camera_from_board = cameras[c].camera_from_rig * at * SE3{SO3(), -board.middle()};
        View view{.image = "frame" + std::to_string(100 + frame) + ".png", .size = cameras[c].size};
        for (int id = 0; id < board.numCorners(); ++id) {
          const Projection seen = cameras[c].camera.project(camera_from_board * board.corner(id));
          if (seen.ok() && isInOrNearImage(seen.pixel, view.size)) view.corners.push_back({id, seen.pixel});
        }
        addCornerNoise(view, 0.1, random);
        if (view.corners.size() > 12) views[c].views.push_back(std::move(view));
      }
    }
    const RigCalibration rig = calibrate(board, views, {});
    EXPECT_TRUE(rig.isUsable()) << rig.diagnoses.front().message();
    const Eigen::Vector3d off = rig.fit.cameras[1].camera_from_rig.translation - turned.translation;
    worst = std::max(worst, off.norm() / rig.cameras[1].link.translation_std_m.norm());
    const auto mirrored = std::ranges::find(rig.diagnoses, DiagnosisId("mirrored_view"), &Diagnosis::id);
    ASSERT_NE(mirrored, rig.diagnoses.end());
    EXPECT_THAT(mirrored->cause, HasSubstr("back: all views are mirrored"));
    EXPECT_EQ(mirrored->severity, Severity::kNote);
    for (const Diagnosis& diagnosis : rig.cameras[1].calibration.diagnoses) {
      const bool is_mirrored = diagnosis.id == DiagnosisId("mirrored_view");
      EXPECT_TRUE(!is_mirrored || diagnosis.severity == Severity::kNote);
    }
    ++num_rigs;
  }
  std::printf("facing cameras: wrong by at most %.2f standard deviations\n", worst);
  EXPECT_EQ(num_rigs, 6);
  EXPECT_LT(worst, 3);
}

}  // namespace
}  // namespace alidade
