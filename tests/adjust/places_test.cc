// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/places.h"

#include <gtest/gtest.h>

#include "support/image_sizes.h"

namespace alidade {
namespace {

FitView viewAt(double u, double v) {
  FitView view;
  for (int id = 0; id < 12; ++id) {
    const int column = id % 4;
    const int row = id / 4;
    view.corners.push_back(
        {.p_board = Eigen::Vector3d::Zero(), .pixel = {u + 30 * column, v + 30 * row}, .id = id});
  }
  return view;
}

// The limit is 0.5 % of the diagonal: 4 px.
Fit fitOf(std::vector<FitView> views) {
  Fit fit = emptyFit("pinhole", kVga, {500, 500, 320, 240},
                     Checkerboard{.columns = 4, .rows = 3, .square_m = 0.03}, kNoLoss);
  fit.views = std::move(views);
  for (FitView& view : fit.views) {
    view.placement = fit.placements.size();
    fit.placements.emplace_back();
  }
  return fit;
}

TEST(Places, AreSharedByViewsThatDifferByLess) {
  const Fit fit =
      fitOf({viewAt(100, 100), viewAt(200, 100), viewAt(102, 101), viewAt(100, 105), viewAt(201, 99)});
  EXPECT_EQ(placesOf(fit), (std::vector<std::size_t>{0, 1, 0, 2, 1}));
  EXPECT_EQ(numPlaces(fit), 3U);
  EXPECT_EQ(numPlaces(fitOf({})), 0U);
}

TEST(Places, NeedMostCornersInCommon) {
  FitView half = viewAt(100, 100);
  half.corners.erase(half.corners.begin(), half.corners.begin() + 7);
  EXPECT_EQ(numPlaces(fitOf({viewAt(100, 100), half})), 2U);
  half = viewAt(100, 100);
  half.corners.erase(half.corners.begin(), half.corners.begin() + 4);
  EXPECT_EQ(numPlaces(fitOf({viewAt(100, 100), half})), 1U);
}

// A slow video is no single place.
TEST(Places, DoNotChain) {
  std::vector<FitView> views;
  for (int i = 0; i < 100; ++i) views.push_back(viewAt(50 + i, 100));
  EXPECT_GE(numPlaces(fitOf(views)), 12U);
}

TEST(Places, AddUpTheirViews) {
  std::vector<Reduced> views;
  for (int i = 1; i <= 3; ++i) {
    views.push_back({.information = Eigen::MatrixXd::Constant(2, 2, i),
                     .gradient = Eigen::VectorXd::Constant(2, 10 * i),
                     .squares = 1.0 * i,
                     .num_corners = i});
  }
  const std::vector<Reduced> places = sumByPlace(views, std::vector<std::size_t>{0, 1, 0});
  ASSERT_EQ(places.size(), 2U);
  EXPECT_EQ(places[0].information(1, 0), 4);
  EXPECT_EQ(places[0].gradient(1), 40);
  EXPECT_EQ(places[0].num_corners, 4);
  EXPECT_EQ(places[1].squares, 2);
}

}  // namespace
}  // namespace alidade
