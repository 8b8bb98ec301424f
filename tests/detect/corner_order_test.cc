// SPDX-License-Identifier: MIT
#include "alidade/detect/corner_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "alidade/simulate/board_pattern.h"

namespace alidade {
namespace {

constexpr double kPixelsPerSquare = 20;
constexpr int kOffset = 50;

struct Drawing {
  GrayImage image;
  CornerGrid grid;  // in the true order
};

// A board drawn square to the image, turned by `quarter_turns` about the image's middle.
Drawing draw(const Checkerboard& board, int quarter_turns) {
  const int side = 2 * kOffset + static_cast<int>(kPixelsPerSquare) * std::max(board.columns, board.rows);
  const double middle = 0.5 * (side - 1);
  const auto turned = [&](Eigen::Vector2d p) {
    for (int i = 0; i < quarter_turns; ++i) p = {middle - (p.y() - middle), middle + (p.x() - middle)};
    return p;
  };
  Drawing drawing;
  drawing.image.size = {.width = side, .height = side};
  drawing.image.pixels.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), 0);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const Eigen::Vector2d on_board =
          (Eigen::Vector2d(x, y) - Eigen::Vector2d(kOffset, kOffset)) / kPixelsPerSquare * board.square_m;
      const BoardTone tone = boardTone(board, on_board);
      const auto level = static_cast<std::uint8_t>(tone == BoardTone::kDark     ? 20
                                                   : tone == BoardTone::kBright ? 230
                                                                                : 120);
      const Eigen::Vector2d p = turned({x, y});
      drawing.image.pixels[static_cast<std::size_t>(std::lround(p.y()) * side + std::lround(p.x()))] = level;
    }
  }
  for (int id = 0; id < board.numCorners(); ++id) {
    drawing.grid.push_back(turned(Eigen::Vector2d(kOffset, kOffset) +
                                  board.corner(id).head<2>() / board.square_m * kPixelsPerSquare));
  }
  return drawing;
}

TEST(OrderCorners, FindsTheOnePhysicalOrderFromAnyOrderOfADetector) {
  int num_checked = 0;
  for (const Checkerboard& board : {Checkerboard{.columns = 9, .rows = 6, .square_m = 0.02},
                                    Checkerboard{.columns = 4, .rows = 5, .square_m = 0.02}}) {
    for (int turns = 0; turns < 4; ++turns) {
      const Drawing drawing = draw(board, turns);
      CornerGrid reversed = drawing.grid;
      std::reverse(reversed.begin(), reversed.end());
      CornerGrid mirrored;
      for (int id = 0; id < board.numCorners(); ++id) {
        const int row = id / board.columns;
        mirrored.push_back(
            drawing.grid[static_cast<std::size_t>((row + 1) * board.columns - 1 - id % board.columns)]);
      }
      CornerGrid both = mirrored;
      std::reverse(both.begin(), both.end());
      for (const CornerGrid& given : {drawing.grid, reversed, mirrored, both}) {
        EXPECT_EQ(orderCorners(drawing.image, board, given), drawing.grid) << turns << " quarter turns";
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 2 * 4 * 4);
}

TEST(OrderCorners, LetsTheColumnsOfAnAmbiguousBoardRunToTheRight) {
  int num_checked = 0;
  for (const Checkerboard& board : {Checkerboard{.columns = 4, .rows = 6, .square_m = 0.02},
                                    Checkerboard{.columns = 5, .rows = 5, .square_m = 0.02}}) {
    for (const int turns : {0, 2}) {
      const Drawing drawing = draw(board, turns);
      const CornerGrid ordered = orderCorners(drawing.image, board, drawing.grid);
      EXPECT_GT(ordered[1].x() - ordered[0].x(), 10);
      EXPECT_GT(ordered[static_cast<std::size_t>(board.columns)].y() - ordered[0].y(), 10);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4);
}

TEST(SidesThatContinue, SeesOnWhichSidesTheBoardGoesOn) {
  const Checkerboard whole{.columns = 9, .rows = 6, .square_m = 0.02};
  const Drawing drawing = draw(whole, 0);
  EXPECT_TRUE(sidesThatContinue(drawing.image, whole, drawing.grid).empty());

  const auto part = [&](int first_column, int columns, int first_row, int rows) {
    CornerGrid grid;
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        grid.push_back(drawing.grid[static_cast<std::size_t>((first_row + r) * 9 + first_column + c)]);
      }
    }
    return sidesThatContinue(drawing.image, {.columns = columns, .rows = rows, .square_m = 0.02}, grid);
  };
  EXPECT_EQ(part(1, 8, 0, 6), std::vector<int>({0}));
  EXPECT_EQ(part(0, 9, 1, 5), std::vector<int>({1}));
  EXPECT_EQ(part(0, 8, 0, 6), std::vector<int>({2}));
  EXPECT_EQ(part(0, 9, 0, 5), std::vector<int>({3}));
  EXPECT_EQ(part(1, 7, 1, 4), std::vector<int>({0, 1, 2, 3}));
}

}  // namespace
}  // namespace alidade
