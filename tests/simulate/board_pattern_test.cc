// SPDX-License-Identifier: MIT
#include "alidade/simulate/ink_pattern.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "alidade/core/random.h"
#include "pattern_tone.h"

namespace alidade {
namespace {

constexpr Checkerboard kBoard = {.columns = 4, .rows = 3, .square_m = 0.03};

BoardTone toneInSquares(double x, double y, double border_square = 1) {
  return toneAt(InkPattern(kBoard, border_square), kBoard.square_m * Eigen::Vector2d(x, y));
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
  const auto tone = [](double x, double y) { return toneInSquares(x, y, 0.25); };
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
}

TEST(InkPattern, FindsExactlyTheMarksThatTouchAWindow) {
  Random random(1);
  int num_windows = 0;
  int num_found = 0;
  int num_refused = 0;
  for (int draw = 0; draw < 200; ++draw) {
    // Boxes of all sizes.
    BoardInk ink{.boxes = {}, .extent = {Eigen::Vector2d(-0.1, 0), Eigen::Vector2d(0.3, 0.2)}};
    const auto place = [&](double margin) -> Eigen::Vector2d {
      return {random.uniform(-0.1 - margin, 0.3 + margin), random.uniform(-margin, 0.2 + margin)};
    };
    const auto boxAround = [&](const Eigen::Vector2d& p, double largest) {
      const Eigen::Vector2d half(random.uniform(0, largest), random.uniform(0, largest));
      return Eigen::AlignedBox2d(p - half, p + half);
    };
    const auto markAround = [&](const Eigen::Vector2d& p, double largest) {
      return boxAround(p, largest).intersection(ink.extent);
    };
    for (std::uint64_t i = random.index(60); i > 0; --i) ink.boxes.push_back(markAround(place(0), 0.05));
    for (std::uint64_t i = random.index(60); i > 0; --i) ink.discs.push_back(markAround(place(0), 0.01));
    const InkPattern pattern(ink);
    std::vector<const InkPattern::Mark*> marks;
    for (std::size_t i = 0; i < 75; ++i) {
      const Eigen::AlignedBox2d window = boxAround(place(0.1), std::array{0.003, 0.04, 0.2}.at(i % 3));
      if (!pattern.findFewIn(window, marks)) {
        ++num_refused;
        continue;
      }
      const auto touches = [&](const Eigen::AlignedBox2d& box) { return box.intersects(window); };
      const auto isDisc = [](const InkPattern::Mark* mark) { return mark->is_disc; };
      // Each mark once and only what touches, so that equal numbers are equal sets.
      EXPECT_EQ(std::ranges::count_if(marks, isDisc), std::ranges::count_if(ink.discs, touches));
      EXPECT_EQ(std::ranges::ssize(marks) - std::ranges::count_if(marks, isDisc),
                std::ranges::count_if(ink.boxes, touches));
      EXPECT_TRUE(std::ranges::all_of(marks, [&](const auto* mark) { return touches(mark->box); }));
      std::ranges::sort(marks);
      EXPECT_EQ(std::ranges::adjacent_find(marks), marks.end());
      ++num_windows;
      num_found += static_cast<int>(marks.size());
    }
    EXPECT_TRUE(pattern.findFewIn(Eigen::AlignedBox2d(), marks));  // an empty window
    EXPECT_TRUE(marks.empty());
    const Eigen::Vector2d infinite = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
    if (ink.boxes.size() + ink.discs.size() > 30) {
      EXPECT_FALSE(pattern.findFewIn({-infinite, infinite}, marks));
    }
  }
  EXPECT_GT(num_windows, 3500);
  EXPECT_GT(num_found, 7000);
  EXPECT_GT(num_refused, 500);
}

}  // namespace
}  // namespace alidade
