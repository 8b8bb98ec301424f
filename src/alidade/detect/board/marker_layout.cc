// SPDX-License-Identifier: MIT
#include "alidade/detect/board/marker_layout.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <Eigen/LU>

#include "alidade/core/median.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr std::size_t kMinMarkers = 4;  // so many neighbours are no coincidence

// Two markers of the same image.
struct Neighbours {
  int from = 0;
  int to = 0;
  Vector2d offset;  // along the first marker's sides, in sides, without perspective
  Vector2i cells{0, 0};
};

// Position of another marker's centre along a marker's own sides, which are the unit.
Vector2d offsetFrom(const SeenMarker& marker, const SeenMarker& other) {
  const auto& c = marker.corners;
  Eigen::Matrix2d sides;
  sides << 0.5 * (c[1] - c[0] + c[2] - c[3]), 0.5 * (c[3] - c[0] + c[2] - c[1]);
  return sides.inverse() * (middleOf(other.corners) - middleOf(c));
}

// The markers near each other that lie in the same plane and have the same orientation.
std::vector<Neighbours> neighboursIn(const std::vector<SeenMarker>& markers) {
  constexpr double kReach = 7;      // in sides of a marker, for squares of three sides, two squares away
  constexpr double kMostOff = 0.3;  // share of the distance, changed by perspective
  std::vector<Neighbours> result;
  for (const SeenMarker& marker : markers) {
    for (const SeenMarker& other : markers) {
      if (marker.id == other.id) continue;
      const Vector2d there = offsetFrom(marker, other);
      const Vector2d back = offsetFrom(other, marker);
      const Vector2d offset = 0.5 * (there - back);
      if (!offset.allFinite() || offset.cwiseAbs().maxCoeff() > kReach) continue;
      if ((there + back).norm() <= 2 * kMostOff * offset.norm())
        result.push_back({.from = marker.id, .to = other.id, .offset = offset});
    }
  }
  return result;
}

// The nearest neighbour of each marker.
std::vector<Vector2d> nearestOffsets(const std::vector<std::vector<Neighbours>>& images) {
  std::vector<Vector2d> offsets;
  for (const auto& neighbours : images) {
    std::map<int, Vector2d> nearest;
    for (const Neighbours& n : neighbours) {
      const auto [at, is_new] = nearest.try_emplace(n.from, n.offset);
      if (!is_new && n.offset.norm() < at->second.norm()) at->second = n.offset;
    }
    for (const auto& [id, offset] : nearest) offsets.push_back(offset);
  }
  return offsets;
}

// Keeps the neighbours that lie in cells of the lattice, and sets their cells.
void placeInLattice(const MarkerLayout& layout, bool is_turned, std::vector<Neighbours>& neighbours) {
  constexpr double kMostOff = 0.3;  // cells
  const int reach = layout.is_diagonal ? 2 : 1;
  std::erase_if(neighbours, [&](Neighbours& n) {
    const Vector2d cells = (is_turned ? -1 : 1) * n.offset / layout.spacing;
    n.cells = {static_cast<int>(std::lround(cells.x())), static_cast<int>(std::lround(cells.y()))};
    const bool is_of_lattice = !layout.is_diagonal || n.cells.sum() % 2 == 0;
    return !is_of_lattice || n.cells.isZero() || n.cells.cwiseAbs().maxCoeff() > reach ||
           (cells - n.cells.cast<double>()).cwiseAbs().maxCoeff() > kMostOff;
  });
}

// The most frequent difference of ids between neighbours in these cells; 0 if there is none or others are
// nearly as frequent.
int commonestStep(const std::vector<Neighbours>& neighbours, const Vector2i& cells) {
  std::map<int, int> counts;
  int total = 0;
  for (const Neighbours& n : neighbours) {
    if (n.cells != cells) continue;
    ++counts[n.to - n.from];
    ++total;
  }
  const auto most = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  constexpr double kMost = 0.8;
  return most != counts.end() && most->second >= kMost * total ? most->first : 0;
}

// The quotient, rounded down, and the rest, which is not negative.
Vector2i divided(int n, int by) {
  const int quotient = n >= 0 ? n / by : -((by - 1 - n) / by);
  return {quotient, n - quotient * by};
}

int numInEvenRow(int columns, bool is_dark_first) {
  return is_dark_first ? columns / 2 : (columns + 1) / 2;
}

// Column and row of a marker of a diagonal lattice, with `first_id` in the first row.
Vector2i diagonalCell(int id, int columns, int first_id, bool is_dark_first) {
  const int in_even_row = numInEvenRow(columns, is_dark_first);
  const Vector2i pair = divided(id - first_id, columns);
  const bool is_odd_row = pair.y() >= in_even_row;
  const int place = is_odd_row ? pair.y() - in_even_row : pair.y();
  return {2 * place + (is_odd_row != is_dark_first ? 1 : 0), 2 * pair.x() + (is_odd_row ? 1 : 0)};
}

// Rows count upwards, from the first id of the first column.
Vector2i uprightCell(int id, int columns, int first_id) {
  const Vector2i row = divided(id - first_id, columns);
  return {row.y(), -row.x()};
}

constexpr int kMostColumns = 100;

// Takes the ids of the neighbours at the cells that `cellOf` predicts, if these are nearly all and a larger
// share than `best`.
template <class CellOf>
bool takeBetter(const std::vector<Neighbours>& neighbours, const CellOf& cellOf, double& best,
                MarkerLayout& layout) {
  constexpr double kLeastAgreeing = 0.9;
  std::set<int> ids;
  int count = 0;
  for (const Neighbours& n : neighbours) {
    if (cellOf(n.to) - cellOf(n.from) != n.cells) continue;
    ++count;
    ids.insert(n.from);
  }
  const double share = count / static_cast<double>(neighbours.size());
  if (share < kLeastAgreeing || share <= best) return false;
  best = share;
  layout.ids.assign(ids.begin(), ids.end());
  return true;
}

void countDiagonal(const std::vector<Neighbours>& neighbours, MarkerLayout& layout) {
  const int columns = commonestStep(neighbours, {0, 2});
  if (columns < 3 || columns > kMostColumns) return;
  double best = 0;
  for (int start = 0; start < columns; ++start) {
    for (const bool is_dark_first : {false, true}) {
      const auto cellOf = [&](int id) { return diagonalCell(id, columns, start, is_dark_first); };
      if (!takeBetter(neighbours, cellOf, best, layout)) continue;
      const Vector2i first = divided(cellOf(layout.ids.front()).y(), 2);
      layout.columns = columns;
      layout.first_id = start + first.x() * columns + first.y() * numInEvenRow(columns, is_dark_first);
      const int above = 2 * first.x() + first.y();
      layout.rows = cellOf(layout.ids.back()).y() - above + 1;
      // Ids nearly always start at 0, perhaps in a few rows that no image shows.
      constexpr int kUnseenPart = 8;
      const int num_unseen = above + (start == 0 ? 0 : 1);
      const bool is_aligned = start == 0 || start == numInEvenRow(columns, !is_dark_first);
      if (!is_aligned || kUnseenPart * num_unseen >= layout.rows) continue;
      layout.rows += num_unseen;
      layout.first_id = 0;
    }
  }
}

// The ends of rows determine the first id of each row; if no end is visible, rows start at 0.
void countUpright(const std::vector<Neighbours>& neighbours, MarkerLayout& layout) {
  const int columns = commonestStep(neighbours, {0, -1});
  if (columns < 1 || columns > kMostColumns) return;
  double best = 0;
  for (int start = 0; start < columns; ++start) {
    const auto cellOf = [&](int id) { return uprightCell(id, columns, start); };
    if (!takeBetter(neighbours, cellOf, best, layout)) continue;
    const int lowest = -cellOf(layout.ids.front()).y();
    layout.columns = columns;
    layout.first_id = start + lowest * columns;
    layout.rows = -cellOf(layout.ids.back()).y() - lowest + 1;
  }
  if (layout.first_id < 0) layout.columns = layout.rows = 0;
}

// Sets of ids that are connected through neighbours.
std::vector<std::set<int>> joinedIds(const std::vector<Neighbours>& neighbours) {
  std::map<int, std::set<int>> beside;
  for (const Neighbours& n : neighbours) {
    beside[n.from].insert(n.to);
    beside[n.to].insert(n.from);
  }
  std::vector<std::set<int>> sets;
  std::set<int> taken;
  for (const auto& [start, ignored] : beside) {
    if (taken.contains(start)) continue;
    std::set<int> joined;
    std::vector<int> open = {start};
    while (!open.empty()) {
      const int id = open.back();
      open.pop_back();
      if (!joined.insert(id).second) continue;
      open.insert(open.end(), beside[id].begin(), beside[id].end());
    }
    taken.insert(joined.begin(), joined.end());
    sets.push_back(std::move(joined));
  }
  return sets;
}

// A board has all ids from its first to its last, so parts with overlapping ranges of ids belong to one
// board.
std::vector<std::set<int>> boardsOf(std::vector<std::set<int>> parts) {
  // Without the ends of large parts, which may be wrong ids.
  const auto rangeOf = [](const std::set<int>& part) {
    const auto end = static_cast<std::ptrdiff_t>(part.size() / 20);
    return std::pair(*std::next(part.begin(), end), *std::next(part.rbegin(), end));
  };
  std::ranges::sort(parts, {}, rangeOf);
  std::vector<std::set<int>> boards;
  for (std::set<int>& part : parts) {
    if (boards.empty() || rangeOf(boards.back()).second < rangeOf(part).first) {
      boards.push_back(std::move(part));
    } else {
      boards.back().merge(part);
    }
  }
  return boards;
}

}  // namespace

std::vector<MarkerLayout> markerLayouts(std::span<const std::vector<SeenMarker>> images,
                                        bool is_upside_down) {
  std::vector<std::vector<Neighbours>> by_image;
  for (const auto& markers : images) by_image.push_back(neighboursIn(markers));
  const std::vector<Vector2d> nearest = nearestOffsets(by_image);
  if (nearest.size() < kMinMarkers) return {};
  std::vector<double> shorter;
  std::vector<double> longer;
  for (const Vector2d& offset : nearest) {
    shorter.push_back(offset.cwiseAbs().minCoeff());
    longer.push_back(offset.cwiseAbs().maxCoeff());
  }
  MarkerLayout common;
  common.spacing = medianOf(std::move(longer));
  common.is_diagonal = medianOf(std::move(shorter)) > 0.5 * common.spacing;
  std::vector<Neighbours> neighbours;
  for (auto& of_image : by_image) {
    placeInLattice(common, !common.is_diagonal && is_upside_down, of_image);
    neighbours.insert(neighbours.end(), of_image.begin(), of_image.end());
  }
  std::vector<MarkerLayout> layouts;
  for (const std::set<int>& ids : boardsOf(joinedIds(neighbours))) {
    if (ids.size() < kMinMarkers) continue;
    MarkerLayout layout = common;
    layout.ids.assign(ids.begin(), ids.end());
    std::vector<Neighbours> own;
    std::ranges::copy_if(neighbours, std::back_inserter(own),
                         [&](const Neighbours& n) { return ids.contains(n.from); });
    (common.is_diagonal ? countDiagonal : countUpright)(own, layout);
    layouts.push_back(std::move(layout));
  }
  return layouts;
}

}  // namespace alidade
