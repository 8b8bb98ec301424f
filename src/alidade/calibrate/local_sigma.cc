// SPDX-License-Identifier: MIT
#include "alidade/calibrate/local_sigma.h"

#include <cmath>

namespace alidade {

double localSigma(const Checkerboard& board, std::span<const std::vector<Observation>> views,
                  std::span<const std::vector<Eigen::Vector2d>> errors) {
  constexpr int kUnseen = -1;
  double sum = 0;
  int num_pairs = 0;
  std::vector<int> index_of(static_cast<std::size_t>(board.numCorners()));
  for (std::size_t v = 0; v < views.size(); ++v) {
    index_of.assign(index_of.size(), kUnseen);
    for (std::size_t i = 0; i < views[v].size(); ++i) {
      const Eigen::Vector3d& p = views[v][i].p_board;
      const auto column = std::lround(p.x() / board.square_m);
      const auto row = std::lround(p.y() / board.square_m);
      index_of[static_cast<std::size_t>(row * board.columns + column)] = static_cast<int>(i);
    }
    const auto add = [&](int id, int neighbour) {
      const int a = index_of[static_cast<std::size_t>(id)];
      const int b = index_of[static_cast<std::size_t>(neighbour)];
      if (a == kUnseen || b == kUnseen) return;
      const auto i = static_cast<std::size_t>(a);
      const auto j = static_cast<std::size_t>(b);
      // The variances of both corners over that of a corner of weight 1.
      const double variance = 1 / views[v][i].weight + 1 / views[v][j].weight;
      sum += 2 * (errors[v][i] - errors[v][j]).squaredNorm() / variance;
      ++num_pairs;
    };
    for (int id = 0; id < board.numCorners(); ++id) {
      if ((id + 1) % board.columns != 0) add(id, id + 1);
      if (id + board.columns < board.numCorners()) add(id, id + board.columns);
    }
  }
  // A difference has twice the variance, and two coordinates.
  return std::sqrt(sum / (4.0 * num_pairs));
}

}  // namespace alidade
