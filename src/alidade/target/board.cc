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

std::string fieldText(double value, bool is_share) {
  return is_share ? exactText(value) : lengthText(value);
}
std::string fieldText(int value, bool) {
  return std::to_string(value);
}
std::string fieldText(const std::string& value, bool) {
  return value;
}

template <class Kind>
std::string specOf(const Kind& board) {
  std::string spec =
      std::string(Kind::kName) + ":" + std::to_string(board.columns) + "x" + std::to_string(board.rows);
  for (const auto& field : Kind::fields()) {
    std::visit(
        [&](const auto member) {
          const auto& value = board.*member;
          if (!field.is_optional || value != std::decay_t<decltype(value)>{})
            spec += ":" + fieldText(value, field.is_share);
        },
        field.member);
  }
  return spec;
}

}  // namespace

void Board::layOut() {
  std::visit(
      [this](const auto& board) {
        layout_ = board.layout();
        for (int id = 0; id < layout_.columns * layout_.rows; ++id) corners_.push_back(board.corner(id));
        for (const Eigen::Vector3d& corner : corners_) span_m_ = span_m_.cwiseMax(corner.head<2>());
        const Eigen::Vector2d margin(layout_.margin_m, layout_.margin_m);
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

std::optional<double> Board::gap() const {
  const AprilGrid* tags = std::get_if<AprilGrid>(&kind_);
  return tags != nullptr ? std::optional(tags->gap) : std::nullopt;
}

Board Board::withGap(double gap) const {
  AprilGrid tags = std::get<AprilGrid>(kind_);
  tags.gap = gap;
  Board board = tags;
  board.refuted_gap_ = refuted_gap_.value_or(*this->gap());
  return board;
}

bool Board::differsInLengthsFrom(const Board& other) const {
  return !(*this == other) && kind_.index() == other.kind_.index() && columns() == other.columns() &&
         rows() == other.rows() && markers() == other.markers();
}

std::string Board::spec() const {
  return std::visit([](const auto& board) { return specOf(board); }, kind_);
}

}  // namespace alidade
