// SPDX-License-Identifier: MIT
#include "alidade/calibrate/clean/view_fit.h"

#include <gtest/gtest.h>

#include <set>

namespace alidade {
namespace {

TEST(Renumbering, EachIsAnOrderOfItsOwnOfAllCorners) {
  const Checkerboard board{.columns = 7, .rows = 4, .square_m = 0.03};
  View view;
  for (int id = 0; id < board.numCorners(); ++id) view.corners.push_back({.id = id, .pixel = {id, 0}});
  std::set<std::vector<double>> orders;
  for (const auto& [how, renumbered] : renumberings(board, view)) {
    std::vector<double> order;
    for (int i = 0; i < board.numCorners(); ++i) {
      const Corner& corner = renumbered.corners[static_cast<std::size_t>(i)];
      EXPECT_EQ(corner.id, i) << how;
      order.push_back(corner.pixel.x());
    }
    orders.insert(order);
  }
  EXPECT_EQ(orders.size(), 7U);
}

TEST(Renumbering, ColumnsFirstPutsTheSecondCornerBelowTheFirst) {
  const Checkerboard board{.columns = 7, .rows = 4, .square_m = 0.03};
  View view;
  for (int id = 0; id < 6; ++id) view.corners.push_back({.id = id, .pixel = {id, 0}});
  const View renumbered = renumberings(board, view).front().second;
  EXPECT_EQ(renumbered.corners[0].id, 0);
  EXPECT_EQ(renumbered.corners[1].id, 1);  // the fifth: the first of the second column
  EXPECT_EQ(renumbered.corners[1].pixel.x(), 4);
  EXPECT_EQ(renumbered.corners[2].id, 7);
  EXPECT_EQ(renumbered.corners[2].pixel.x(), 1);
}

}  // namespace
}  // namespace alidade
