// SPDX-License-Identifier: MIT
#include "alidade/detect/board_placement.h"

#include <algorithm>
#include <optional>

namespace alidade {
namespace {

using Eigen::Vector2d;

// Colours seen at a square outside the outermost line of corners, and beyond it.
struct OuterSquare {
  bool is_dark = false;           ///< as the mesh's colours have it
  bool is_bright_beyond = false;  ///< where the next square would be
};

// The square outside corners `a` and `b` of the outermost line, `direction` leading out. Nothing if it is not
// seen there in its colour, or lies outside the image.
std::optional<OuterSquare> outerSquare(const SmoothImage& image, const CornerMesh& mesh, MeshNode a,
                                       MeshNode b, int direction) {
  const MeshCorner* corner_a = mesh.find(a);
  const MeshCorner* corner_b = mesh.find(b);
  if (corner_a == nullptr || corner_b == nullptr) return std::nullopt;
  const auto next_a = mesh.predict(step(a, direction));
  const auto next_b = mesh.predict(step(b, direction));
  if (!next_a || !next_b) return std::nullopt;
  const Vector2d middle = 0.5 * (corner_a->pixel + corner_b->pixel);
  const Vector2d outwards = 0.5 * (*next_a + *next_b) - middle;
  // Boards may end in half squares, and margins may be narrow.
  constexpr double kInside = 0.35;
  constexpr double kBeyond = 1.2;
  constexpr double kNearBeyond = 1.08;  // where the image ends there
  const Vector2d inner = middle - 0.5 * outwards;
  const Vector2d outer = middle + kInside * outwards;
  Vector2d beyond = middle + kBeyond * outwards;
  if (!image.covers(beyond)) beyond = middle + kNearBeyond * outwards;
  if (!image.covers(inner) || !image.covers(outer) || !image.covers(beyond)) return std::nullopt;

  // The square between two neighbours on the far side is named by its lowest node.
  const MeshNode out_a = step(a, direction);
  const MeshNode out_b = step(b, direction);
  const MeshNode lowest{std::min({a.i, b.i, out_a.i, out_b.i}), std::min({a.j, b.j, out_a.j, out_b.j})};
  OuterSquare square;
  square.is_dark = mesh.squareIsDark(lowest);
  const double level_inner = image.at(inner);
  const double level_outer = image.at(outer);
  const double contrast = square.is_dark ? level_inner - level_outer : level_outer - level_inner;
  constexpr double kNeededShare = 0.4;
  if (contrast < kNeededShare * 0.5 * (corner_a->contrast + corner_b->contrast)) return std::nullopt;
  square.is_bright_beyond = image.at(beyond) > 0.5 * (level_inner + level_outer);
  return square;
}

MeshSide lookAtSide(const SmoothImage& image, const CornerMesh& mesh, int direction) {
  const bool runs_along_j = direction % 2 == 0;
  const int line = direction == 0   ? mesh.max().i
                   : direction == 1 ? mesh.max().j
                   : direction == 2 ? mesh.min().i
                                    : mesh.min().j;
  const int first = runs_along_j ? mesh.min().j : mesh.min().i;
  const int last = runs_along_j ? mesh.max().j : mesh.max().i;
  const auto node = [&](int k) { return runs_along_j ? MeshNode{line, k} : MeshNode{k, line}; };
  int num_dark = 0;
  int num_dark_fit = 0;
  int num_bright = 0;
  int num_bright_close = 0;
  for (int k = first; k < last; ++k) {
    const auto square = outerSquare(image, mesh, node(k), node(k + 1), direction);
    if (!square) continue;
    if (square->is_dark) {
      ++num_dark;
      num_dark_fit += square->is_bright_beyond ? 1 : 0;
    } else {
      ++num_bright;
      num_bright_close += square->is_bright_beyond ? 1 : 0;
    }
  }
  // A bright square follows a dark one either way, be it a square or the margin; what follows the bright ones
  // tells. Where dark follows dark (a shadow, the rim of the image circle) nothing can be told.
  constexpr double kMost = 0.75;
  const int num_needed = std::min(3, last - first);
  if (num_dark == 0 || num_bright == 0 || num_dark + num_bright < num_needed) return MeshSide::kUnseen;
  if (num_dark_fit < kMost * num_dark) return MeshSide::kUnseen;
  if (num_bright_close >= kMost * num_bright) return MeshSide::kCloses;
  if (num_bright - num_bright_close >= kMost * num_bright) return MeshSide::kContinues;
  return MeshSide::kUnseen;
}

// The cell that a turn of the board, one that keeps its counts, carries to the place of `cell`.
std::array<int, 2> turned(const Checkerboard& board, std::array<int, 2> cell, int quarter_turns) {
  switch (quarter_turns) {
    case 0:
      return cell;
    case 1:
      return {cell[1], board.columns - 1 - cell[0]};
    case 2:
      return {board.columns - 1 - cell[0], board.rows - 1 - cell[1]};
    default:
      return {board.columns - 1 - cell[1], cell[0]};
  }
}

}  // namespace

MeshSides lookAtSides(const SmoothImage& image, const CornerMesh& mesh) {
  MeshSides sides{};
  for (int direction = 0; direction < 4; ++direction)
    sides[static_cast<std::size_t>(direction)] = lookAtSide(image, mesh, direction);
  return sides;
}

std::array<int, 2> Placement::cell(const CornerMesh& mesh, MeshNode node) const {
  switch (quarter_turns & 3) {
    case 0:
      return {column + node.i - mesh.min().i, row + node.j - mesh.min().j};
    case 1:
      return {column + node.j - mesh.min().j, row + mesh.max().i - node.i};
    case 2:
      return {column + mesh.max().i - node.i, row + mesh.max().j - node.j};
    default:
      return {column + mesh.max().j - node.j, row + node.i - mesh.min().i};
  }
}

std::vector<Placement> possiblePlacements(const CornerMesh& mesh, const MeshSides& sides,
                                          const Checkerboard& board) {
  std::vector<Placement> placements;
  const int along_i = mesh.max().i - mesh.min().i + 1;
  const int along_j = mesh.max().j - mesh.min().j + 1;
  for (int turns = 0; turns < 4; ++turns) {
    const int width = turns % 2 == 0 ? along_i : along_j;
    const int height = turns % 2 == 0 ? along_j : along_i;
    for (int row = 0; row + height <= board.rows; ++row) {
      for (int column = 0; column + width <= board.columns; ++column) {
        const std::array<bool, 4> touches = {column + width == board.columns, row + height == board.rows,
                                             column == 0, row == 0};
        bool fits = true;
        for (std::size_t s = 0; s < 4; ++s) {
          const MeshSide side = sides[(s + static_cast<std::size_t>(turns)) % 4];
          if (side == MeshSide::kCloses && !touches[s]) fits = false;
          if (side == MeshSide::kContinues && touches[s]) fits = false;
        }
        if (!fits) continue;
        const Placement placement{.quarter_turns = turns, .column = column, .row = row};
        if (board.coloursTellCorner0()) {
          // The square inside of the mesh's origin, on the board: its lowest column and row.
          const auto a = placement.cell(mesh, {0, 0});
          const auto b = placement.cell(mesh, {1, 1});
          const int parity = std::min(a[0], b[0]) + std::min(a[1], b[1]);
          const bool is_dark_on_board = parity % 2 == 0;
          if (is_dark_on_board != mesh.origin_square_is_dark) continue;
        }
        placements.push_back(placement);
      }
    }
  }
  return placements;
}

bool areEquivalent(const std::vector<Placement>& placements, const CornerMesh& mesh,
                   const Checkerboard& board) {
  if (placements.empty()) return false;
  const Placement& first = placements.front();
  const MeshNode low = mesh.min();
  const MeshNode high = mesh.max();
  return std::all_of(placements.begin(), placements.end(), [&](const Placement& other) {
    for (int turns = 0; turns < 4; turns += board.symmetryStep()) {
      if (turned(board, first.cell(mesh, low), turns) == other.cell(mesh, low) &&
          turned(board, first.cell(mesh, high), turns) == other.cell(mesh, high))
        return true;
    }
    return false;
  });
}

}  // namespace alidade
