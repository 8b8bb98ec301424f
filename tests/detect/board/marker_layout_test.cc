// SPDX-License-Identifier: MIT
// Layouts told from markers that are placed by a known board and homography.
#include "alidade/detect/board/marker_layout.h"

#include <gmock/gmock.h>

#include "alidade/core/random.h"

namespace alidade {
namespace {

using testing::ElementsAre;

Eigen::Matrix3d someHomography() {
  Eigen::Matrix3d h;
  h << 40, 6, 100, -8, 35, 90, 0.004, 0.012, 1;
  return h;
}

SeenMarker seenAt(int id, const Eigen::Vector2d& low, double side, const Eigen::Matrix3d& homography) {
  SeenMarker marker{.id = id, .corners = {}};
  const std::array<Eigen::Vector2d, 4> corners = {
      low, low + Eigen::Vector2d(side, 0), low + Eigen::Vector2d(side, side), low + Eigen::Vector2d(0, side)};
  for (std::size_t k = 0; k < 4; ++k)
    marker.corners[k] = (homography * corners[k].homogeneous()).hnormalized();
  return marker;
}

// Of a ChArUco board with squares of 1.
std::vector<SeenMarker> charucoMarkers(int columns, int rows, double side, bool is_dark_first,
                                       int first_id = 0) {
  std::vector<SeenMarker> markers;
  int id = first_id;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (((row + column) % 2 == 1) != is_dark_first) continue;
      const Eigen::Vector2d low = Eigen::Vector2d(column, row).array() + 0.5 * (1 - side);
      markers.push_back(seenAt(id++, low, side, someHomography()));
    }
  }
  return markers;
}

// Of an AprilGrid with tags of 1, upside down as Kalibr's are.
std::vector<SeenMarker> gridMarkers(int columns, int rows, double gap, int first_id, double shift = 0) {
  std::vector<SeenMarker> markers;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d low((1 + gap) * column + shift, (1 + gap) * row);
      markers.push_back(seenAt(first_id + (rows - 1 - row) * columns + column, low, 1, someHomography()));
      std::rotate(markers.back().corners.begin(), markers.back().corners.begin() + 2,
                  markers.back().corners.end());
    }
  }
  return markers;
}

std::vector<MarkerLayout> layoutsOf(const std::vector<SeenMarker>& markers, bool is_upside_down) {
  const std::vector<std::vector<SeenMarker>> images = {markers};
  return markerLayouts(images, is_upside_down);
}

TEST(MarkerLayouts, TellCountsAndFirstIdsOfCharucoBoardsOfBothLayouts) {
  int num_checked = 0;
  for (int columns = 3; columns <= 9; ++columns) {
    for (const int rows : {3, 4, 8}) {
      for (const bool is_dark_first : {true, false}) {
        for (const double side : {0.5, 0.75, 0.9}) {
          for (const int first_id : {0, 17, 18, 40}) {
            const auto layouts =
                layoutsOf(charucoMarkers(columns, rows, side, is_dark_first, first_id), false);
            SCOPED_TRACE(testing::Message()
                         << columns << "x" << rows << ":" << first_id << " dark " << is_dark_first);
            ASSERT_EQ(layouts.size(), 1U);
            EXPECT_TRUE(layouts[0].is_diagonal);
            EXPECT_EQ(layouts[0].columns, columns);
            EXPECT_EQ(layouts[0].rows, rows);
            EXPECT_EQ(layouts[0].first_id, first_id);
            EXPECT_NEAR(layouts[0].spacing * side, 1, 0.1);
            ++num_checked;
          }
        }
      }
    }
  }
  EXPECT_EQ(num_checked, 7 * 3 * 2 * 3 * 4);
}

TEST(MarkerLayouts, TellCountsAndFirstIdsOfAprilGrids) {
  int num_checked = 0;
  for (int columns = 2; columns <= 8; ++columns) {
    for (const int rows : {2, 3, 6}) {
      for (const int first_id : {0, 5, 36}) {
        const auto layouts = layoutsOf(gridMarkers(columns, rows, 0.3, first_id), true);
        ASSERT_EQ(layouts.size(), 1U) << columns << "x" << rows;
        EXPECT_FALSE(layouts[0].is_diagonal);
        EXPECT_EQ(layouts[0].columns, columns) << columns << "x" << rows << ":" << first_id;
        EXPECT_EQ(layouts[0].rows, rows) << columns << "x" << rows << ":" << first_id;
        EXPECT_EQ(layouts[0].first_id, first_id) << columns << "x" << rows;
        EXPECT_NEAR(layouts[0].spacing, 1.3, 0.05);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 7 * 3 * 3);
}

TEST(MarkerLayouts, JoinPartsThatDifferentImagesShow) {
  const auto whole = charucoMarkers(7, 9, 0.75, true);
  std::vector<std::vector<SeenMarker>> images(2);
  for (const SeenMarker& marker : whole) {
    if (marker.id < 18) images[0].push_back(marker);
    if (marker.id > 12) images[1].push_back(marker);
  }
  const auto layouts = markerLayouts(images, false);
  ASSERT_EQ(layouts.size(), 1U);
  EXPECT_EQ(layouts[0].columns, 7);
  EXPECT_EQ(layouts[0].rows, 9);
  EXPECT_EQ(layouts[0].ids.size(), whole.size());
}

TEST(MarkerLayouts, KeepTwoGridsApart) {
  auto markers = gridMarkers(3, 3, 0.3, 0);
  const auto second = gridMarkers(4, 2, 0.3, 9, 6.1);
  markers.insert(markers.end(), second.begin(), second.end());
  const auto layouts = layoutsOf(markers, true);
  ASSERT_EQ(layouts.size(), 2U);
  EXPECT_EQ(layouts[0].columns, 3);
  EXPECT_EQ(layouts[0].first_id, 0);
  EXPECT_EQ(layouts[1].columns, 4);
  EXPECT_EQ(layouts[1].rows, 2);
  EXPECT_EQ(layouts[1].first_id, 9);
}

// A marker that is read wrongly tells no count, nor do many.
TEST(MarkerLayouts, AreNotMisledByWrongIds) {
  auto markers = charucoMarkers(8, 8, 0.75, false);
  markers[5].id = 700;
  const auto layouts = layoutsOf(markers, false);
  ASSERT_EQ(layouts.size(), 1U);
  EXPECT_EQ(layouts[0].columns, 8);
  EXPECT_EQ(layouts[0].rows, 8);
  Random random(3);
  for (SeenMarker& marker : markers) marker.id = static_cast<int>(random.index(1000));
  const auto wrong = layoutsOf(markers, false);
  ASSERT_EQ(wrong.size(), 1U);
  EXPECT_EQ(wrong[0].columns, 0);
  EXPECT_EQ(wrong[0].rows, 0);
}

TEST(MarkerLayouts, AreNoneOfMarkersThatLieAnyhow) {
  Random random(4);
  std::vector<SeenMarker> markers;
  for (int id = 0; id < 12; ++id) {
    Eigen::Matrix3d place = Eigen::Matrix3d::Identity();
    place.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(random.uniform(0, 6)).toRotationMatrix() * 20;
    place.topRightCorner<2, 1>() = Eigen::Vector2d(random.uniform(0, 2000), random.uniform(0, 2000));
    markers.push_back(seenAt(id, {0, 0}, 1, place));
  }
  EXPECT_THAT(layoutsOf(markers, false), ElementsAre());
  EXPECT_THAT(layoutsOf({}, false), ElementsAre());
  const std::vector<SeenMarker> few(markers.begin(), markers.begin() + 3);
  EXPECT_THAT(layoutsOf(few, true), ElementsAre());
  std::vector<SeenMarker> degenerate = charucoMarkers(5, 5, 0.75, true);
  for (SeenMarker& marker : degenerate) marker.corners.fill({7, 7});
  EXPECT_THAT(layoutsOf(degenerate, false), ElementsAre());
}

}  // namespace
}  // namespace alidade
