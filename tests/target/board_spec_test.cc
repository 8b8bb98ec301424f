// SPDX-License-Identifier: MIT
#include "alidade/target/board_spec.h"

#include <gmock/gmock.h>

#include "alidade/core/error.h"

namespace alidade {
namespace {

using testing::HasSubstr;

std::string messageOf(const std::string& spec) {
  try {
    static_cast<void>(parseBoardSpec(spec));
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kUsage);
    return e.what();
  }
  return "no error";
}

TEST(BoardSpec, ReadsLengthsInAllUnits) {
  int num_checked = 0;
  for (const char* square : {"25mm", "2.5cm", "0.025m", "0.025", "25 mm"}) {
    EXPECT_EQ(parseBoardSpec(std::string("checkerboard:9x6:") + square),
              Board(Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025}))
        << square;
    ++num_checked;
  }
  EXPECT_EQ(parseBoardSpec("checkerboard:9x6:1in").spacing(), 0.0254);
  EXPECT_EQ(num_checked, 5);
}

TEST(BoardSpec, ReadsTheWordsOfOtherPrograms) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"chessboard:9x6:25mm", "checkerboard:9x6:25mm"},
      {"Checkerboard:9x6:25mm", "checkerboard:9x6:25mm"},
      {"chess:9x6:25mm", "checkerboard:9x6:25mm"},
      {"charuco_board:8x11:24mm:18mm:DICT_4X4_50", "charuco:8x11:24mm:18mm:DICT_4X4_50"},
      {"ChArUco-Board:8x11:24mm:18mm:DICT_4X4_50", "charuco:8x11:24mm:18mm:DICT_4X4_50"},
      {"apriltag:6x6:88mm:0.3", "aprilgrid:6x6:88mm:0.3"},
      {"circle_grid:10x8:25mm:15mm", "circles:10x8:25mm:15mm"},
      {"asymmetric_circles:4x11:20mm:14mm", "acircles:4x11:20mm:14mm"},
  };
  std::size_t num_read = 0;
  for (const auto& [spec, same] : cases) {
    EXPECT_EQ(parseBoardSpec(spec).spec(), same);
    ++num_read;
  }
  EXPECT_EQ(num_read, cases.size());
}

TEST(BoardSpec, SaysWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "board kind ''"},
      {"chekerboard:9x6:25mm", "did you mean 'checkerboard'?"},
      {"charuco:8x11:24mm", "3 parts; expected charuco:COLUMNSxROWS:SQUARE:MARKER:DICTIONARY"},
      {"charuco:8x11:24mm:25mm:DICT_4X4_50", "markers of 25 mm in squares of 24 mm"},
      {"charuco:8x11:24mm:18mm:DICT_4X4_40", "did you mean 'DICT_4X4_50'?"},
      {"charuco:8x11:24mm:18mm:4x4_1000", "did you mean 'DICT_4X4_1000'?"},
      {"charuco:8x11:24mm:18mm:dict_apriltag_36h11", "did you mean 'DICT_APRILTAG_36h11'?"},
      {"charuco:8x11:24mm:18mm:nonsense", "expected one of DICT_4X4_50, DICT_4X4_100"},
      {"charuco:12x11:24mm:18mm:DICT_4X4_50", "up to 66 markers; expected at most 50"},
      {"charuco:2x11:24mm:18mm:DICT_4X4_50", "2x11 squares"},
      {"charuco:1x1:24mm:18mm:DICT_4X4_50", "1x1 squares"},
      {"charuco:101x3:24mm:18mm:DICT_4X4_1000", "101x3 squares"},
      {"charuco:8x11:24mm:5mm:DICT_4X4_50", "markers of 5 mm in squares of 24 mm"},
      {"charuco:8x11:24mm:24mm:DICT_4X4_50", "markers of 0.3 to 0.95 of the square"},
      {"charuco:8x11:24mm:18mm:", "the dictionary ''"},
      {"charuco:8x11:24mm:18mm:DICT_APRILTAG_16h5", "up to 44 markers; expected at most 30"},
      {"charuco:7x5:35mm:25mm:DICT_5X5_50:40",
       "18 markers from id 40 to 57; expected ids from 0 to 49, which DICT_5X5_50 has"},
      {"charuco:7x5:35mm:25mm:DICT_5X5_50:-1", "18 markers from id -1 to 16"},
      {"charuco:7x5:35mm:25mm:DICT_5X5_50:one", "'one' as the first_id"},
      {"aprilgrid:1x1:88mm:0.3", "1x1 tags; expected 2 tags or more"},
      {"aprilgrid:0x6:88mm:0.3", "0x6 tags"},
      {"aprilgrid:25x2:88mm:0.3", "25x2 tags"},
      {"aprilgrid:24x24:88mm:0.3:12", "576 tags from id 12 to 587; expected ids from 0 to 586"},
      {"aprilgrid:6x6:88mm:0.3:-1", "36 tags from id -1"},
      {"aprilgrid:6x6:88mm:0.05", "gaps of 0.05 tags"},
      {"aprilgrid:6x6:88mm:0.3:560", "36 tags from id 560 to 595"},
      {"aprilgrid:6x6:88mm:0.3:560", "the first id may be 551 at most"},
      {"aprilgrid:6x6:88mm:0.3:2147483647", "from id 2147483647 to 2147483682"},
      {"aprilgrid:6x6:88mm:3", "gaps of 3 tags"},
      {"aprilgrid:6x6:88mm:3mm", "'3mm' as the gap; expected a plain number"},
      {"chesboard:9x6:25mm", "did you mean 'checkerboard'?"},
      {"aprilgrid:6x6:88mm:0.3:first", "'first' as the first_id"},
      {"circles:10x8:25mm", "3 parts; expected circles:COLUMNSxROWS:SPACING:DIAMETER"},
      {"circles:1x1:25mm:15mm", "1x1 circles"},
      {"circles:10x8:25mm:25mm", "circles of 25 mm, whose neighbours are 25 mm away"},
      {"acircles:4x11:20mm:30mm", "whose neighbours are 28.28 mm away"},
      {"acircles:1x11:20mm:14mm", "1x11 circles; expected between 2 and 100"},
      {"acircles:4x2:20mm:14mm", "rows of circles"},
      {"checkerboard", "1 part"},
      {"checkerboard:9x6", "2 parts"},
      {"checkerboard:9x6:25mm:3", "4 parts"},
      {"checkerboard:9:25mm", "'9' as the size"},
      {"checkerboard:9x6x2:25mm", "as the size"},
      {"checkerboard:9xfive:25mm", "'five' as a count"},
      {"checkerboard:9x6.5:25mm", "'6.5' as a count"},
      {"checkerboard:-9x6:25mm", "-9x6 inner corners"},
      {"checkerboard:2x6:25mm", "2x6 inner corners"},
      {"checkerboard:9x6000:25mm", "9x6000 inner corners"},
      {"checkerboard:9x6:25", "did you mean 25mm?"},
      {"checkerboard:9x6:25inch", "'25inch'"},
      {"checkerboard:9x6:mm", "'mm'"},
      {"checkerboard:9x6:", "''"},
      {"checkerboard:9x6:-25mm", "-0.025"},
      {"checkerboard:9x6:0mm", "squares of 0 m"},
      {"checkerboard:9x6:nanmm", "'nanmm'"},
      {"checkerboard:9x6:25km", "'25km'"},
  };
  for (const auto& [spec, part] : cases) EXPECT_THAT(messageOf(spec), HasSubstr(part)) << spec;
  EXPECT_EQ(cases.size(), 56U);
}

TEST(BoardSpec, TextReadsBack) {
  for (const double square : {0.025, 0.1, 1.0 / 3.0, 0.0254, 1e-4}) {
    const Board board = Checkerboard{.columns = 9, .rows = 6, .square_m = square};
    EXPECT_EQ(parseBoardSpec(board.spec()), board) << board.spec();
  }
  int num_same = 0;
  for (const std::string spec :
       {"checkerboard:9x6:25mm", "charuco:8x11:24mm:18.75mm:DICT_4X4_1000", "aprilgrid:6x6:88mm:0.3",
        "aprilgrid:6x6:88mm:0.3:36", "charuco:7x5:35mm:25mm:DICT_5X5_100:17", "circles:10x8:25mm:15mm",
        "acircles:4x11:20mm:14mm"})
    num_same += parseBoardSpec(spec).spec() == spec ? 1 : 0;
  EXPECT_EQ(num_same, 7);
}

TEST(Board, NamesWhatItConsistsOf) {
  struct Case {
    std::string spec;
    std::string counts;
    std::string points;
    std::string marker;
    std::string certain;  // for boards that are not
  };
  const std::vector<Case> cases = {
      {"checkerboard:9x6:25mm", "9x6 inner corners", "corners", "", ""},
      {"checkerboard:8x6:25mm", "8x6 inner corners", "corners", "", "one even and one odd count"},
      {"charuco:8x11:24mm:18.75mm:DICT_4X4_1000", "8x11 squares", "corners", "marker", ""},
      {"aprilgrid:6x4:88mm:0.3", "6x4 tags", "tag corners", "tag", ""},
      {"circles:10x8:25mm:15mm", "10x8 circles", "circles", "", "an asymmetric grid"},
      {"acircles:4x10:20mm:14mm", "4x10 circles", "circles", "", "an odd number of rows"}};
  int num_ambiguous = 0;
  for (const Case& c : cases) {
    const Board board = parseBoardSpec(c.spec);
    EXPECT_EQ(board.countsText(), c.counts);
    EXPECT_EQ(board.words().points, c.points);
    EXPECT_EQ(board.words().marker, c.marker);
    EXPECT_EQ(board.markers().has_value(), !c.marker.empty());
    EXPECT_EQ(board.isAmbiguous(), !c.certain.empty());
    EXPECT_THAT(std::string(board.words().certain), HasSubstr(c.certain));
    num_ambiguous += board.isAmbiguous() ? 1 : 0;
  }
  EXPECT_EQ(cases.size(), 6U);
  EXPECT_EQ(num_ambiguous, 3);
  EXPECT_EQ(parseBoardSpec("aprilgrid:6x4:88mm:0.3:7").markers()->last, 30);
  EXPECT_EQ(parseBoardSpec("charuco:5x5:24mm:18mm:DICT_4X4_50").markers()->last, 12);
  EXPECT_EQ(parseBoardSpec("charuco:5x5:24mm:18mm:DICT_4X4_50:17").markers()->first, 17);
  EXPECT_EQ(parseBoardSpec("charuco:5x5:24mm:18mm:DICT_4X4_50:17").markers()->last, 29);
}

TEST(Checkerboard, NumbersCornersAlongTheColumnsFirst) {
  const Checkerboard board{.columns = 4, .rows = 3, .square_m = 0.5};
  const auto points = Board(board).corners();
  ASSERT_EQ(points.size(), 12U);
  EXPECT_EQ(points[0], Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(points[3], Eigen::Vector3d(1.5, 0, 0));
  EXPECT_EQ(points[4], Eigen::Vector3d(0, 0.5, 0));
  EXPECT_FALSE(board.isAmbiguous());
  EXPECT_TRUE((Checkerboard{.columns = 4, .rows = 6, .square_m = 1}.isAmbiguous()));
  EXPECT_TRUE((Checkerboard{.columns = 7, .rows = 7, .square_m = 1}.isAmbiguous()));
}

TEST(Board, CountsPointsWhereASpecCountsSquaresOrTags) {
  const Board charuco = parseBoardSpec("charuco:8x11:24mm:18.75mm:DICT_4X4_1000");
  EXPECT_EQ(charuco.columns(), 7);
  EXPECT_EQ(charuco.rows(), 10);
  EXPECT_TRUE(charuco.printed().sizes().isApprox(Eigen::Vector2d(8 * 0.024, 11 * 0.024)));
  EXPECT_FALSE(charuco.isAmbiguous());
  const Board grid = parseBoardSpec("aprilgrid:6x4:100mm:0.3");
  EXPECT_EQ(grid.columns(), 12);
  EXPECT_EQ(grid.rows(), 8);
  EXPECT_TRUE(grid.corner(2 * 12 + 3).isApprox(Eigen::Vector3d(0.23, 0.13, 0)));
  EXPECT_TRUE(grid.span().isApprox(Eigen::Vector2d(0.75, 0.49)));
  EXPECT_EQ((AprilGrid{.columns = 6, .rows = 4, .tag_m = 0.1, .gap = 0.3}.tagId(0, 3)), 0);
}

// As in OpenCV's documentation of findCirclesGrid: every other row is shifted by the spacing.
TEST(Board, PlacesTheCirclesOfAsymmetricGridsAsOpenCvDoes) {
  const Board board = parseBoardSpec("acircles:4x11:20mm:14mm");
  EXPECT_EQ(board.numCorners(), 44);
  EXPECT_EQ(board.discRadius(), 0.007);
  EXPECT_TRUE(board.corner(3).isApprox(Eigen::Vector3d(0.12, 0, 0)));
  EXPECT_TRUE(board.corner(4).isApprox(Eigen::Vector3d(0.02, 0.02, 0)));
  EXPECT_TRUE(board.corner(8).isApprox(Eigen::Vector3d(0, 0.04, 0)));
  EXPECT_TRUE(board.printed().sizes().isApprox(Eigen::Vector2d(0.154, 0.214)));
  EXPECT_NEAR(board.spacing(), std::sqrt(2) * 0.02, 1e-15);
  EXPECT_FALSE(board.isAmbiguous());
  EXPECT_TRUE(parseBoardSpec("acircles:4x10:20mm:14mm").isAmbiguous());
  EXPECT_EQ(parseBoardSpec("circles:10x8:25mm:15mm").symmetryStep(), 2);
  EXPECT_EQ(parseBoardSpec("circles:8x8:25mm:15mm").symmetryStep(), 1);
}

}  // namespace
}  // namespace alidade
