// SPDX-License-Identifier: MIT
#include "alidade/detect/board/corner_mesh.h"

#include <algorithm>

namespace alidade {

using Eigen::Vector2d;

void CornerMesh::resize(MeshNode low, MeshNode high) {
  std::vector<std::optional<MeshCorner>> old = std::move(cells_);
  const MeshNode old_min = min_;
  const MeshNode old_max = max_;
  min_ = low;
  max_ = high;
  cells_.assign(static_cast<std::size_t>(high.i - low.i + 1) * static_cast<std::size_t>(high.j - low.j + 1),
                std::nullopt);
  std::size_t k = 0;
  for (int j = old_min.j; j <= old_max.j; ++j) {
    for (int i = old_min.i; i <= old_max.i; ++i, ++k) {
      if (old[k]) cells_[index({i, j})] = old[k];
    }
  }
}

void CornerMesh::insert(MeshNode node, const MeshCorner& corner) {
  if (max_.i < min_.i) {
    resize(node, node);
  } else {
    const MeshNode low{std::min(min_.i, node.i), std::min(min_.j, node.j)};
    const MeshNode high{std::max(max_.i, node.i), std::max(max_.j, node.j)};
    if (!(low == min_ && high == max_)) resize(low, high);
  }
  auto& cell = cells_[index(node)];
  if (!cell) ++size_;
  cell = corner;
}

void CornerMesh::erase(MeshNode node) {
  if (find(node) == nullptr) return;
  cells_[index(node)].reset();
  --size_;
}

void CornerMesh::shrink() {
  CornerMesh inner;
  inner.origin_square_is_dark = origin_square_is_dark;
  forEachNode(*this, [&](MeshNode node, const MeshCorner& corner) { inner.insert(node, corner); });
  *this = std::move(inner);
}

std::vector<MeshNode> sideNodes(const CornerMesh& mesh, int direction, int lines_in) {
  const int along = direction % 2 == 0 ? 1 : 0;
  MeshNode node{direction == 0 ? mesh.max().i : mesh.min().i, direction == 1 ? mesh.max().j : mesh.min().j};
  for (int k = 0; k < lines_in; ++k) node = step(node, direction + 2);
  std::vector<MeshNode> nodes;
  for (int k = 0; k < mesh.length(along); ++k, node = step(node, along)) nodes.push_back(node);
  return nodes;
}

std::optional<Vector2d> CornerMesh::stepAt(MeshNode node, int direction) const {
  const auto direct = [&](MeshNode at) -> std::optional<Vector2d> {
    const MeshCorner* here = find(at);
    const MeshCorner* ahead = find(step(at, direction));
    const MeshCorner* behind = find(step(at, direction + 2));
    if (ahead != nullptr && behind != nullptr) return 0.5 * (ahead->pixel - behind->pixel);
    if (here == nullptr) return std::nullopt;
    if (ahead != nullptr) return ahead->pixel - here->pixel;
    if (behind != nullptr) return here->pixel - behind->pixel;
    return std::nullopt;
  };
  if (const auto own = direct(node)) return own;
  Vector2d sum(0, 0);
  int count = 0;
  for (const int sideways : {direction + 1, direction + 3}) {
    if (const auto other = direct(step(node, sideways))) {
      sum += *other;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return Vector2d(sum / count);
}

std::optional<Vector2d> CornerMesh::predict(MeshNode node) const {
  Vector2d sum(0, 0);
  double weight = 0;
  const auto add = [&](const Vector2d& place, double w) {
    sum += w * place;
    weight += w;
  };
  for (int d = 0; d < 4; ++d) {
    const MeshNode n1 = step(node, d);
    const MeshNode n2 = step(n1, d);
    const MeshCorner* a = find(n1);
    const MeshCorner* b = find(n2);
    if (a != nullptr && b != nullptr) {
      const MeshCorner* c = find(step(n2, d));
      add(2 * a->pixel - b->pixel, 1);
      // Distortion bends lines; a third corner measures the bend, but triples the noise.
      if (c != nullptr) add(3 * a->pixel - 3 * b->pixel + c->pixel, 1);
    }
    const MeshCorner* side = find(step(node, d + 1));
    const MeshCorner* diagonal = find(step(n1, d + 1));
    if (a != nullptr && side != nullptr && diagonal != nullptr)
      add(a->pixel + side->pixel - diagonal->pixel, 1);
    if (d < 2) {
      const MeshCorner* opposite = find(step(node, d + 2));
      if (a != nullptr && opposite != nullptr) add(0.5 * (a->pixel + opposite->pixel), 4);
    }
  }
  if (weight == 0) return std::nullopt;
  return Vector2d(sum / weight);
}

}  // namespace alidade
