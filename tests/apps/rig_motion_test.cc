// SPDX-License-Identifier: MIT
// Rigs whose cameras see no board together, from the command line.
#include <nlohmann/json.hpp>

#include "alidade/files/corners_file.h"
#include "alidade/files/rig_file.h"
#include "apps/command_line.h"
#include "apps/report_page.h"
#include "rig/body_scene.h"
#include "support/scratch_folder.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Two cameras back to back, each before a board of its own.
BodyRig backToBack(const std::vector<Board>& boards) {
  BodyRig rig{.cameras = {radtanAt({}), radtanAt(cameraAt({0.05, 0.02, -0.1}, 180))},
              .boards = boards,
              .body_from_board = {}};
  for (std::size_t c = 0; c < 2; ++c)
    rig.body_from_board.push_back(boardBefore(rig.cameras[c], rig.boards[c], 1.5));
  rig.turns_rad = {0.45, 0.45, 0.6};
  return rig;
}

class RigOfMotion : public testing::Test {
 protected:
  // front.csv and back.csv
  void write(const BodyRig& rig, std::uint64_t seed, const std::string& folder = "") {
    const RigScene scene = sceneOf(rig, 30, 0.1, seed);
    for (std::size_t c = 0; c < 2; ++c) {
      CornersFile file;
      file.camera = c == 0 ? "front" : "back";
      file.boards = {rig.boards.front()};
      if (rig.boards[1].spec() != rig.boards[0].spec()) file.boards.push_back(rig.boards[1]);
      file.views = scene.views[c].views;
      for (View& view : file.views) view.board = std::min(view.board, file.boards.size() - 1);
      writeCornersFile(scratch_.path(folder + file.camera + ".csv"), file);
    }
  }
  [[nodiscard]] RunResult calibrate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> args = {
        "rig", "calibrate", scratch_.path("front.csv"), scratch_.path("back.csv"), "--model", "radtan"};
    args.insert(args.end(), more.begin(), more.end());
    return runAlidade(args);
  }

  ScratchFolder scratch_;
};

TEST_F(RigOfMotion, IsCalibratedAndSaysSo) {
  const BodyRig rig = backToBack({wallBoard(0.1), Checkerboard{.columns = 9, .rows = 6, .square_m = 0.12}});
  write(rig, 5);
  const RunResult result = calibrate({"-o", scratch_.path("rig.yaml"), "--report", scratch_.path("rig.html"),
                                      "--evidence", scratch_.path("rig.json")});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out,
              HasSubstr("2 cameras; linked by boards that do not move relative to each other, in 29 frames"));
  EXPECT_THAT(calibrate({"--verbose"}).out,
              HasSubstr("front | back see one board together in few frames or none"));
  const RigRecord found = loadRig(scratch_.path("rig.yaml"));
  const SE3 error = rig.cameras[1].camera_from_rig.inverse() * found.cameras[1].camera_from_rig;
  EXPECT_LT(error.translation.norm(), 0.01);
  EXPECT_LT(error.rotation.log().norm(), 0.003);
  // Each board is drawn where it was.
  const auto evidence = nlohmann::json::parse(scratch_.read("rig.json"));
  EXPECT_EQ(evidence.at("boards").size(), 2u);
  EXPECT_EQ(evidence.at("placements").size(), 59u);
  EXPECT_THAT(scratch_.read("rig.html"), HasSubstr("link them"));

  // The rig agrees with other images of it, and not with those of another one.
  write(rig, 6);
  const std::vector<std::string> validate = {
      "rig",    "validate", scratch_.path("rig.yaml"), scratch_.path("front.csv"), scratch_.path("back.csv"),
      "--quiet"};
  EXPECT_THAT(runAlidade(validate), EndsWith(0));
  BodyRig moved = rig;
  moved.cameras[1].camera_from_rig = cameraAt({0.05, 0.02, -0.1}, 181);
  write(moved, 6);
  EXPECT_THAT(
      runAlidade(validate),
      FailsWith(
          3, testing::ContainsRegex(
                 "back stands elsewhere.* degrees, which moves points on the boards by 1[56]\\.[0-9]* px")));
}

TEST_F(RigOfMotion, RefusesABoardOfTwoSizes) {
  write(backToBack({wallBoard(0.1), wallBoard(0.09)}), 9);
  EXPECT_THAT(calibrate({"--quiet"}),
              FailsWith(1, AllOf(HasSubstr("back.csv: the board charuco:11x8:90mm"),
                                 HasSubstr("the same lengths of a board for all cameras"))));
}

TEST_F(RigOfMotion, MayHavePrintsOfOneBoard) {
  write(backToBack({wallBoard(0.1), wallBoard(0.1)}), 7);
  const RunResult result = calibrate();
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, HasSubstr("linked by boards that do not move relative to each other"));
  EXPECT_THAT(calibrate({"--verbose"}).out, HasSubstr("each part sees a print of the board of its own"));
}

TEST_F(RigOfMotion, NamesTheAxisThatIsMissing) {
  BodyRig rig = backToBack({wallBoard(0.1), Checkerboard{.columns = 9, .rows = 6, .square_m = 0.12}});
  rig.turns_rad = {0, 0.5, 0};
  write(rig, 8);
  EXPECT_THAT(
      calibrate({"-o", scratch_.path("rig.yaml"), "--quiet"}),
      FailsWith(1, AllOf(HasSubstr("too little motion to link front | back"),
                         HasSubstr("degrees about the vertical axis (y) of back"), HasSubstr("next: tilt"))));
  EXPECT_FALSE(scratch_.has("rig.yaml"));
}

}  // namespace
}  // namespace alidade
