// SPDX-License-Identifier: MIT
// mrcal's corners files, written by detect and read by calibrate and validate.
#include <algorithm>
#include <filesystem>

#include "alidade/files/corners_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kSize = "640x480";

TEST(VnlCommand, GivesTheCameraOfTheSameCornersWithoutSigmas) {
  const ScratchFolder scratch;
  const std::string photos = linkImages(scratch, "photos", 6);
  const std::string vnl = scratch.path("corners.vnl");
  const std::string csv = scratch.path("corners.csv");
  const RunResult detected = runAlidade({"detect", photos, "--board", kBoardSpec, "-o", vnl});
  ASSERT_THAT(detected, EndsWith(0));
  EXPECT_THAT(detected.err, HasSubstr("6 of 6 images show the whole board"));
  const std::string text = readFile(vnl);
  EXPECT_THAT(text, AllOf(HasSubstr("\n## board: checkerboard:9x6:25mm\n"), HasSubstr("\n# filename x y\n")));
  EXPECT_EQ(
      std::count(text.begin() + static_cast<std::ptrdiff_t>(text.find("# filename x y")), text.end(), '\n'),
      1 + 6 * 54);
  ASSERT_THAT(runAlidade({"detect", photos, "--board", kBoardSpec, "-o", csv}), EndsWith(0));
  CornersFile corners = readCornersFile(csv);
  int num_corners = 0;
  for (View& view : corners.views) {
    for (Corner& corner : view.corners) {
      corner.sigma_px = Corner().sigma_px;
      ++num_corners;
    }
  }
  EXPECT_EQ(num_corners, 324);
  writeCornersFile(csv, corners);
  const RunResult from_vnl =
      runAlidade({"calibrate", vnl, "--board", kBoardSpec, "--image-size", kSize, "-o", "-"});
  const RunResult from_csv = runAlidade({"calibrate", csv, "-o", "-"});
  ASSERT_THAT(from_vnl, EndsWith(0));
  EXPECT_EQ(from_vnl.out, from_csv.out);
  // A settings file has the same flags.
  const std::string config = scratch.write(
      "settings.yaml", "board: " + std::string(kBoardSpec) + "\nimage-size: " + kSize + "\noutput: \"-\"\n");
  EXPECT_EQ(runAlidade({"calibrate", vnl, "--config", config}).out, from_csv.out);
  EXPECT_THAT(runAlidade({"validate", dataPath("camera.yaml"), "--images", vnl, "--board", kBoardSpec,
                          "--image-size", kSize, "--verbose"})
                  .out,
              HasSubstr("324 corners of 6 of 6 views"));
}

TEST(VnlCommand, NamesWhatIsMissingOrDoesNotFit) {
  const ScratchFolder scratch;
  const std::string photos = linkImages(scratch, "photos", 1);
  const std::string vnl = scratch.write("corners.vnl", "# filename x y\na.png 1 2\n");
  const std::string csv = scratch.write("corners.csv", readFile(dataPath("corners.csv")));
  std::filesystem::copy(imagePath(1), scratch.path("view 1.png"));
  struct Case {
    std::vector<std::string> args;
    int code;
    std::vector<std::string> parts;
  };
  const std::vector<Case> cases = {
      {{"calibrate", vnl, "--image-size", kSize}, 2, {"no --board", vnl + " has the corners of one board"}},
      {{"calibrate", vnl, "--image-size", kSize, "--board", kBoardSpec, "--board", "checkerboard:5x4:25mm"},
       2,
       {"several boards", "expected one"}},
      {{"calibrate", vnl, "--board", kBoardSpec}, 2, {"no --image-size", "--image-size 640x480"}},
      {{"calibrate", vnl, "--board", kBoardSpec, "--image-size", "640"}, 2, {"--image-size", "found '640'"}},
      {{"calibrate", csv, "--image-size", kSize}, 2, {"inputs that state their own size", "remove it"}},
      {{"calibrate", photos, "--board", kBoardSpec, "--image-size", kSize},
       2,
       {"inputs that state their own size"}},
      {{"calibrate", vnl, csv, "--board", kBoardSpec, "--image-size", kSize},
       2,
       {csv, "another format than " + vnl}},
      {{"calibrate", csv, vnl}, 2, {vnl, "another format than " + csv}},
      {{"calibrate", vnl, photos, "--board", kBoardSpec, "--image-size", kSize},
       2,
       {photos, "no corners file"}},
      {{"calibrate", vnl, "--board", kBoardSpec, "--image-size", kSize},
       1,
       {vnl + ":2", "'a.png' with 1 row;", "expected 54", "check --board"}},
      {{"validate", dataPath("camera.yaml"), "--images", vnl, "--board", kBoardSpec}, 2, {"no --image-size"}},
      {{"detect", photos, "-o", scratch.path("new.vnl")}, 2, {"no --board"}},
      {{"detect", photos, "--board", "aprilgrid:6x6:88mm:0.3", "-o", scratch.path("new.vnl")},
       1,
       {"aprilgrid:6x6", "evenly spaced", "write a .csv file"}},
      {{"detect", scratch.path("view 1.png"), "--board", kBoardSpec, "-o", scratch.path("new.vnl")},
       1,
       {"'view 1.png'", "without blanks"}},
  };
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    const RunResult result = runAlidade(c.args);
    for (const std::string& part : c.parts)
      EXPECT_THAT(result, FailsWith(c.code, HasSubstr(part))) << testing::PrintToString(c.args);
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 14u);
  EXPECT_FALSE(scratch.has("new.vnl"));
}

}  // namespace
}  // namespace alidade
