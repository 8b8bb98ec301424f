// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "alidade/detect/board/corner_mesh.h"
#include "alidade/detect/board/x_corner.h"
#include "alidade/target/checkerboard.h"

namespace alidade {

/// Content of the image beyond the outermost corners of a mesh on one side.
enum class MeshSide {
  kUnclear,    ///< something in front of the board, a dark background, or it cannot be decided
  kOutside,    ///< the next line of corners would lie outside the image, and no margin is visible before it
  kCloses,     ///< the last squares are complete, followed by a margin as bright as the bright squares: the
               ///< board ends
  kContinues,  ///< more squares: the board continues
};

/// The four sides of a mesh, by direction (+i, +j, -i, -j).
using MeshSides = std::array<MeshSide, 4>;

[[nodiscard]] MeshSides lookAtSides(const SmoothImage& image, const CornerMesh& mesh);

/// A way to lay a mesh on a board: after rotation by quarter turns, its first column and row are these.
struct Placement {
  int quarter_turns = 0;  ///< number of the mesh direction along which the board's columns run
  int column = 0;
  int row = 0;

  /// Column and row of a node of the mesh.
  [[nodiscard]] std::array<int, 2> cell(const CornerMesh& mesh, MeshNode node) const;
};

/// All ways to lay the mesh on the board that neither its sides nor the colours of its squares exclude. A
/// board that looks the same after 180 degrees may have either colouring, so colours exclude nothing there,
/// except that corner 0 of a square board has a dark square if possible.
[[nodiscard]] std::vector<Placement> possiblePlacements(const CornerMesh& mesh, const MeshSides& sides,
                                                        const Checkerboard& board);

/// True if all placements put the mesh on the same corners, up to rotations under which the board looks the
/// same.
[[nodiscard]] bool areEquivalent(const std::vector<Placement>& placements, const CornerMesh& mesh,
                                 const Checkerboard& board);

}  // namespace alidade
