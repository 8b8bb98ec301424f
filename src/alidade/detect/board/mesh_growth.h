// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/detect/board/corner_mesh.h"
#include "alidade/detect/board/x_corner.h"

namespace alidade {

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
