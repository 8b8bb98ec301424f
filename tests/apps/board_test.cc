// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_file.h"
#include "apps/command_line.h"
#include "support/source_tree.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

RunResult detectAs(const std::string& board, const std::string& output) {
  return runAlidade({"detect", imagePath(1), imagePath(2), "--board", board, "-o", output});
}

TEST(Board, OfTheWrongSizeIsNeverFoundAsAPart) {
  const ScratchFolder scratch;
  int num_refused = 0;
  for (const char* board : {"checkerboard:8x5:25mm", "checkerboard:10x7:25mm"}) {
    EXPECT_THAT(detectAs(board, scratch.path("corners.csv")),
                FailsWith(1, AllOf(HasSubstr("no board"), HasSubstr("inner corners"), HasSubstr(kBoardSpec))))
        << board;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 2);
  EXPECT_THAT(scratch.list(), ElementsAre());
}

TEST(Board, IsGuessedWhereNoneIsGiven) {
  const ScratchFolder scratch;
  const std::string out = scratch.path("corners.csv");
  EXPECT_THAT(runAlidade({"detect", imagePath(1), imagePath(2), "-o", out}),
              FailsWith(2, AllOf(HasSubstr("no --board"), HasSubstr("a checkerboard of 9x6 inner corners"),
                                 HasSubstr("--board checkerboard:9x6:SQUARE"))));
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"charuco:6x8:30mm:22.5mm:DICT_5X5_250",
       "a ChArUco board of 6x8 squares: --board charuco:6x8:SQUARE:MARKER:DICT_5X5_50, with the sides of a "
       "square and of a marker, which is about 0.75 of it"},
      {"aprilgrid:4x3:40mm:0.3:5", "an AprilGrid of 4x3 tags: --board aprilgrid:4x3:TAG:0.3:5"},
      {"circles:7x9:25mm:15mm", "a grid of 9x7 circles: --board circles:9x7:SPACING:DIAMETER"},
      {"acircles:4x9:20mm:14mm", "an asymmetric grid of 4x9 circles: --board acircles:4x9:SPACING:DIAMETER"}};
  for (const auto& [spec, guess] : cases) {
    const std::string image = scratch.path("board.png");
    ASSERT_THAT(runAlidade({"board", spec, "-o", image, "--dpi", "150"}), EndsWith(0));
    EXPECT_THAT(runAlidade({"calibrate", image}),
                FailsWith(2, AllOf(HasSubstr("no --board"), HasSubstr(guess))));
  }
}

// Of a board whose border is not seen, the counts are at least these.
TEST(Board, IsGuessedWithDoubtFromAPart) {
  const ScratchFolder scratch;
  const GrayImage whole = readGrayImage(imagePath(1)).image;
  const ImageSize size{.width = whole.size.width / 2, .height = whole.size.height};
  RasterImage part{.size = size, .bytes = {}};
  for (int y = 0; y < size.height; ++y) {
    const auto row = whole.pixels.begin() + std::ptrdiff_t{y} * whole.size.width;
    part.bytes.insert(part.bytes.end(), row, row + size.width);
  }
  writeImage(scratch.path("part.png"), part);
  EXPECT_THAT(runAlidade({"detect", scratch.path("part.png"), "-o", scratch.path("corners.csv")}),
              FailsWith(2, AllOf(HasSubstr("no --board"), HasSubstr("perhaps not all"),
                                 HasSubstr("--board checkerboard:"))));
}

TEST(Board, IsNamedWhereAnotherIsGiven) {
  const ScratchFolder scratch;
  struct Case {
    std::string shown, given, named;
  };
  const std::vector<Case> cases = {
      {"charuco:6x8:30mm:22mm:DICT_5X5_100", "charuco:8x6:30mm:22mm:DICT_5X5_100", "charuco:6x8:SQUARE:"},
      {"charuco:9x5:30mm:22mm:DICT_4X4_250", "charuco:5x9:30mm:22mm:DICT_4X4_250", "charuco:9x5:SQUARE:"},
      {"charuco:7x5:35mm:25mm:DICT_5X5_100:17", "charuco:7x5:35mm:25mm:DICT_5X5_100",
       "charuco:7x5:SQUARE:MARKER:DICT_5X5_50:17"},
      {"aprilgrid:4x3:40mm:0.3:5", "aprilgrid:3x4:40mm:0.3:5", "aprilgrid:4x3:TAG:0.3:5"}};
  std::size_t num_named = 0;
  for (const auto& [shown, given, named] : cases) {
    const std::string image = scratch.path("board.png");
    ASSERT_THAT(runAlidade({"board", shown, "-o", image, "--dpi", "150"}), EndsWith(0));
    EXPECT_THAT(runAlidade({"detect", image, "--board", given}),
                FailsWith(1, AllOf(HasSubstr("no board"), HasSubstr("--board " + named))));
    EXPECT_THAT(runAlidade({"detect", image, "--board", shown, "-o", scratch.path("corners.csv")}),
                EndsWith(0));
    ++num_named;
  }
  EXPECT_EQ(num_named, 4U);
}

// The first images of a folder often show no board yet.
TEST(Board, IsGuessedFromTheImagesThatShowIt) {
  const ScratchFolder scratch;
  const std::string folder = scratch.makeFolder("photos");
  const std::string blank = "P5 60 40 255\n" + std::string(2400, 'x');
  for (int i = 0; i < 14; ++i) scratch.write("photos/a" + std::to_string(i) + ".pgm", blank);
  scratch.write("photos/damaged.png", "no image");
  EXPECT_THAT(runAlidade({"calibrate", folder}),
              FailsWith(2, AllOf(HasSubstr("no --board"), Not(HasSubstr("images show")))));
  ASSERT_THAT(
      runAlidade({"board", "aprilgrid:4x3:40mm:0.3", "-o", scratch.path("photos/b.png"), "--dpi", "100"}),
      EndsWith(0));
  EXPECT_THAT(runAlidade({"calibrate", folder}), FailsWith(2, HasSubstr("--board aprilgrid:4x3:TAG:0.3,")));
}

TEST(Board, MayBeTakenSideways) {
  const ScratchFolder scratch;
  const RunResult result = detectAs("checkerboard:6x9:25mm", scratch.path("corners.csv"));
  ASSERT_THAT(result, EndsWith(0));
  EXPECT_THAT(result.err, HasSubstr("2 of 2 images"));
}

TEST(Board, SpecsThatAreWrongAreWrongUsage) {
  struct Case {
    std::string spec;
    std::string found;
    std::string next;
  };
  const std::vector<Case> cases = {
      {"checkerboard:9x6:25", "squares of 25 m", "did you mean 25mm?"},
      {"checkerboard:9x6:25km", "'25km'", "a length such as 25mm"},
      {"checkerboard:9x6:0mm", "squares of 0 m", "between 0.1 mm and 2 m"},
      {"checkerboard:9x6:-25mm", "squares of -0.025 m", "between 0.1 mm and 2 m"},
      {"checkerboard:9x6:1e9m", "squares of", "between 0.1 mm and 2 m"},
      {"checkerboard:9x6:nanmm", "'nanmm'", "a length such as 25mm"},
      {"checkerboard:9x6:mm", "'mm'", "a length such as 25mm"},
      {"checkerboard:9x6", "2 parts", "COLUMNSxROWS:SQUARE"},
      {"checkerboard", "1 part", "COLUMNSxROWS:SQUARE"},
      {"checkerboard:9x6:25mm:30mm", "4 parts", "COLUMNSxROWS:SQUARE"},
      {"checkerboard:9:25mm", "'9' as the size", "for example 9x6"},
      {"checkerboard:9x6x2:25mm", "'9x6x2' as the size", "for example 9x6"},
      {"checkerboard:ninex6:25mm", "'nine'", "a whole number"},
      {"checkerboard:9.5x6:25mm", "'9.5'", "a whole number"},
      {"checkerboard:2x6:25mm", "2x6 inner corners", "between 3 and 200"},
      {"checkerboard:9x100000:25mm", "9x100000 inner corners", "between 3 and 200"},
      {"chekerboard:9x6:25mm", "'chekerboard'", "did you mean 'checkerboard'?"},
      {"charuco:8x11:24mm:18mm", "4 parts", "SQUARE:MARKER:DICTIONARY"},
      {"charuco:8x11:24mm:25mm:DICT_4X4_50", "markers of 25 mm in squares of 24 mm", "0.3 to 0.95"},
      {"charuco:8x11:24mm:18mm:DICT_4X4_51", "the dictionary 'DICT_4X4_51'", "did you mean 'DICT_4X4_50'?"},
      {"charuco:1x1:24mm:18mm:DICT_4X4_50", "1x1 squares", "between 3 and 100"},
      {"aprilgrid:24x25:88mm:0.3", "24x25 tags", "between 1 and 24"},
      {"aprilgrid:24x24:88mm:0.3:50", "576 tags from id 50", "ids from 0 to 586"},
      {"9x6", "'9x6'", "checkerboard:9x6:25mm"},
  };
  const ScratchFolder scratch;
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    EXPECT_THAT(
        detectAs(c.spec, scratch.path("corners.csv")),
        FailsWith(2, AllOf(HasSubstr("board '" + c.spec + "'"), HasSubstr(c.found), HasSubstr(c.next))))
        << c.spec;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 24u);
  EXPECT_THAT(scratch.list(), ElementsAre());
}

TEST(Board, FilesDescribeItToo) {
  const ScratchFolder scratch;
  const std::string file = scratch.write(
      "board.yaml", "kind: checkerboard\ncolumns: 9\nrows: 6\nsquare: 25mm\nx_note: my board\n");
  ASSERT_THAT(detectAs(file, scratch.path("a.csv")), EndsWith(0));
  ASSERT_THAT(detectAs(kBoardSpec, scratch.path("b.csv")), EndsWith(0));
  const auto rows = [&](const char* name) {
    const std::string text = scratch.read(name);
    return text.substr(text.find("\ncamera,"));
  };
  EXPECT_EQ(rows("a.csv"), rows("b.csv"));
  EXPECT_THAT(detectAs(sourcePath("config/boards/checkerboard_9x6_25mm.yaml"), scratch.path("c.csv")),
              EndsWith(0));
}

TEST(Board, FilesThatAreWrongAreNamedWithTheirLine) {
  const std::string good = "kind: checkerboard\ncolumns: 9\nrows: 6\nsquare: 25mm\n";
  struct Case {
    std::string text;
    std::string place;
    std::string found;
  };
  const std::vector<Case> cases = {
      {replaced(good, "rows: 6", "rows: six"), ":3: rows", "'six'"},
      {replaced(good, "rows: 6", "rows: 2"), ":4: square", "9x2 inner corners"},
      {replaced(good, "25mm", "25"), ":4: square", "did you mean 25mm?"},
      {replaced(good, "25mm", "wide"), ":4: square", "'wide'"},
      {replaced(good, "columns", "colums"), ":2", "did you mean 'columns'?"},
      {replaced(good, "rows: 6\n", ""), "", "no key 'rows'"},
      {good + "rows: 7\n", ":5", "the key 'rows' twice"},
      {replaced(good, "checkerboard", "hexboard"), ":1: kind", "'hexboard'"},
      {replaced(good, "checkerboard", "charuco"), ":1", "no key 'marker'"},
      {replaced(good, "25mm", "25mm:3"), ":4: square", "no ':'"},
      {"", "", "an empty file"},
      {"- 1\n", ":1", "a list"},
  };
  const ScratchFolder scratch;
  std::size_t num_refused = 0;
  for (const Case& c : cases) {
    const std::string file = scratch.write("board.yaml", c.text);
    EXPECT_THAT(detectAs(file, scratch.path("corners.csv")),
                FailsWith(1, AllOf(HasSubstr(file + c.place), HasSubstr(c.found))))
        << c.text;
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 12u);
  EXPECT_THAT(detectAs(scratch.path("bord.yaml"), scratch.path("corners.csv")),
              FailsWith(1, HasSubstr("did you mean '" + scratch.path("board.yaml") + "'?")));
  EXPECT_THAT(scratch.list(), ElementsAre("board.yaml"));
}

}  // namespace
}  // namespace alidade
