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

bool InkPattern::Mark::contains(const Vector2d& p) const {
  return is_disc ? (p - box.center()).norm() <= 0.5 * box.sizes().x() : box.contains(p);
}

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

// The cell of a place, or the nearest one for a place outside.
Vector2i InkPattern::cellAt(const Vector2d& p) const {
  const Vector2d at = ((p - extent_.min()) / cell_m_).array().floor();
  const Vector2d last = (num_cells_.array() - 1).cast<double>();
  return at.cwiseMax(0.0).cwiseMin(last).cast<int>();
}

BoardTone InkPattern::tone(const Vector2d& p) const {
  if (!paper_.contains(p)) return BoardTone::kBackground;  // also for NaN
  if (!extent_.contains(p)) return BoardTone::kBright;
  const bool is_dark =
      std::ranges::any_of(marksIn(cellAt(p)), [&](const Mark& mark) { return mark.contains(p); });
  return is_dark ? BoardTone::kDark : BoardTone::kBright;
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
