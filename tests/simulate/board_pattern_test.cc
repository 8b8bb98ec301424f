// SPDX-License-Identifier: MIT
#include "alidade/simulate/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "alidade/core/random.h"

namespace alidade {
namespace {

constexpr Checkerboard kBoard = {.columns = 4, .rows = 3, .square_m = 0.03};

BoardTone toneInSquares(double x, double y) {
  return SquaresPattern(kBoard).tone({x, y});
}
double edgeInSquares(double x, double y) {
  return SquaresPattern(kBoard).edgeDistance({x, y});
}

TEST(BoardTone, AlternatesFromADarkSquareAtCornerZero) {
  EXPECT_EQ(toneInSquares(0.5, 0.5), BoardTone::kDark);
  EXPECT_EQ(toneInSquares(-0.5, -0.5), BoardTone::kDark);
  EXPECT_EQ(toneInSquares(0.5, -0.5), BoardTone::kBright);
  EXPECT_EQ(toneInSquares(-0.5, 0.5), BoardTone::kBright);
  int num_dark = 0;
  int num_bright = 0;
  int num_background = 0;
  for (int j = -4; j < kBoard.rows + 4; ++j) {
    for (int i = -4; i < kBoard.columns + 4; ++i) {
      const BoardTone tone = toneInSquares(i + 0.5, j + 0.5);
      num_dark += tone == BoardTone::kDark ? 1 : 0;
      num_bright += tone == BoardTone::kBright ? 1 : 0;
      num_background += tone == BoardTone::kBackground ? 1 : 0;
    }
  }
  // 5 x 4 squares, half of them dark, on a paper of 7 x 6.
  EXPECT_EQ(num_dark, 10);
  EXPECT_EQ(num_bright, 7 * 6 - 10);
  EXPECT_EQ(num_background, 12 * 11 - 7 * 6);
}

TEST(BoardTone, BorderSquaresMayBeNarrow) {
  const auto tone = [](double x, double y) { return SquaresPattern(kBoard, 0.25).tone({x, y}); };
  EXPECT_EQ(tone(-0.2, -0.2), BoardTone::kDark);
  EXPECT_EQ(tone(-0.3, -0.2), BoardTone::kBright);
  EXPECT_EQ(tone(-1.2, 0.5), BoardTone::kBright);
  EXPECT_EQ(tone(-1.3, 0.5), BoardTone::kBackground);
  EXPECT_EQ(tone(3.2, -0.2), BoardTone::kDark);
  EXPECT_EQ(tone(3.2, 1.5), BoardTone::kDark);
  EXPECT_EQ(tone(3.3, 1.5), BoardTone::kBright);
  EXPECT_EQ(tone(2.5, 2.3), BoardTone::kBright);
}

TEST(BoardTone, IsBackgroundForWhatIsNotAPlace) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double x : {kInfinity, -kInfinity, kNan, 1e300, -1e300}) {
    EXPECT_EQ(toneInSquares(x, 0.5), BoardTone::kBackground) << x;
    EXPECT_EQ(toneInSquares(0.5, x), BoardTone::kBackground) << x;
  }
  EXPECT_TRUE(std::isnan(edgeInSquares(kNan, kNan)));
}

TEST(EdgeDistance, IsRightAtChosenPlaces) {
  constexpr double kTolerance = 1e-12;
  EXPECT_NEAR(edgeInSquares(0.5, 0.5), 0.5, kTolerance);
  EXPECT_NEAR(edgeInSquares(1.25, 2.5), 0.25, kTolerance);
  EXPECT_NEAR(edgeInSquares(2.0, 0.5), 0, kTolerance);
  EXPECT_NEAR(edgeInSquares(-1.25, 0.5), 0.25, kTolerance);   // margin, to the squares
  EXPECT_NEAR(edgeInSquares(4.875, 0.5), 0.125, kTolerance);  // margin, to the background
  EXPECT_NEAR(edgeInSquares(-1.4, -1.3), 0.5, kTolerance);    // margin's corner, to the squares' corner
  EXPECT_NEAR(edgeInSquares(-5, 0.5), 3, kTolerance);         // background, to a side
  EXPECT_NEAR(edgeInSquares(5 + 3, 4 + 4), 5, kTolerance);    // background, to the paper's corner
}

TEST(EdgeDistance, NoToneChangesNearerThanIt) {
  Random random(1);
  int num_checked = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = random.uniform(-5, 8);
    const double y = random.uniform(-5, 7);
    const double border_square = i % 2 == 0 ? 1 : random.uniform(0.1, 1);
    const SquaresPattern pattern(kBoard, border_square);
    const Eigen::Vector2d place(x, y);
    // A hair less than the distance, so that rounding does not carry the other place onto the edge.
    const double step = pattern.edgeDistance(place) * (1 - 1e-9) * std::sqrt(random.uniform());
    const double angle = random.uniform(0, 7);
    const Eigen::Vector2d other = place + step * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    ASSERT_EQ(pattern.tone(place), pattern.tone(other)) << x << " " << y << " " << border_square;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 20000);
}

}  // namespace
}  // namespace alidade
