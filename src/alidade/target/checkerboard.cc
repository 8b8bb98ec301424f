// SPDX-License-Identifier: MIT
#include "alidade/target/checkerboard.h"

#include <cstdio>

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

}  // namespace

std::vector<Eigen::Vector3d> cornerPositions(const Checkerboard& board) {
  std::vector<Eigen::Vector3d> points;
  points.reserve(static_cast<std::size_t>(board.numCorners()));
  for (int id = 0; id < board.numCorners(); ++id) points.push_back(board.corner(id));
  return points;
}

std::string specText(const Checkerboard& board) {
  return "checkerboard:" + std::to_string(board.columns) + "x" + std::to_string(board.rows) + ":" +
         lengthText(board.square_m);
}

}  // namespace alidade
