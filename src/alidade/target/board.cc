// SPDX-License-Identifier: MIT
#include "alidade/target/board.h"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "alidade/core/text.h"

namespace alidade {
namespace {

// Millimetres where that is exact in the text's digits, metres otherwise.
std::string lengthText(double metres) {
  char text[40];
  std::snprintf(text, sizeof text, "%.12gmm", metres * 1000);
  const auto back = parseDouble(std::string_view(text, std::string_view(text).size() - 2));
  if (back && *back / 1000 == metres) return text;
  return exactText(metres) + "m";
}

struct FieldText {
  bool is_share;

  std::string operator()(double value) const { return is_share ? exactText(value) : lengthText(value); }
  std::string operator()(int value) const { return std::to_string(value); }
  std::string operator()(const std::string& value) const { return value; }
};

template <class Kind>
std::string specOf(const Kind& board) {
  std::string spec =
      std::string(Kind::kName) + ":" + std::to_string(board.columns) + "x" + std::to_string(board.rows);
  for (const auto& field : Kind::fields()) {
    std::visit(
        [&](const auto member) {
          const auto& value = board.*member;
          if (!field.is_optional || value != std::decay_t<decltype(value)>{})
            spec += ":" + FieldText{field.is_share}(value);
        },
        field.member);
  }
  return spec;
}

}  // namespace

template <class Kind>
void Board::placeCorners(const Kind& board, int columns, int rows, double margin_m) {
  columns_ = columns;
  rows_ = rows;
  for (int id = 0; id < columns * rows; ++id) corners_.push_back(board.corner(id));
  for (const Eigen::Vector3d& corner : corners_) span_m_ = span_m_.cwiseMax(corner.head<2>());
  const Eigen::Vector2d margin(margin_m, margin_m);
  printed_ = {-margin, span_m_ + margin};
}

Board::Board(const Checkerboard& board)
    : kind_(board), spacing_m_(board.square_m), symmetry_step_(board.symmetryStep()) {
  placeCorners(board, board.columns, board.rows, board.square_m);
}

Board::Board(const CharucoBoard& board) : kind_(board), spacing_m_(board.square_m) {
  placeCorners(board, board.columns - 1, board.rows - 1, board.square_m);
}

Board::Board(const AprilGrid& board) : kind_(board), spacing_m_(board.tag_m * std::min(1.0, board.gap)) {
  placeCorners(board, 2 * board.columns, 2 * board.rows, board.gap * board.tag_m);
}

Board::Board(const CircleGrid& board)
    : kind_(board),
      spacing_m_(board.spacing_m),
      disc_radius_m_(0.5 * board.diameter_m),
      symmetry_step_(board.symmetryStep()) {
  placeCorners(board, board.columns, board.rows, disc_radius_m_);
}

Board::Board(const AsymmetricCircleGrid& board)
    : kind_(board),
      spacing_m_(std::numbers::sqrt2 * board.spacing_m),
      disc_radius_m_(0.5 * board.diameter_m),
      symmetry_step_(board.symmetryStep()) {
  placeCorners(board, board.columns, board.rows, disc_radius_m_);
}

std::string Board::spec() const {
  return std::visit([](const auto& board) { return specOf(board); }, kind_);
}

}  // namespace alidade
