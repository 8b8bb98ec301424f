// SPDX-License-Identifier: MIT
// --board given more than once.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "alidade/files.h"
#include "alidade/files/corners_file.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "alidade/target/board_spec.h"
#include "apps/command_line.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string kCharuco = "charuco:11x8:50mm:37.5mm:DICT_4X4_250";
const std::string kGrid = "aprilgrid:6x5:60mm:0.3:100";

// Corners of boards, the first of which is bent by a millimetre; every other image shows only one of them.
CornersFile simulatedCorners(const std::vector<std::string>& specs, int num_images) {
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{900, 902, 640, 478, -0.25, 0.08, 4e-4, -3e-4, 0});
  CornersFile file;
  Random random(7);
  for (std::size_t b = 0; b < specs.size(); ++b) {
    const Board board = parseBoardSpec(specs[b]);
    file.boards.push_back(board);
    const std::vector<SE3> poses = randomViews(camera, kQuadVga, board, num_images, random);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (i % 2 == 1 && i / 2 % specs.size() != b) continue;
      View view{.image = fmt::format("image_{:02}.png", i), .size = kQuadVga, .corners = {}, .board = b};
      for (int id = 0; id < board.numCorners(); ++id) {
        const BoardShape shape{.bend_x_m = b == 0 ? 0.001 : 0.0};
        const Projection projection = camera.project(poses[i] * onBentBoard(board, shape, board.corner(id)));
        if (projection.ok()) view.corners.push_back({.id = id, .pixel = projection.pixel});
      }
      addCornerNoise(view, 0.05, random);
      file.views.push_back(std::move(view));
    }
  }
  return file;
}

std::size_t numLines(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count(text, '\n'));
}

TEST(SeveralBoardsCommand, CalibratesFromACornersFileOfSeveralBoards) {
  const ScratchFolder scratch;
  const CornersFile corners = simulatedCorners({kCharuco, kGrid}, 16);
  writeCornersFile(scratch.path("corners.csv"), corners);
  const std::string camera = scratch.path("camera.yaml");
  const RunResult run = runAlidade({"calibrate", scratch.path("corners.csv"), "--model", "radtan", "-o",
                                    camera, "--evidence", scratch.path("evidence.json")});
  ASSERT_THAT(run, EndsWith(0)) << run.err;
  EXPECT_LE(numLines(run.out), 16U) << run.out;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("24 views in 16 of 16 images"), HasSubstr(kCharuco + " in 12 views, bent by"),
                    HasSubstr(kGrid + " in 12 views, flat"), HasSubstr("put the board " + kCharuco)));

  const auto record = loadCamera(camera).calibration.value();
  EXPECT_THAT(record.boards, testing::ElementsAre(kCharuco, kGrid));
  ASSERT_EQ(record.warps.size(), 1U);
  EXPECT_EQ(record.warps[0].board, 0U);
  EXPECT_NEAR(record.warps[0].shape.bend_x_m, 0.001, 5 * record.warps[0].std_m.x());

  const auto evidence = nlohmann::json::parse(readFile(scratch.path("evidence.json")));
  EXPECT_EQ(evidence.at("board"), (nlohmann::json{kCharuco, kGrid}));
  EXPECT_EQ(evidence.at("images").at("used"), 16);
  ASSERT_EQ(evidence.at("views").size(), 24U);
  std::size_t num_of_grid = 0;
  for (const auto& view : evidence.at("views")) num_of_grid += view.at("board") == kGrid ? 1 : 0;
  EXPECT_EQ(num_of_grid, 12U);
  ASSERT_EQ(evidence.at("board_shape").size(), 2U);
  EXPECT_EQ(evidence.at("board_shape")[0].at("estimated"), true);
  EXPECT_EQ(evidence.at("board_shape")[1].at("estimated"), false);
  EXPECT_EQ(evidence.at("board_shape")[1].at("board"), kGrid);
  EXPECT_EQ(evidence.at("common_errors").at("boards").size(), 2U);
  EXPECT_TRUE(evidence.at("common_errors").at("boards")[1].contains("stretch"));

  // The file can be checked, also on images of several boards.
  EXPECT_THAT(runAlidade({"validate", camera}), EndsWith(0));
  const RunResult tested =
      runAlidade({"validate", camera, "--images", scratch.path("corners.csv"), "--verbose"});
  EXPECT_THAT(tested, EndsWith(0)) << tested.out;

  const RunResult details =
      runAlidade({"calibrate", scratch.path("corners.csv"), "--model", "radtan", "--verbose"});
  EXPECT_THAT(details.out, AllOf(HasSubstr("Board    " + kCharuco + ": 12 views\n         bent ("),
                                 HasSubstr("Board    " + kGrid + ": 12 views\n         flat: ")));
}

TEST(SeveralBoardsCommand, KeepsTheSummaryShortForManyBoards) {
  const ScratchFolder scratch;
  std::vector<std::string> specs;
  for (int i = 0; i < 6; ++i) specs.push_back(fmt::format("aprilgrid:4x4:60mm:0.3:{}", 16 * i));
  writeCornersFile(scratch.path("corners.csv"), simulatedCorners(specs, 12));
  const RunResult run = runAlidade(
      {"calibrate", scratch.path("corners.csv"), "--model", "thin_prism", "--target-sigma", "0.001px"});
  EXPECT_LE(numLines(run.out), 16U) << run.out;
  EXPECT_THAT(run.out, HasSubstr("boards: see --verbose"));
}

TEST(SeveralBoardsCommand, TakesPiecesOfDifferentBoards) {
  const ScratchFolder scratch;
  const CornersFile all = simulatedCorners({kCharuco, kGrid}, 16);
  writeCornersFile(scratch.path("all.csv"), all);
  std::vector<std::string> pieces;
  for (std::size_t b = 0; b < 2; ++b) {
    CornersFile piece{.boards = {all.boards[b]}, .views = {}, .comments = {}};
    for (View view : all.views) {
      if (view.board != b) continue;
      view.board = 0;
      piece.views.push_back(std::move(view));
    }
    pieces.push_back(scratch.path(fmt::format("piece_{}.csv", b)));
    writeCornersFile(pieces.back(), piece);
  }
  const RunResult whole = runAlidade({"calibrate", scratch.path("all.csv"), "--model", "radtan", "--json"});
  const RunResult joined = runAlidade({"calibrate", pieces[0], pieces[1], "--model", "radtan", "--json"});
  ASSERT_THAT(whole, EndsWith(0)) << whole.err;
  EXPECT_EQ(whole.out, joined.out);
  EXPECT_EQ(runAlidade({"calibrate", scratch.path("all.csv"), "--model", "radtan", "--json", "--board", kGrid,
                        "--board", kCharuco})
                .out,
            whole.out)
      << "the boards that the file states";
  EXPECT_THAT(runAlidade({"calibrate", scratch.path("all.csv"), "--board", kGrid}),
              FailsWith(1, AllOf(HasSubstr(kCharuco + " and " + kGrid), HasSubstr("remove --board"))));
}

TEST(SeveralBoardsCommand, FindsTheBoardThatIsThereAndNamesTheOther) {
  const ScratchFolder scratch;
  const std::string folder = linkImages(scratch, "photos", 4);
  const std::string other = "aprilgrid:6x6:88mm:0.3";
  const RunResult detected = runAlidade({"detect", folder, "--board", kBoardSpec, "--board", other, "-o",
                                         scratch.path("corners.csv"), "--debug", scratch.path("drawn")});
  ASSERT_THAT(detected, EndsWith(0)) << detected.err;
  EXPECT_THAT(detected.err, AllOf(HasSubstr("warning: no image shows the board " + other),
                                  HasSubstr("4 of 4 images show a board; written to"),
                                  HasSubstr(std::string(kBoardSpec) + ": 4 of 4 images show the whole board"),
                                  Not(HasSubstr("view_001.png: no_board"))));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path("drawn")), {}), 4);
  const CornersFile file = readCornersFile(scratch.path("corners.csv"));
  EXPECT_EQ(file.boards.size(), 1U) << "of the other one there are no corners";
  EXPECT_EQ(file.views.size(), 4U);
  EXPECT_THAT(readFile(scratch.path("corners.csv")),
              AllOf(HasSubstr("# images of " + std::string(kBoardSpec)), HasSubstr("# images of " + other)));

  const RunResult as_json = runAlidade({"detect", folder, "--board", kBoardSpec, "--board", other, "--json"});
  const auto document = nlohmann::json::parse(as_json.out);
  ASSERT_EQ(document.at("boards").size(), 2U);
  EXPECT_EQ(document.at("boards")[0].at("board"), kBoardSpec);
  EXPECT_EQ(document.at("boards")[1].at("images")[0].at("reason"), "no_board");

  // What follows a SPEC is an input.
  EXPECT_THAT(runAlidade({"detect", "--board", kBoardSpec, "--board", other, folder, "--quiet"}),
              EndsWith(0));
  scratch.write("settings.yaml", fmt::format("board: ['{}', '{}']\n", kBoardSpec, other));
  const RunResult by_file =
      runAlidade({"detect", folder, "--config", scratch.path("settings.yaml"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(by_file.out).at("boards").size(), 2U);

  const RunResult calibrated = runAlidade({"calibrate", linkImages(scratch, "more", 12), "--board",
                                           kBoardSpec, "--board", other, "-o", scratch.path("camera.yaml")});
  ASSERT_THAT(calibrated, EndsWith(0)) << calibrated.err;
  EXPECT_THAT(calibrated.err, HasSubstr("warning: no image shows the board " + other));
  EXPECT_THAT(calibrated.out, HasSubstr(other + ", not used"));
  EXPECT_THAT(loadCamera(scratch.path("camera.yaml")).calibration->boards, testing::ElementsAre(kBoardSpec));
}

TEST(SeveralBoardsCommand, RefusesWhatCannotBe) {
  const ScratchFolder scratch;
  const std::string folder = linkImages(scratch, "photos", 2);
  struct Case {
    std::string board;
    std::string other;
    int exit_code;
    std::string complaint;
  };
  const std::vector<Case> cases = {
      {kBoardSpec, kBoardSpec, 2, "the same board twice"},
      {kBoardSpec, "checkerboard:9x6:30mm", 2, "the same numbers of corners"},
      {"aprilgrid:6x6:88mm:0.3", "aprilgrid:4x4:60mm:0.3:30", 2, "another first id"},
      {"charuco:8x11:24mm:18mm:DICT_4X4_250", "charuco:5x7:24mm:18mm:DICT_4X4_50", 2, "another first id"},
      {kBoardSpec, "chekerboard:9x7:25mm", 2, "did you mean 'checkerboard'"},
      {"aprilgrid:6x6:88mm:0.3", "checkerboard:12x8:25mm", 1, "no board ("},
  };
  std::size_t num_checked = 0;
  for (const Case& c : cases) {
    for (const std::string command : {"detect", "calibrate"}) {
      EXPECT_THAT(runAlidade({command, folder, "--board", c.board, "--board", c.other}),
                  FailsWith(c.exit_code, HasSubstr(c.complaint)));
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 12U);
}

}  // namespace
}  // namespace alidade
