// SPDX-License-Identifier: MIT
#include "alidade/detect/board/board_placement.h"

#include <gmock/gmock.h>

#include <set>

namespace alidade {
namespace {

// A mesh as if seen square on, `width` along i and `height` along j.
CornerMesh makeMesh(int width, int height, bool origin_is_dark) {
  CornerMesh mesh;
  mesh.origin_square_is_dark = origin_is_dark;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) mesh.insert({i, j}, {.pixel = {20.0 * i, 20.0 * j}, .contrast = 100});
  }
  return mesh;
}

constexpr MeshSides kUnseen = {MeshSide::kUnclear, MeshSide::kUnclear, MeshSide::kUnclear,
                               MeshSide::kUnclear};

MeshSides closingAt(std::initializer_list<std::size_t> directions) {
  MeshSides sides = kUnseen;
  for (const std::size_t d : directions) sides[d] = MeshSide::kCloses;
  return sides;
}

const Checkerboard kPlacedBoard{.columns = 9, .rows = 6, .square_m = 0.02};

TEST(PossiblePlacements, AWholeBoardLiesOneWayByItsColours) {
  for (const bool is_dark : {true, false}) {
    const CornerMesh mesh = makeMesh(9, 6, is_dark);
    const auto placements = possiblePlacements(mesh, kUnseen, kPlacedBoard);
    ASSERT_EQ(placements.size(), 1U);
    EXPECT_TRUE(areEquivalent(placements, mesh, kPlacedBoard));
    // Corner 0 has a dark inner square: it is the mesh's origin if that one is dark, else the far end.
    const auto cell = placements.front().cell(mesh, is_dark ? MeshNode{0, 0} : MeshNode{8, 5});
    EXPECT_EQ(cell, (std::array<int, 2>{0, 0}));
  }
}

TEST(PossiblePlacements, TurnsKeepRowsClockwiseOfColumns) {
  const Checkerboard upright{.columns = 6, .rows = 9, .square_m = 0.02};
  const CornerMesh mesh = makeMesh(9, 6, true);
  const auto placements = possiblePlacements(mesh, kUnseen, upright);
  ASSERT_EQ(placements.size(), 1U);
  std::set<std::array<int, 2>> cells;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 9; ++i) {
      const auto cell = placements.front().cell(mesh, {i, j});
      EXPECT_TRUE(cell[0] >= 0 && cell[0] < 6 && cell[1] >= 0 && cell[1] < 9);
      cells.insert(cell);
    }
  }
  EXPECT_EQ(cells.size(), 54U);
  // One step along the board's columns, then one along its rows, turns clockwise in the image.
  const auto step_to = [&](MeshNode node) {
    const auto zero = placements.front().cell(mesh, {4, 3});
    const auto there = placements.front().cell(mesh, node);
    return std::array<int, 2>{there[0] - zero[0], there[1] - zero[1]};
  };
  const auto along_i = step_to({5, 3});
  const auto along_j = step_to({4, 4});
  EXPECT_EQ(along_i[0] * along_j[1] - along_i[1] * along_j[0], 1);
}

TEST(PossiblePlacements, APartIsPlacedOnlyByTheBorderItShows) {
  const CornerMesh mesh = makeMesh(7, 6, true);
  // Rows are all there; the columns may start at 0 or 2 as far as colours tell, or the board is turned.
  EXPECT_FALSE(areEquivalent(possiblePlacements(mesh, kUnseen, kPlacedBoard), mesh, kPlacedBoard));
  const auto left = possiblePlacements(mesh, closingAt({2}), kPlacedBoard);
  ASSERT_TRUE(areEquivalent(left, mesh, kPlacedBoard));
  EXPECT_EQ(left.front().cell(mesh, {0, 0}), (std::array<int, 2>{0, 0}));
  const auto right = possiblePlacements(mesh, closingAt({0}), kPlacedBoard);
  ASSERT_TRUE(areEquivalent(right, mesh, kPlacedBoard));
  EXPECT_EQ(right.front().cell(mesh, {0, 0}), (std::array<int, 2>{2, 0}));
  // Both ends of 7 columns cannot be those of 9.
  EXPECT_TRUE(possiblePlacements(mesh, closingAt({0, 2}), kPlacedBoard).empty());
}

TEST(PossiblePlacements, APartThatCouldLieEitherWayIsNotPlaced) {
  // 6 x 6 corners of 9 x 6: columns or rows of the board may run along i.
  const CornerMesh mesh = makeMesh(6, 6, true);
  EXPECT_FALSE(areEquivalent(possiblePlacements(mesh, kUnseen, kPlacedBoard), mesh, kPlacedBoard));
  EXPECT_FALSE(areEquivalent(possiblePlacements(mesh, closingAt({0}), kPlacedBoard), mesh, kPlacedBoard));
  EXPECT_TRUE(
      areEquivalent(possiblePlacements(mesh, closingAt({1, 2, 3}), kPlacedBoard), mesh, kPlacedBoard));
}

TEST(PossiblePlacements, ASideThatGoesOnIsNoEdgeOfTheBoard) {
  MeshSides sides = kUnseen;
  sides[0] = MeshSide::kContinues;
  EXPECT_TRUE(possiblePlacements(makeMesh(9, 6, true), sides, kPlacedBoard).empty());
  EXPECT_TRUE(possiblePlacements(makeMesh(10, 6, true), kUnseen, kPlacedBoard).empty());
}

TEST(AreEquivalent, CountsPlacementsOfAmbiguousBoardsUpToTheirSymmetry) {
  struct Case {
    int columns, rows;
    std::size_t num_placements;
  };
  int num_checked = 0;
  for (const Case& c : {Case{8, 6, 2}, Case{7, 5, 2}, Case{7, 7, 2}, Case{6, 6, 4}}) {
    const Checkerboard board{.columns = c.columns, .rows = c.rows, .square_m = 0.02};
    for (const bool is_dark : {true, false}) {
      const CornerMesh mesh = makeMesh(c.columns, c.rows, is_dark);
      const auto placements = possiblePlacements(mesh, kUnseen, board);
      EXPECT_EQ(placements.size(), c.num_placements) << c.columns << "x" << c.rows;
      EXPECT_TRUE(areEquivalent(placements, mesh, board));
      ++num_checked;
    }
    // A part that shows one end only: the same corners up to the turn that nobody sees.
    const CornerMesh part = makeMesh(c.columns - 1, c.rows, true);
    if (c.columns != c.rows) {
      EXPECT_TRUE(areEquivalent(possiblePlacements(part, closingAt({2}), board), part, board));
    }
    EXPECT_FALSE(areEquivalent(possiblePlacements(part, kUnseen, board), part, board) && c.columns == c.rows);
  }
  EXPECT_EQ(num_checked, 8);
}

TEST(CornerMesh, GrowsShrinksAndPredicts) {
  CornerMesh mesh = makeMesh(4, 3, true);
  EXPECT_EQ(mesh.size(), 12U);
  mesh.insert({-2, 1}, {.pixel = {-40, 20}, .contrast = 100});
  EXPECT_EQ(mesh.size(), 13U);
  EXPECT_EQ(mesh.min(), (MeshNode{-2, 0}));
  EXPECT_EQ(mesh.find({-1, 1}), nullptr);
  EXPECT_TRUE(mesh.squareIsDark({0, 0}) && !mesh.squareIsDark({-1, 0}) && mesh.squareIsDark({-1, -1}));
  ASSERT_TRUE(mesh.predict({-1, 1}));
  EXPECT_LT((*mesh.predict({-1, 1}) - Eigen::Vector2d(-20, 20)).norm(), 1e-9);
  mesh.erase({-2, 1});
  mesh.shrink();
  EXPECT_EQ(mesh.min(), (MeshNode{0, 0}));
  EXPECT_EQ(mesh.max(), (MeshNode{3, 2}));
  EXPECT_EQ(mesh.size(), 12U);
  EXPECT_EQ(*mesh.stepAt({0, 0}, 0), Eigen::Vector2d(20, 0));
  EXPECT_EQ(*mesh.stepAt({4, 1}, 1), Eigen::Vector2d(0, 20)) << "taken from the neighbour's line";
  EXPECT_FALSE(mesh.predict({9, 9}));
}

}  // namespace
}  // namespace alidade
