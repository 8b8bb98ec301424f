// SPDX-License-Identifier: MIT
#include "alidade/adjust/local_sigma.h"

#include <cmath>

namespace alidade {

NeighbourDifferences::NeighbourDifferences(const Checkerboard& board)
    : board_(board), index_of_(static_cast<std::size_t>(board.numCorners())) {}

void NeighbourDifferences::add(std::span<const Observation> corners,
                               std::span<const Eigen::Vector2d> errors) {
  constexpr int kUnseen = -1;
  index_of_.assign(index_of_.size(), kUnseen);
  for (std::size_t i = 0; i < corners.size(); ++i)
    index_of_[static_cast<std::size_t>(corners[i].id)] = static_cast<int>(i);
  const auto addPair = [&](int id, int neighbour) {
    const int a = index_of_[static_cast<std::size_t>(id)];
    const int b = index_of_[static_cast<std::size_t>(neighbour)];
    if (a == kUnseen || b == kUnseen) return;
    const auto i = static_cast<std::size_t>(a);
    const auto j = static_cast<std::size_t>(b);
    // The variances of both corners over that of a corner of weight 1.
    const double variance = 1 / corners[i].weight + 1 / corners[j].weight;
    sum_ += 2 * (errors[i] - errors[j]).squaredNorm() / variance;
    ++num_pairs_;
  };
  for (int id = 0; id < board_.numCorners(); ++id) {
    if ((id + 1) % board_.columns != 0) addPair(id, id + 1);
    if (id + board_.columns < board_.numCorners()) addPair(id, id + board_.columns);
  }
}

// A difference has twice the variance, and two coordinates.
double NeighbourDifferences::sigma() const {
  return std::sqrt(sum_ / (4.0 * num_pairs_));
}

double localSigma(const Fit& fit) {
  NeighbourDifferences differences(onlyBoard(fit).target);
  for (const FitView& view : fit.views) differences.add(view.corners, view.errors);
  return differences.sigma();
}

}  // namespace alidade
