// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/detect/board/corner_mesh.h"
#include "alidade/detect/board/x_corner.h"

namespace alidade {

/// Joins X-corners into meshes, largest first. Two corners are neighbours if an edge of each points at the
/// other, with the dark side on the same hand, and the picture has that edge all the way between them. Only
/// what closes to quadrilaterals is kept, so that neither bent lenses (nothing is assumed of lines or
/// homographies) nor patterns that merely look like corners from near lead astray. Meshes of fewer than
/// `min_size` corners are left out.
[[nodiscard]] std::vector<CornerMesh> joinCorners(const SmoothImage& image, std::span<const XCorner> corners,
                                                  std::size_t min_size);

/// Adds corners that joinCorners() could not link, such as those that a scratch or a highlight hides from
/// near: wherever the mesh predicts a corner and the picture shows four sectors of the right colours. Drops
/// corners that stand far from where their neighbours put them, and outermost lines of which only a few
/// corners are there: those are mostly none.
void completeMesh(const SmoothImage& image, CornerMesh& mesh);

}  // namespace alidade
