// SPDX-License-Identifier: MIT
#include "alidade/target/board.h"

#include <cstdio>
#include <type_traits>

#include "alidade/core/text.h"

namespace alidade {
namespace {

// Millimetres if they represent the length exactly, otherwise metres.
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

void Board::layOut() {
  std::visit(
      [this](const auto& board) {
        const PointLayout layout = board.layout();
        columns_ = layout.columns;
        rows_ = layout.rows;
        spacing_m_ = layout.spacing_m;
        disc_radius_m_ = layout.disc_radius_m;
        symmetry_step_ = layout.symmetry_step;
        for (int id = 0; id < columns_ * rows_; ++id) corners_.push_back(board.corner(id));
        for (const Eigen::Vector3d& corner : corners_) span_m_ = span_m_.cwiseMax(corner.head<2>());
        const Eigen::Vector2d margin(layout.margin_m, layout.margin_m);
        // Not {-margin, ...}: clang 14 would not emit the destructor of that box.
        printed_ = Eigen::AlignedBox2d(-margin, span_m_ + margin);
      },
      kind_);
}

BoardWords Board::words() const {
  return std::visit([](const auto& board) { return std::decay_t<decltype(board)>::kWords; }, kind_);
}

std::string Board::countsText() const {
  return std::visit(
      [](const auto& board) {
        return std::to_string(board.columns) + "x" + std::to_string(board.rows) + " " +
               std::string(board.kWords.counted);
      },
      kind_);
}

BoardPattern Board::pattern() const {
  return std::visit([](const auto& board) { return std::decay_t<decltype(board)>::kPattern; }, kind_);
}

std::optional<MarkerIds> Board::markers() const {
  return std::visit([](const auto& board) { return board.markers(); }, kind_);
}

bool Board::differsInLengthsFrom(const Board& other) const {
  return !(*this == other) && kind_.index() == other.kind_.index() && columns_ == other.columns_ &&
         rows_ == other.rows_ && markers() == other.markers();
}

std::string Board::spec() const {
  return std::visit([](const auto& board) { return specOf(board); }, kind_);
}

}  // namespace alidade
