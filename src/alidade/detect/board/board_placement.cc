// SPDX-License-Identifier: MIT
#include "alidade/detect/board/board_placement.h"

#include <algorithm>

namespace alidade {
namespace {

using Eigen::Vector2d;

// The image from the outermost line of corners outwards, over one square.
struct OuterSquare {
  bool is_seen = false;     // it shows its colour
  bool is_outside = false;  // the part beyond it is outside the image
  bool is_dark = false;     // by the colours of the mesh
  // The part beyond looks like the margin; a dark square must also end about one step from the line.
  bool closes = false;
  bool continues = false;  // the part beyond looks like a square of the other colour
};

// Examines the square outside corners `a` and `b` of the outermost line, with `direction` leading out.
OuterSquare lookAtSquare(const SmoothImage& image, const CornerMesh& mesh, MeshNode a, MeshNode b,
                         int direction) {
  const MeshCorner* corner_a = mesh.find(a);
  const MeshCorner* corner_b = mesh.find(b);
  if (corner_a == nullptr || corner_b == nullptr) return {};
  const auto next_a = mesh.predict(step(a, direction));
  const auto next_b = mesh.predict(step(b, direction));
  if (!next_a || !next_b) return {};
  const Vector2d middle = 0.5 * (corner_a->pixel + corner_b->pixel);
  const Vector2d outwards = 0.5 * (*next_a + *next_b) - middle;
  // Margins may be narrow; where the image ends early, a narrower strip of the margin must be enough.
  constexpr double kInside = 0.35;
  constexpr double kBeyond = 1.25;
  constexpr double kNearBeyond = 1.1;
  const Vector2d inner = middle - 0.5 * outwards;
  const Vector2d outer = middle + kInside * outwards;
  const double beyond = image.covers(middle + kBeyond * outwards) ? kBeyond : kNearBeyond;
  if (!image.covers(inner) || !image.covers(outer)) return {};
  if (!image.covers(middle + beyond * outwards)) return {.is_outside = true};

  // The lowest node of the square between two neighbours on the far side identifies it.
  const MeshNode out_a = step(a, direction);
  const MeshNode out_b = step(b, direction);
  const MeshNode lowest{std::min({a.i, b.i, out_a.i, out_b.i}), std::min({a.j, b.j, out_a.j, out_b.j})};
  OuterSquare square{.is_seen = true, .is_dark = mesh.squareIsDark(lowest)};
  const double level_inner = image.at(inner);
  const double level_outer = image.at(outer);
  const double contrast = square.is_dark ? level_inner - level_outer : level_outer - level_inner;
  constexpr double kNeededShare = 0.4;
  if (contrast < kNeededShare * 0.5 * (corner_a->contrast + corner_b->contrast)) return {};
  const double bright = square.is_dark ? level_inner : level_outer;
  const double dark = square.is_dark ? level_outer : level_inner;
  const double level_beyond = image.at(middle + beyond * outwards);
  // A cover, a sleeve or glare that is brighter than the centre is not a margin.
  constexpr double kAlike = 0.3;  // share of the contrast; light changes along a square
  const bool is_bright_beyond = std::abs(level_beyond - bright) < kAlike * contrast;
  const bool is_dark_beyond = std::abs(level_beyond - dark) < kAlike * contrast;
  square.continues = square.is_dark ? is_bright_beyond : is_dark_beyond;
  square.closes = is_bright_beyond;
  if (square.is_dark) {
    // A cover rarely ends exactly where the square does.
    constexpr double kStep = 0.05;
    constexpr double kMinEnd = 0.82;
    constexpr double kMaxEnd = 1.18;
    const double half = 0.5 * (bright + dark);
    double end = kInside;
    while (end < beyond && image.at(middle + end * outwards) < half) end += kStep;
    square.closes = square.closes && end >= kMinEnd && end <= kMaxEnd;
  }
  return square;
}

MeshSide lookAtSide(const SmoothImage& image, const CornerMesh& mesh, int direction) {
  const std::vector<MeshNode> nodes = sideNodes(mesh, direction);
  // Dark and bright squares.
  std::array<int, 2> num_seen{};
  std::array<int, 2> num_closing{};
  std::array<int, 2> num_continuing{};
  int num_outside = 0;
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k) {
    const OuterSquare square = lookAtSquare(image, mesh, nodes[k], nodes[k + 1], direction);
    num_outside += square.is_outside ? 1 : 0;
    if (!square.is_seen) continue;
    const std::size_t colour = square.is_dark ? 1 : 0;
    ++num_seen[colour];
    num_closing[colour] += square.closes ? 1 : 0;
    num_continuing[colour] += square.continues ? 1 : 0;
  }
  // Dark squares are followed by a bright square or by the margin, so the bright squares decide. If dark
  // follows dark (a shadow, the rim of the image circle), the side is unclear.
  const auto are_most = [&](const std::array<int, 2>& counts) {
    constexpr double kMost = 0.75;
    return counts[0] >= kMost * num_seen[0] && counts[1] >= kMost * num_seen[1];
  };
  constexpr double kShareSeen = 0.5;
  const int num_squares = static_cast<int>(nodes.size()) - 1;
  const int num_all = num_seen[0] + num_seen[1];
  const bool is_enough = num_seen[0] > 0 && num_seen[1] > 0 && num_all >= std::min(3, num_squares);
  if (is_enough && num_all >= kShareSeen * num_squares && are_most(num_closing)) return MeshSide::kCloses;
  if (is_enough && are_most(num_continuing)) return MeshSide::kContinues;
  return 2 * num_outside >= num_squares ? MeshSide::kOutside : MeshSide::kUnclear;
}

// Position of a cell of a grid of `columns` x `rows`, counted along the directions after so many quarter
// turns.
std::array<int, 2> turned(std::array<int, 2> cell, int columns, int rows, int quarter_turns) {
  const std::array<int, 4> along = {cell[0], cell[1], columns - 1 - cell[0], rows - 1 - cell[1]};
  const auto first = static_cast<std::size_t>(quarter_turns);
  return {along[first % 4], along[(first + 1) % 4]};
}

}  // namespace

MeshSides lookAtSides(const SmoothImage& image, const CornerMesh& mesh) {
  return {lookAtSide(image, mesh, 0), lookAtSide(image, mesh, 1), lookAtSide(image, mesh, 2),
          lookAtSide(image, mesh, 3)};
}

std::array<int, 2> Placement::cell(const CornerMesh& mesh, MeshNode node) const {
  const auto [along, across] =
      turned({node.i - mesh.min().i, node.j - mesh.min().j}, mesh.length(0), mesh.length(1), quarter_turns);
  return {column + along, row + across};
}

std::vector<Placement> possiblePlacements(const CornerMesh& mesh, const MeshSides& sides,
                                          const Checkerboard& board) {
  std::vector<Placement> placements;
  for (int turns = 0; turns < 4; ++turns) {
    const int width = mesh.length(turns);
    const int height = mesh.length(turns + 1);
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
          // The square inside the mesh's origin, on the board: its lowest column and row.
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
  return std::all_of(placements.begin(), placements.end(), [&](const Placement& other) {
    for (int turns = 0; turns < 4; turns += board.symmetryStep()) {
      const auto agrees = [&](MeshNode node) {
        return turned(first.cell(mesh, node), board.columns, board.rows, turns) == other.cell(mesh, node);
      };
      if (agrees(mesh.min()) && agrees(mesh.max())) return true;
    }
    return false;
  });
}

}  // namespace alidade
