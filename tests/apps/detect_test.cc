// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "alidade/files/corners_file.h"
#include "alidade/imagery/image_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

RunResult detect(const std::vector<int>& images, std::vector<std::string> more = {}) {
  std::vector<std::string> args = {"detect", "--board", kBoardSpec};
  for (const int i : images) args.push_back(imagePath(i));
  args.insert(args.end(), more.begin(), more.end());
  return runAlidade(args);
}

TEST(Detect, WritesTheSameToFilesAndToStandardOutput) {
  const ScratchFolder scratch;
  const RunResult to_file = detect({1, 2}, {"-o", scratch.path("corners.csv")});
  ASSERT_THAT(to_file, EndsWith(0));
  EXPECT_EQ(to_file.out, "");
  EXPECT_THAT(to_file.err, HasSubstr("2 of 2 images show the whole board (54 corners each); written to"));
  const RunResult to_stdout = detect({1, 2});
  ASSERT_THAT(to_stdout, EndsWith(0));
  EXPECT_EQ(to_stdout.out, scratch.read("corners.csv"));
  EXPECT_EQ(detect({2, 1}, {"-o", "-", "--jobs", "2"}).out, to_stdout.out);
  EXPECT_THAT(scratch.list(), ElementsAre("corners.csv"));
}

TEST(Detect, FindsTheTrueCorners) {
  const RunResult result = detect({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, {"--quiet"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_EQ(result.err, "");
  const CornersFile found = parseCornersFile(result.out, "found");
  const CornersFile truth = readCornersFile(dataPath("corners.csv"));
  ASSERT_EQ(found.views.size(), truth.views.size());
  constexpr double kWorstPx = 0.1;  // images with noise; a corner on the wrong square would be 20 px off
  std::size_t num_corners = 0;
  double worst = 0;
  for (std::size_t v = 0; v < found.views.size(); ++v) {
    EXPECT_EQ(found.views[v].image, truth.views[v].image);
    const auto& corners = found.views[v].corners;
    ASSERT_EQ(corners.size(), 54u);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      worst = std::max(worst, (corners[i].pixel - truth.views[v].corners[i].pixel).norm());
      EXPECT_GT(corners[i].sigma_px, 0);
      EXPECT_LT(corners[i].sigma_px, kWorstPx);
    }
    num_corners += corners.size();
  }
  EXPECT_EQ(num_corners, 648u);
  EXPECT_LE(worst, kWorstPx);
}

TEST(Detect, SaysInTheFileWhatCameOfEachImage) {
  const RunResult result = detect({1, 2}, {"--quiet"});
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.out, HasSubstr("\n# image,reason,corners,blur_px,spacing_px,area_share,tilt_deg,"));
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("\n# view_001.png,found,54,"), HasSubstr("\n# view_002.png,found,54,")));
}

TEST(Detect, DrawsWhatItFoundIntoAFolderOfItsOwn) {
  const ScratchFolder scratch;
  const RunResult result =
      detect({1, 2}, {"--debug", scratch.path("drawn"), "-o", scratch.path("corners.csv")});
  ASSERT_THAT(result, EndsWith(0));
  int num_drawn = 0;
  for (const std::string name : {"view_001.png", "view_002.png"}) {
    const std::string path = scratch.path("drawn/" + name + ".detection.png");
    ASSERT_TRUE(std::filesystem::exists(path)) << path;
    const LoadedImage drawn = readGrayImage(path);
    const LoadedImage photo = readGrayImage(dataPath("images/" + name));
    EXPECT_EQ(drawn.image.size, photo.image.size);
    EXPECT_NE(drawn.image.pixels, photo.image.pixels);
    ++num_drawn;
  }
  EXPECT_EQ(num_drawn, 2);

  EXPECT_THAT(detect({1}, {"--debug", scratch.path("d"), "-o", scratch.path("d/")}),
              FailsWith(2, AllOf(HasSubstr("--debug"), HasSubstr("this is also the output"))));

  // Names that differ in folders only give drawings of their own; one that cannot be written costs no
  // corners.
  for (const char* folder : {"two", "two/a", "blocked", "blocked/b.png.detection.png"})
    std::filesystem::create_directory(scratch.path(folder));
  std::filesystem::copy(imagePath(1), scratch.path("two/a/p.png"));
  std::filesystem::copy(imagePath(2), scratch.path("two/a_p.png"));
  std::filesystem::copy(imagePath(1), scratch.path("two/b.png"));
  ASSERT_THAT(runAlidade({"detect", scratch.path("two/a/p.png"), scratch.path("two/a_p.png"), "--board",
                          kBoardSpec, "--debug", scratch.path("apart")}),
              EndsWith(0));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path("apart")), {}), 2);
  const RunResult blocked = runAlidade(
      {"detect", scratch.path("two/b.png"), "--board", kBoardSpec, "--debug", scratch.path("blocked")});
  ASSERT_THAT(blocked, EndsWith(0));
  EXPECT_THAT(blocked.err, HasSubstr("some debug images could not be written"));

  // Among the inputs, the drawings would be inputs of the next run.
  std::filesystem::create_directory(scratch.path("photos"));
  std::filesystem::copy(imagePath(1), scratch.path("photos/a.png"));
  EXPECT_THAT(runAlidade({"detect", scratch.path("photos"), "--board", kBoardSpec, "--debug",
                          scratch.path("photos")}),
              FailsWith(2, AllOf(HasSubstr("--debug"), HasSubstr("folder of the input"))));
  EXPECT_THAT(runAlidade({"detect", scratch.path("photos"), "--board", kBoardSpec, "--debug",
                          scratch.path("photos/a.png")}),
              FailsWith(1, HasSubstr("--debug")));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(scratch.path("photos")), {}), 1);
}

TEST(Detect, TellsWhatBoardTheImagesShowInstead) {
  struct Case {
    std::string board;
    std::string hint;
  };
  int num_checked = 0;
  for (const Case& c :
       {Case{"checkerboard:10x7:25mm", "did you count squares? Use checkerboard:9x6:25mm"},
        Case{"checkerboard:7x10:25mm", "did you count squares? Use checkerboard:6x9:25mm"},
        Case{"checkerboard:8x5:25mm",
             "did you miss one line of corners in each direction? Use checkerboard:9x6"},
        Case{"checkerboard:13x12:25mm", "3 images show 9x6 inner corners; use checkerboard:9x6:25mm"}}) {
    EXPECT_THAT(runAlidade({"detect", imagePath(1), imagePath(2), imagePath(4), "--board", c.board}),
                FailsWith(1, HasSubstr(c.hint)))
        << c.board;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);
  EXPECT_THAT(
      runAlidade({"detect", imagePath(1), imagePath(2), "--board", "checkerboard:6x9:25mm", "--quiet"}),
      EndsWith(0))
      << "swapped sides are the same board";
}

TEST(Detect, CountsPhotographsThatItCannotRead) {
  const ScratchFolder scratch;
  const std::string folder = linkImages(scratch, "photos", 2);
  scratch.write("photos/IMG_0003.HEIC", std::string("\0\0\0\x18", 4) + "ftypheic" + std::string(40, '\0'));
  const RunResult run =
      runAlidade({"detect", folder, "--board", kBoardSpec, "-o", scratch.path("corners.csv")});
  EXPECT_THAT(run, EndsWith(0));
  EXPECT_THAT(run.err, AllOf(HasSubstr("2 of 3 images"), HasSubstr("IMG_0003.HEIC"),
                             HasSubstr("a HEIC photograph"), HasSubstr("heif-convert")));
}

TEST(Detect, SaysOfEachImageWhyWhereNoneShowsTheBoard) {
  const RunResult run =
      runAlidade({"detect", imagePath(1), imagePath(2), "--board", "checkerboard:10x7:25mm", "--json"});
  EXPECT_THAT(run, EndsWith(1));
  EXPECT_THAT(run.err,
              AllOf(HasSubstr("view_001.png: other_board: "), HasSubstr("view_002.png: other_board: ")));
  const auto images = nlohmann::json::parse(run.out).at("images");
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].at("reason"), "other_board");
}

TEST(Detect, WritesOneJsonDocument) {
  const ScratchFolder scratch;
  const RunResult result = detect({1, 2}, {"--json", "-o", scratch.path("corners.csv")});
  ASSERT_THAT(result, EndsWith(0));
  const auto images = nlohmann::json::parse(result.out).at("images");
  ASSERT_EQ(images.size(), 2u);
  const CornersFile file = readCornersFile(scratch.path("corners.csv"));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(images[i].at("image"), file.views[i].image);
    ASSERT_EQ(images[i].at("corners").size(), 54u);
    EXPECT_EQ(images[i].at("corners")[53].at("u").get<double>(), file.views[i].corners[53].pixel.x());
    EXPECT_EQ(images[i].at("corners")[53].at("sigma_px").get<double>(), file.views[i].corners[53].sigma_px);
    EXPECT_EQ(images[i].at("reason"), "found");
    EXPECT_EQ(images[i].at("seen").at("columns"), 9);
    EXPECT_GT(images[i].at("measures").at("blur_px").get<double>(), 0.3);
  }
}

TEST(Detect, MakesPiecesThatConcatenate) {
  const RunResult first = detect({1, 2});
  const RunResult second = detect({3, 4});
  const RunResult whole = detect({1, 2, 3, 4});
  ASSERT_THAT(whole, EndsWith(0));
  const CornersFile pieces = parseCornersFile(second.out + first.out, "pieces");
  const CornersFile at_once = parseCornersFile(whole.out, "whole");
  CornersFile joined = pieces;
  joined.comments = at_once.comments;
  EXPECT_EQ(cornersFileText(joined), cornersFileText(at_once));
}

}  // namespace
}  // namespace alidade
