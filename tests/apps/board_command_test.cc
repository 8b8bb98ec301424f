// SPDX-License-Identifier: MIT
#include <cmath>
#include <map>

#include <gmock/gmock.h>

#include "alidade/core/text.h"
#include "alidade/files/corners_file.h"
#include "apps/command_line.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(BoardCommand, WritesTheSameBytesAgainInEveryFormat) {
  const ScratchFolder scratch;
  int num_checked = 0;
  for (const std::string ending : {"pdf", "svg", "png"}) {
    std::vector<std::string> files;
    for (const std::string name : {"a.", "b."}) {
      const std::string path = scratch.path(name + ending);
      EXPECT_THAT(runAlidade({"board", "charuco:5x4:30mm:22mm:DICT_4X4_50", "-o", path, "--dpi", "100"}),
                  EndsWith(0));
      files.push_back(scratch.read(name + ending));
    }
    EXPECT_EQ(files[0], files[1]) << ending;
    EXPECT_GT(files[0].size(), 1000U) << ending;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

// The drawing is at exact scale: neighbouring corners of its image are as far apart as the SPEC says.
TEST(BoardCommand, DrawsToScale) {
  const ScratchFolder scratch;
  constexpr double kDpi = 254;  // ten pixels a millimetre: all edges are between pixels
  struct Case {
    std::string spec;
    double spacing_mm;
    std::size_t num_corners;
  };
  const std::vector<Case> cases = {{"checkerboard:9x6:25mm", 25, 54},
                                   {"charuco:6x8:30mm:22mm:DICT_5X5_250", 30, 35},
                                   {"aprilgrid:4x3:40mm:0.3", 12, 48},
                                   {"circles:7x6:25mm:15mm", 25, 42},
                                   {"acircles:4x7:20mm:14mm", 40, 28}};  // neighbours in a row
  for (const Case& c : cases) {
    scratch.write("images/readme.txt", "");
    ASSERT_THAT(runAlidade({"board", c.spec, "-o", scratch.path("images/board.png"), "--dpi", "254"}),
                EndsWith(0));
    ASSERT_THAT(runAlidade({"detect", scratch.path("images/board.png"), "--board", c.spec, "-o",
                            scratch.path("corners.csv")}),
                EndsWith(0));
    const auto views = readCornersFile(scratch.path("corners.csv")).views;
    ASSERT_EQ(views.size(), 1U) << c.spec;
    const auto& corners = views.front().corners;
    ASSERT_EQ(corners.size(), c.num_corners) << c.spec;
    double least = 1e9;
    for (std::size_t i = 1; i < corners.size(); ++i)
      least = std::min(least, (corners[i].pixel - corners[i - 1].pixel).norm());
    EXPECT_NEAR(least / kDpi * 25.4, c.spacing_mm, 0.001 * c.spacing_mm) << c.spec;
  }
}

TEST(BoardCommand, CutsLargeBoardsIntoPagesAndSaysSo) {
  const ScratchFolder scratch;
  const RunResult large =
      runAlidade({"board", "checkerboard:9x6:50mm", "-o", scratch.path("a.pdf"), "--paper", "A4"});
  EXPECT_THAT(large, EndsWith(0));
  EXPECT_THAT(large.err, HasSubstr("cut into 4 pages"));
  EXPECT_THAT(
      runAlidade({"board", "checkerboard:9x6:50mm", "-o", scratch.path("a.svg"), "--paper", "A4"}).err,
      HasSubstr("takes 4 pages of A4; expected one page"));
}

TEST(BoardCommand, SaysWhatIsWrong) {
  const ScratchFolder scratch;
  const std::string out = scratch.path("b.pdf");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"board"}, "no board"},
      {{"board", "checkerboard:9x6:25mm"}, "no --output"},
      {{"board", "checkerboard:9x6:25mm", "-o", scratch.path("b.doc")}, "without a known ending"},
      {{"board", "checkerboard:9x6:25mm", "-o", out, "--paper", "A9"}, "expected A4, letter"},
      {{"board", "checkerboard:9x6:25mm", "-o", out, "--paper", "1x1mm"}, "50 mm to 5 m"},
      {{"board", "charuco:5x4:30mm:40mm:DICT_4X4_50", "-o", out}, "markers of 40 mm"},
      {{"board", "aprilgrid:24x24:10mm:0.3:99", "-o", out}, "576 tags from id 99"},
      {{"board", "checkerboard:9x6:1m", "-o", scratch.path("b.png"), "--paper", "5x5m"},
       "takes 6 pages of 5x5m; expected one page"},
      {{"board", "checkerboard:200x200:2m", "-o", out}, "expected at most 100 pages"},
      {{"board", "checkerboard:9x6:25mm", "-o", scratch.path("b.png"), "--dpi", "1e12"}, "200 million"},
      {{"board", "checkerboard:9x6:25mm", "-o", scratch.path("b.png"), "--dpi", "0.001"}, "50 pixels along"},
  };
  for (const auto& [arguments, part] : cases) {
    const RunResult result = runAlidade(arguments);
    EXPECT_THAT(result, EndsWith(2)) << part;
    EXPECT_THAT(result.err, HasSubstr(part));
    EXPECT_THAT(result.out, "");
  }
  EXPECT_EQ(cases.size(), 11U);
  EXPECT_THAT(scratch.list(), testing::ElementsAre());
  EXPECT_THAT(runAlidade({"board", "checkerboard:9x6:25mm", "-o", out, "--paper", "300mmx400mm"}),
              EndsWith(0));
}

}  // namespace
}  // namespace alidade
