// SPDX-License-Identifier: MIT
#include "alidade/compare/image_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/LU>

#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr int kLongSide = 40;

ImageSize turned(ImageSize size, int quarter_turns) {
  if (quarter_turns % 2 != 0) std::swap(size.width, size.height);
  return size;
}

// True if one image could be the other after resizing.
bool haveOneShape(ImageSize a, ImageSize b) {
  const auto cross = [](int side, int other) { return static_cast<double>(side) * other; };
  const double off = std::abs(cross(a.width, b.height) - cross(a.height, b.width));
  return off <= std::max({a.width, a.height, b.width, b.height});
}

std::int64_t numPixels(ImageSize size) {
  return std::int64_t{size.width} * size.height;
}

// Place `i` of `count` at equal steps along a side of `length` pixels. The first and last are half a pixel of
// the coarser grid (`coarse` pixels along the side) from the ends.
double placeAt(int i, int count, int length, int coarse) {
  const double edge = 0.5 / std::min(length, coarse);
  const double share = count == 1 ? 0.5 : edge + (1 - 2 * edge) * i / (count - 1);
  return share * length - 0.5;
}

}  // namespace

Eigen::Matrix3d ImageMatch::frameTurn() const {
  constexpr std::array<double, 4> kSine = {0, 1, 0, -1};
  const double sine = kSine[static_cast<std::size_t>(quarter_turns)];
  const double cosine = kSine[static_cast<std::size_t>(quarter_turns + 1) % 4];
  Eigen::Matrix3d turn;
  turn << cosine, -sine, 0,  //
      sine, cosine, 0,       //
      0, 0, 1;
  return turn;
}

std::vector<int> possibleTurns(ImageSize a, ImageSize b) {
  std::vector<int> turns;
  for (int i = 0; i < 4; ++i) {
    if (haveOneShape(turned(a, i), b)) turns.push_back(i);
  }
  return turns;
}

ImageMatch matchImages(ImageSize a, ImageSize b, int quarter_turns) {
  ImageMatch match{.quarter_turns = quarter_turns};
  ImageSize size = a;
  for (int i = 0; i < quarter_turns; ++i) {
    // Old pixel (x, y) is at (height - 1 - y, x).
    Eigen::Matrix2d quarter;
    quarter << 0, -1, 1, 0;
    match.b_from_a = quarter * match.b_from_a;
    match.offset = quarter * match.offset + Eigen::Vector2d(size.height - 1, 0);
    size = turned(size, 1);
  }
  expect(haveOneShape(size, b), "matched images have the same shape");
  const Eigen::Vector2d scale(static_cast<double>(b.width) / size.width,
                              static_cast<double>(b.height) / size.height);
  match.b_from_a = scale.asDiagonal() * match.b_from_a;
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5);
  match.offset = scale.cwiseProduct(match.offset + half) - half;
  const bool is_b_finer = numPixels(b) > numPixels(a);
  match.unit_size = is_b_finer ? b : a;
  if (is_b_finer) match.unit_from_a = match.b_from_a.cwiseAbs().rowwise().sum().asDiagonal();
  if (is_b_finer && quarter_turns % 2 != 0)
    std::swap(match.unit_from_a(0, 0), match.unit_from_a(1, 1));  // along a's axes
  match.unit_from_b = match.unit_from_a * match.b_from_a.inverse();
  return match;
}

MatchedGrid matchedGrid(ImageSize a, ImageSize b, const ImageMatch& match, int columns, int rows) {
  const ImageSize b_as_a = turned(b, match.quarter_turns);
  MatchedGrid grid{.columns = columns, .rows = rows, .pixels = {}};
  const double longer = std::max(a.width, a.height);
  const auto count = [&](int side) {
    return std::clamp(static_cast<int>(std::lround((kLongSide - 1) * side / longer)) + 1, 1, side);
  };
  if (columns == 0) grid.columns = std::min(count(a.width), b_as_a.width);
  if (rows == 0) grid.rows = std::min(count(a.height), b_as_a.height);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      grid.pixels.emplace_back(placeAt(column, grid.columns, a.width, b_as_a.width),
                               placeAt(row, grid.rows, a.height, b_as_a.height));
    }
  }
  return grid;
}

}  // namespace alidade
