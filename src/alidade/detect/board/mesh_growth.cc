// SPDX-License-Identifier: MIT
#include "alidade/detect/board/mesh_growth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr int kNone = -1;

// The half-edge of another corner that a half-edge is linked to.
struct Link {
  int corner = kNone;
  int edge = kNone;
  [[nodiscard]] bool exists() const { return corner != kNone; }
  friend bool operator==(const Link&, const Link&) = default;
};
using Links = std::vector<std::array<Link, 4>>;

// The link of half-edge `edge` of a corner; edges count modulo 4.
Link& linkAt(Links& links, int corner, int edge) {
  return links[static_cast<std::size_t>(corner)][static_cast<std::size_t>(edge & 3)];
}

// Corners in square buckets, so that neighbours are found without comparing all pairs.
class Buckets {
 public:
  Buckets(std::span<const XCorner> corners, ImageSize size)
      : columns_(size.width / kSide + 1), rows_(size.height / kSide + 1) {
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (std::size_t c = 0; c < corners.size(); ++c)
      cell(columnOf(corners[c].pixel), rowOf(corners[c].pixel)).push_back(static_cast<int>(c));
  }

  /// Calls visit(corner) for all corners in the ring of buckets at this distance; false if the ring is
  /// outside all buckets.
  template <class Visit>
  bool ring(const Vector2d& center, int distance, Visit visit) {
    const int x = columnOf(center);
    const int y = rowOf(center);
    bool is_inside = false;
    for (int dy = -distance; dy <= distance; ++dy) {
      const int stride = std::abs(dy) == distance ? 1 : std::max(1, 2 * distance);
      for (int dx = -distance; dx <= distance; dx += stride) {
        if (x + dx < 0 || y + dy < 0 || x + dx >= columns_ || y + dy >= rows_) continue;
        is_inside = true;
        for (const int c : cell(x + dx, y + dy)) visit(c);
      }
    }
    return is_inside;
  }

  static constexpr int kSide = 16;

 private:
  [[nodiscard]] static int columnOf(const Vector2d& p) { return static_cast<int>(p.x()) / kSide; }
  [[nodiscard]] static int rowOf(const Vector2d& p) { return static_cast<int>(p.y()) / kSide; }
  std::vector<int>& cell(int column, int row) {
    return cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)];
  }

  int columns_;
  int rows_;
  std::vector<std::vector<int>> cells_;
};

// True if the image has an edge between two corners, with the dark side on the given hand (clockwise from the
// direction from a to b). It is sampled on both sides of the chord; distortion bends the edge by less than
// the distance between the samples.
bool hasEdge(const SmoothImage& image, const Vector2d& a, const Vector2d& b, bool dark_is_clockwise,
             double contrast) {
  const Vector2d along = b - a;
  const double length = along.norm();
  constexpr double kSideShare = 0.16;
  constexpr double kMinSidePx = 1.5;
  const double offset = std::max(kMinSidePx, kSideShare * length);
  // Clockwise in the image, where y points down.
  const Vector2d clockwise = Vector2d(-along.y(), along.x()) * (offset / length);
  constexpr int kNumPlaces = 5;
  constexpr int kNeeded = 4;
  constexpr double kNeededShare = 0.35;  // share of the corners' contrast
  int num_good = 0;
  for (int k = 0; k < kNumPlaces; ++k) {
    const Vector2d place = a + along * ((k + 1.0) / (kNumPlaces + 1));
    // Near the border of the image, there may be room only for narrower samples.
    Vector2d side = clockwise;
    while (side.norm() > kMinSidePx && !(image.covers(place + side) && image.covers(place - side)))
      side *= 0.5;
    if (!image.covers(place + side) || !image.covers(place - side)) continue;
    const double step = image.at(place - side) - image.at(place + side);
    if ((dark_is_clockwise ? step : -step) > kNeededShare * contrast) ++num_good;
  }
  return num_good >= kNeeded;
}

class Joiner {
 public:
  Joiner(const SmoothImage& image, std::span<const XCorner> corners)
      : image_(image), corners_(corners), buckets_(corners, image.size), links_(corners.size()) {}

  std::vector<CornerMesh> run(std::size_t min_size) {
    linkNeighbours();
    keepQuadrilaterals();
    std::vector<CornerMesh> meshes;
    node_of_.assign(corners_.size(), std::nullopt);
    for (std::size_t c = 0; c < corners_.size(); ++c) {
      if (node_of_[c]) continue;
      CornerMesh mesh = walkFrom(static_cast<int>(c));
      if (mesh.size() >= min_size) meshes.push_back(std::move(mesh));
    }
    std::stable_sort(meshes.begin(), meshes.end(),
                     [](const CornerMesh& a, const CornerMesh& b) { return a.size() > b.size(); });
    return meshes;
  }

 private:
  [[nodiscard]] const XCorner& corner(int c) const { return corners_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] int numCorners() const { return static_cast<int>(corners_.size()); }

  // The edge of corner b that points back towards corner a; none if they do not match.
  [[nodiscard]] int edgeBack(const XCorner& a, int edge, const XCorner& b) const {
    constexpr double kMinCos = 0.913;  // 24 degrees, for strong distortion and small rings
    const Vector2d way = b.pixel - a.pixel;
    const double least = kMinCos * way.norm();
    if (way.dot(a.edges[static_cast<std::size_t>(edge)]) < least) return kNone;
    for (int k = 0; k < 4; ++k) {
      if (-way.dot(b.edges[static_cast<std::size_t>(k)]) < least) continue;
      // Clockwise of the edge from a is counter-clockwise of it from b.
      if (a.sectorIsDark(edge) == b.sectorIsDark(k)) return kNone;
      return k;
    }
    return kNone;
  }

  [[nodiscard]] Link nearestAlong(int c, int edge) {
    const XCorner& here = corner(c);
    Link best;
    double best_distance = std::numeric_limits<double>::infinity();
    int num_visited = 0;
    const auto visit = [&](int other) {
      if (other == c) return;
      ++num_visited;
      const XCorner& there = corner(other);
      const double distance = (there.pixel - here.pixel).norm();
      constexpr double kMinDistance = 3.5;
      constexpr double kMaxContrastRatio = 3.5;
      if (distance >= best_distance || distance < kMinDistance) return;
      if (std::max(here.contrast, there.contrast) >
          kMaxContrastRatio * std::min(here.contrast, there.contrast))
        return;
      const int back = edgeBack(here, edge, there);
      if (back == kNone) return;
      if (!hasEdge(image_, here.pixel, there.pixel, here.sectorIsDark(edge),
                   std::min(here.contrast, there.contrast)))
        return;
      best = {.corner = other, .edge = back};
      best_distance = distance;
    };
    // Neighbours are among the nearest corners; without a limit, textures would take quadratic time.
    constexpr int kMaxVisited = 40;
    for (int distance = 0; buckets_.ring(here.pixel, distance, visit); ++distance) {
      if (best_distance <= distance * Buckets::kSide || num_visited > kMaxVisited) break;
    }
    return best;
  }

  void linkNeighbours() {
    Links wished(corners_.size());
    for (int c = 0; c < numCorners(); ++c) {
      for (int edge = 0; edge < 4; ++edge) linkAt(wished, c, edge) = nearestAlong(c, edge);
    }
    for (int c = 0; c < numCorners(); ++c) {
      for (int edge = 0; edge < 4; ++edge) {
        const Link to = linkAt(wished, c, edge);
        if (to.exists() && linkAt(wished, to.corner, to.edge) == Link{c, edge}) linkAt(links_, c, edge) = to;
      }
    }
  }

  // Walks around a square: forward along `edge`, then always along the next edge on one hand. True if the
  // walk closes.
  [[nodiscard]] bool closes(int c, int edge, int turn) {
    Link at{.corner = c, .edge = edge};
    for (int side = 0; side < 4; ++side) {
      const Link next = linkAt(links_, at.corner, at.edge);
      if (!next.exists()) return false;
      // Arrived on next.edge, which points back; turns towards the inside of the square.
      at = {.corner = next.corner, .edge = (next.edge + turn) & 3};
    }
    return at == Link{c, edge};
  }

  void keepQuadrilaterals() {
    Links kept(corners_.size());
    for (int c = 0; c < numCorners(); ++c) {
      for (int edge = 0; edge < 4; ++edge) {
        if (closes(c, edge, 1) || closes(c, edge, 3)) linkAt(kept, c, edge) = linkAt(links_, c, edge);
      }
    }
    links_ = std::move(kept);
  }

  CornerMesh walkFrom(int start) {
    CornerMesh mesh;
    mesh.origin_square_is_dark = corner(start).sectorIsDark(0);
    // Edge k of corner c points in the direction k + turned[c] of the mesh.
    std::deque<int> open;
    turned_.resize(corners_.size());
    const auto put = [&](int c, MeshNode node, int turned) {
      node_of_[static_cast<std::size_t>(c)] = node;
      turned_[static_cast<std::size_t>(c)] = turned & 3;
      mesh.insert(node, {.pixel = corner(c).pixel, .contrast = corner(c).contrast});
      open.push_back(c);
    };
    put(start, {0, 0}, 0);
    while (!open.empty()) {
      const int c = open.front();
      open.pop_front();
      const MeshNode node = *node_of_[static_cast<std::size_t>(c)];
      const int turned = turned_[static_cast<std::size_t>(c)];
      for (int edge = 0; edge < 4; ++edge) {
        const Link next = linkAt(links_, c, edge);
        if (!next.exists() || node_of_[static_cast<std::size_t>(next.corner)]) continue;
        const int direction = (edge + turned) & 3;
        const MeshNode place = step(node, direction);
        if (mesh.find(place) != nullptr) continue;
        put(next.corner, place, direction + 2 - next.edge);
      }
    }
    return mesh;
  }

  const SmoothImage& image_;
  std::span<const XCorner> corners_;
  Buckets buckets_;
  Links links_;
  std::vector<std::optional<MeshNode>> node_of_;
  std::vector<int> turned_;
};

double spacingAt(const CornerMesh& mesh, MeshNode node) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int d = 0; d < 2; ++d) {
    if (const auto s = mesh.stepAt(node, d)) nearest = std::min(nearest, s->norm());
  }
  return nearest;
}

// Mean contrast of the corners around a node.
double contrastAround(const CornerMesh& mesh, MeshNode node) {
  double sum = 0;
  int count = 0;
  for (int dj = -2; dj <= 2; ++dj) {
    for (int di = -2; di <= 2; ++di) {
      if (const MeshCorner* corner = mesh.find({node.i + di, node.j + dj})) {
        sum += corner->contrast;
        ++count;
      }
    }
  }
  return count > 0 ? sum / count : 0;
}

// True if the four squares around a place have the colours that the mesh requires.
bool hasSectors(const SmoothImage& image, const CornerMesh& mesh, MeshNode node, const Vector2d& place,
                const Vector2d& u, const Vector2d& v, double contrast) {
  const double sign = mesh.squareIsDark(node) ? 1 : -1;
  const std::array<Vector2d, 4> outwards = {u + v, v - u, -u - v, u - v};
  for (const double wanted_share : {0.22, 0.4}) {
    double share = wanted_share;
    const auto isCovered = [&] {
      return std::all_of(outwards.begin(), outwards.end(),
                         [&](const Vector2d& out) { return image.covers(place + share * out); });
    };
    // Near the border of the image, there may be room only for closer samples.
    constexpr double kMinShare = 0.04;
    while (share > kMinShare && !isCovered()) share *= 0.6;
    if (!isCovered()) return false;
    std::array<double, 4> level{};
    for (std::size_t k = 0; k < 4; ++k) level[k] = sign * image.at(place + share * outwards[k]);
    // After multiplication by the sign, squares 0 and 2 are darker.
    constexpr double kNeededShare = 0.3;
    if (std::min(level[1], level[3]) - std::max(level[0], level[2]) < kNeededShare * contrast) return false;
  }
  return true;
}

// Searches the corner that the mesh predicts at a node.
std::optional<MeshCorner> lookFor(const SmoothImage& image, const CornerMesh& mesh, MeshNode node) {
  const auto predicted = mesh.predict(node);
  const auto u = mesh.stepAt(node, 0);
  const auto v = mesh.stepAt(node, 1);
  if (!predicted || !u || !v) return std::nullopt;
  const double spacing = std::min(u->norm(), v->norm());
  constexpr double kMinSpacing = 4;
  if (spacing < kMinSpacing || !image.covers(*predicted)) return std::nullopt;
  const double wanted_contrast = contrastAround(mesh, node);
  XCorner found;
  const double ring = std::clamp(0.3 * spacing, 2.0, 6.0);
  const double radius = 0.22 * spacing;
  if (!xCornerNear(image, *predicted, radius, ring, found)) return std::nullopt;
  if (found.contrast < 0.3 * wanted_contrast) return std::nullopt;
  if (!hasSectors(image, mesh, node, found.pixel, *u, *v, wanted_contrast)) return std::nullopt;
  return MeshCorner{.pixel = found.pixel, .contrast = found.contrast};
}

// Drops corners far from the centre of their neighbours: they were linked wrongly.
void dropMisfits(CornerMesh& mesh) {
  constexpr double kMaxMisfit = 0.25;  // share of the spacing
  std::vector<MeshNode> misfits;
  forEachNode(mesh, [&](MeshNode node, const MeshCorner& corner) {
    const auto predicted = mesh.predict(node);
    if (predicted && (*predicted - corner.pixel).norm() > kMaxMisfit * spacingAt(mesh, node))
      misfits.push_back(node);
  });
  // One bad corner spoils the predictions of its neighbours, so it is often unclear which of them is bad. All
  // are dropped, and completeMesh() finds the good ones again.
  for (const MeshNode node : misfits) mesh.erase(node);
}

// Drops outermost lines that hold far fewer corners than the next line inwards.
void dropStrayLines(CornerMesh& mesh) {
  constexpr double kFewest = 0.3;
  const auto count = [&](const std::vector<MeshNode>& nodes) {
    return std::ranges::count_if(nodes, [&](MeshNode node) { return mesh.find(node) != nullptr; });
  };
  bool is_done = false;
  while (!is_done && mesh.size() > 0) {
    is_done = true;
    for (const int direction : {3, 1, 2, 0}) {
      const std::vector<MeshNode> nodes = sideNodes(mesh, direction);
      const auto num_inner = static_cast<double>(count(sideNodes(mesh, direction, 1)));
      if (mesh.length(direction) == 1 || static_cast<double>(count(nodes)) >= kFewest * num_inner) continue;
      for (const MeshNode node : nodes) mesh.erase(node);
      is_done = false;
    }
    mesh.shrink();
  }
}

}  // namespace

std::vector<CornerMesh> joinCorners(const SmoothImage& image, std::span<const XCorner> corners,
                                    std::size_t min_size) {
  return Joiner(image, corners).run(min_size);
}

void completeMesh(const SmoothImage& image, CornerMesh& mesh) {
  dropMisfits(mesh);
  constexpr int kMaxRounds = 200;  // each round adds a line of corners, and no board has more lines
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<std::pair<MeshNode, MeshCorner>> found;
    for (int j = mesh.min().j - 1; j <= mesh.max().j + 1; ++j) {
      for (int i = mesh.min().i - 1; i <= mesh.max().i + 1; ++i) {
        if (mesh.find({i, j}) != nullptr) continue;
        if (const auto corner = lookFor(image, mesh, {i, j})) found.emplace_back(MeshNode{i, j}, *corner);
      }
    }
    if (found.empty()) break;
    for (const auto& [node, corner] : found) mesh.insert(node, corner);
  }
  mesh.shrink();
  dropStrayLines(mesh);
}

}  // namespace alidade
