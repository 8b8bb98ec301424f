// SPDX-License-Identifier: MIT
#include "alidade/simulate/ink_pattern.h"

#include <algorithm>
#include <cmath>

namespace alidade {

using Eigen::Vector2d;
using Eigen::Vector2i;

namespace {

double toSide(const Eigen::AlignedBox2d& box, const Vector2d& p) {
  return box.contains(p) ? std::min((p - box.min()).minCoeff(), (box.max() - p).minCoeff())
                         : box.exteriorDistance(p);
}

}  // namespace

double InkPattern::Mark::edgeDistance(const Vector2d& p) const {
  return is_disc ? std::abs((p - box.center()).norm() - 0.5 * box.sizes().x()) : toSide(box, p);
}

InkPattern::InkPattern(const BoardInk& ink) : extent_(ink.extent), paper_(ink.extent) {
  constexpr double kMarginShare = 0.1;
  const Vector2d margin = Vector2d::Constant(kMarginShare * extent_.sizes().maxCoeff());
  paper_.min() -= margin;
  paper_.max() += margin;
  // Cells of about one box each, so that few boxes are tested and edges are known from a distance.
  const double num_boxes = static_cast<double>(std::max<std::size_t>(1, ink.boxes.size() + ink.discs.size()));
  cell_m_ = std::sqrt(extent_.volume() / num_boxes);
  num_cells_ = (extent_.sizes() / cell_m_).array().ceil().cast<int>().max(1);
  cells_.resize(static_cast<std::size_t>(num_cells_.x()) * static_cast<std::size_t>(num_cells_.y()));
  for (const Eigen::AlignedBox2d& box : ink.boxes) add({.box = box});
  for (const Eigen::AlignedBox2d& disc : ink.discs) add({.box = disc, .is_disc = true});
}

void InkPattern::add(const Mark& mark) {
  const Vector2i first = cellAt(mark.box.min());
  const Vector2i last = cellAt(mark.box.max());
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x)
      cells_[static_cast<std::size_t>(y * num_cells_.x() + x)].push_back(mark);
  }
}

double InkPattern::edgeDistance(const Vector2d& p) const {
  if (!paper_.contains(p)) return toSide(paper_, p);
  if (!extent_.contains(p)) return std::min(toSide(paper_, p), toSide(extent_, p));
  const Vector2i cell = cellAt(p);
  const Vector2d low = extent_.min() + cell_m_ * cell.cast<double>();
  double distance = toSide({low, low + Vector2d(cell_m_, cell_m_)}, p);  // the content beyond the cell is
                                                                         // unknown
  for (const Mark& mark : marksIn(cell)) distance = std::min(distance, mark.edgeDistance(p));
  return distance;
}

}  // namespace alidade
