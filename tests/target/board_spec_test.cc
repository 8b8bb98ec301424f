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
              (Checkerboard{.columns = 9, .rows = 6, .square_m = 0.025}))
        << square;
    ++num_checked;
  }
  EXPECT_EQ(parseBoardSpec("checkerboard:9x6:1in").square_m, 0.0254);
  EXPECT_EQ(num_checked, 5);
}

TEST(BoardSpec, SaysWhatIsWrong) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "board kind ''"},
      {"chekerboard:9x6:25mm", "did you mean 'checkerboard'?"},
      {"charuco:8x11:24mm:18mm:DICT_4X4_50", "board kind 'charuco'"},
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
  EXPECT_EQ(cases.size(), 21U);
}

TEST(BoardSpec, TextReadsBack) {
  for (const double square : {0.025, 0.1, 1.0 / 3.0, 0.0254, 1e-4}) {
    const Checkerboard board{.columns = 9, .rows = 6, .square_m = square};
    EXPECT_EQ(parseBoardSpec(specText(board)), board) << specText(board);
  }
  EXPECT_EQ(specText({.columns = 9, .rows = 6, .square_m = 0.025}), "checkerboard:9x6:25mm");
}

TEST(Checkerboard, NumbersCornersAlongTheColumnsFirst) {
  const Checkerboard board{.columns = 4, .rows = 3, .square_m = 0.5};
  const auto points = cornerPositions(board);
  ASSERT_EQ(points.size(), 12U);
  EXPECT_EQ(points[0], Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(points[3], Eigen::Vector3d(1.5, 0, 0));
  EXPECT_EQ(points[4], Eigen::Vector3d(0, 0.5, 0));
  EXPECT_FALSE(board.isAmbiguous());
  EXPECT_TRUE((Checkerboard{.columns = 4, .rows = 6, .square_m = 1}.isAmbiguous()));
  EXPECT_TRUE((Checkerboard{.columns = 7, .rows = 7, .square_m = 1}.isAmbiguous()));
}

}  // namespace
}  // namespace alidade
