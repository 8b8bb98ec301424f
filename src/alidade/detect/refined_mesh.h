// SPDX-License-Identifier: MIT
#pragma once

#include <utility>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/detect/checkerboard_detector.h"
#include "alidade/detect/corner_fit.h"
#include "alidade/detect/corner_mesh.h"

namespace alidade {

/// Calls `visit(node, corner)` for every corner of `mesh`, row by row.
template <class Visit>
void forEachNode(const CornerMesh& mesh, Visit visit) {
  for (int j = mesh.min().j; j <= mesh.max().j; ++j) {
    for (int i = mesh.min().i; i <= mesh.max().i; ++i) {
      if (const MeshCorner* corner = mesh.find({i, j})) visit(MeshNode{i, j}, *corner);
    }
  }
}

/// The corners of a mesh that could be refined, at their refined places.
struct RefinedMesh {
  CornerMesh mesh;
  std::vector<std::pair<MeshNode, CornerFit>> fits;
};

/// Refines every corner of `mesh`, whose pixels are those of `image`.
[[nodiscard]] RefinedMesh refineMesh(const GrayImage& image, const CornerMesh& mesh);

/// All squares must be turned the same way round, and no corner may stand far from where its neighbours put
/// it.
[[nodiscard]] bool isRegular(const CornerMesh& mesh);

/// What the refined corners say of the view: blur, contrast, the board's share of the image and its tilt.
/// `size` is that of the image.
[[nodiscard]] ViewMeasures measure(const RefinedMesh& refined, ImageSize size);

}  // namespace alidade
