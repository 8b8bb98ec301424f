// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/detect/board/x_corner.h"

namespace alidade {

/// A node of a mesh: counted along the mesh's own two directions, from an arbitrary origin.
struct MeshNode {
  int i = 0;
  int j = 0;
  friend bool operator==(const MeshNode&, const MeshNode&) = default;
};

[[nodiscard]] inline MeshNode step(MeshNode node, int direction) {
  constexpr int kI[4] = {1, 0, -1, 0};
  constexpr int kJ[4] = {0, 1, 0, -1};
  return {node.i + kI[direction & 3], node.j + kJ[direction & 3]};
}

struct MeshCorner {
  Eigen::Vector2d pixel{0, 0};
  double contrast = 0;  ///< between bright and dark squares around it, grey levels
};

/// Corners that are neighbours of each other, as a piece of a square grid with holes. Directions 0 to 3 are
/// +i, +j, -i, -j and turn clockwise in the image. The colours of the squares alternate, so one flag
/// determines all of them.
class CornerMesh {
 public:
  /// True if the square between (0, 0) and (1, 1) is dark.
  bool origin_square_is_dark = false;

  [[nodiscard]] const MeshCorner* find(MeshNode node) const {
    if (node.i < min_.i || node.j < min_.j || node.i > max_.i || node.j > max_.j) return nullptr;
    const auto& cell = cells_[index(node)];
    return cell ? &*cell : nullptr;
  }
  void insert(MeshNode node, const MeshCorner& corner);
  void erase(MeshNode node);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] MeshNode min() const { return min_; }  ///< of the nodes' bounding box
  [[nodiscard]] MeshNode max() const { return max_; }
  /// Number of nodes of the bounding box along a direction.
  [[nodiscard]] int length(int direction) const {
    return 1 + (direction % 2 == 0 ? max_.i - min_.i : max_.j - min_.j);
  }
  /// Shrinks the bounding box to the existing nodes.
  void shrink();

  [[nodiscard]] bool squareIsDark(MeshNode node) const {
    return origin_square_is_dark == ((node.i + node.j) % 2 == 0);
  }

  /// Step from a node towards the next one in a direction, from the existing neighbours: forward, backward or
  /// the mean of both; otherwise from those of neighbouring nodes. Nothing for an isolated node.
  [[nodiscard]] std::optional<Eigen::Vector2d> stepAt(MeshNode node, int direction) const;

  /// Predicted position of a missing node: by quadratic extrapolation along each line of three nodes that
  /// leads to it, by parallelograms, or by the midpoint of two neighbours. Nothing without neighbours like
  /// these.
  [[nodiscard]] std::optional<Eigen::Vector2d> predict(MeshNode node) const;

 private:
  [[nodiscard]] std::size_t index(MeshNode node) const {
    return static_cast<std::size_t>(node.j - min_.j) * static_cast<std::size_t>(max_.i - min_.i + 1) +
           static_cast<std::size_t>(node.i - min_.i);
  }
  void resize(MeshNode low, MeshNode high);

  MeshNode min_{0, 0};
  MeshNode max_{-1, -1};
  std::vector<std::optional<MeshCorner>> cells_;
  std::size_t size_ = 0;
};

/// The nodes on one side of the mesh's bounding box, or some lines further in.
[[nodiscard]] std::vector<MeshNode> sideNodes(const CornerMesh& mesh, int direction, int lines_in = 0);

/// Calls `visit(node, corner)` for every corner of `mesh`, row by row.
template <class Visit>
void forEachNode(const CornerMesh& mesh, Visit visit) {
  for (int j = mesh.min().j; j <= mesh.max().j; ++j) {
    for (int i = mesh.min().i; i <= mesh.max().i; ++i) {
      if (const MeshCorner* corner = mesh.find({i, j})) visit(MeshNode{i, j}, *corner);
    }
  }
}

/// Joins X-corners into meshes, largest first. Two corners are neighbours if an edge of each points at the
/// other, with the dark side on the same hand, and the image has that edge all the way between them. Only
/// closed quadrilaterals are kept. Strong distortion is therefore allowed (lines need not be straight), and
/// patterns that resemble corners only locally are rejected. Meshes of fewer than `min_size` corners are left
/// out.
[[nodiscard]] std::vector<CornerMesh> joinCorners(const SmoothImage& image, std::span<const XCorner> corners,
                                                  std::size_t min_size);

/// Adds corners that joinCorners() could not link, for example because of a scratch or a highlight: wherever
/// the mesh predicts a corner and the image shows four sectors of the right colours. Drops corners far from
/// the prediction of their neighbours, and outermost lines with only a few corners, which are mostly false.
void completeMesh(const SmoothImage& image, CornerMesh& mesh);

}  // namespace alidade
