// SPDX-License-Identifier: MIT
#include "alidade/print/ink_of_board.h"

#include <string_view>

#include "alidade/imagery/opencv_versions.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

void addSquare(std::vector<Eigen::AlignedBox2d>& boxes, double x, double y, double side) {
  boxes.emplace_back(Vector2d(x, y), Vector2d(x + side, y + side));
}

// Adds a marker with its border, one box for each run of dark cells in a row.
void addMarker(std::vector<Eigen::AlignedBox2d>& boxes, std::string_view dictionary_name, int id,
               const Vector2d& low, double side, int border, bool is_upside_down) {
  const MarkerDictionary of = findMarkerDictionary(dictionary_name).value();
  const int num_cells = of.num_bits + 2 * border;
  cv::Mat cells = detail::drawnMarker(detail::markerDictionary(of.opencv_id), id, num_cells, border);
  if (is_upside_down) cv::rotate(cells, cells, cv::ROTATE_180);
  const double cell = side / num_cells;
  for (int row = 0; row < num_cells; ++row) {
    for (int first = 0; first < num_cells;) {
      int last = first;
      while (last < num_cells && cells.at<std::uint8_t>(row, last) == 0) ++last;
      if (last > first) {
        boxes.emplace_back(low + cell * Vector2d(first, row), low + cell * Vector2d(last, row + 1));
      }
      first = last + 1;
    }
  }
}

void addInk(const Checkerboard& board, const InkOptions&, BoardInk& ink) {
  for (int row = -1; row < board.rows; ++row) {
    for (int column = -1; column < board.columns; ++column) {
      if ((column + row) % 2 == 0)
        addSquare(ink.boxes, column * board.square_m, row * board.square_m, board.square_m);
    }
  }
}

void addInk(const CharucoBoard& board, const InkOptions& options, BoardInk& ink) {
  const double margin = 0.5 * (board.square_m - board.marker_m);
  int id = board.first_id;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const Vector2d low = board.square_m * Vector2d(column - 1, row - 1);
      if (((column + row) % 2 == 0) != options.is_bright_first) {
        addSquare(ink.boxes, low.x(), low.y(), board.square_m);
      } else {
        addMarker(ink.boxes, board.dictionary, id++, low + Vector2d(margin, margin), board.marker_m, 1,
                  false);
      }
    }
  }
}

void addInk(const AprilGrid& board, const InkOptions& options, BoardInk& ink) {
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      addMarker(ink.boxes, AprilGrid::kDictionary, board.tagId(column, row),
                {board.tagPlace(column), board.tagPlace(row)}, board.tag_m, options.april_border,
                AprilGrid::kIsUpsideDown);
    }
  }
  const double gap = board.gap * board.tag_m;
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column)
      addSquare(ink.boxes, board.tagPlace(column) - gap, board.tagPlace(row) - gap, gap);
  }
}

template <class Grid>
void addDiscs(const Grid& board, BoardInk& ink) {
  const Vector2d radius = Vector2d::Constant(0.5 * board.diameter_m);
  for (int id = 0; id < board.columns * board.rows; ++id) {
    const Vector2d middle = board.corner(id).template head<2>();
    ink.discs.emplace_back(middle - radius, middle + radius);
  }
}

void addInk(const CircleGrid& board, const InkOptions&, BoardInk& ink) {
  addDiscs(board, ink);
}

void addInk(const AsymmetricCircleGrid& board, const InkOptions&, BoardInk& ink) {
  addDiscs(board, ink);
}

}  // namespace

BoardInk inkOf(const Board& board, const InkOptions& options) {
  BoardInk ink{.boxes = {}, .extent = board.printed()};
  std::visit([&](const auto& kind) { addInk(kind, options, ink); }, board.kind());
  return ink;
}

}  // namespace alidade
