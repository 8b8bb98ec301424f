// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/detect/corner/edge_model.h"

namespace alidade {

/// A parallelogram along the board's lines: center + a u + b v with |a| <= reach_u and |b| <= reach_v, where
/// u and v are the steps to the neighbouring corners. Pixels.
struct EdgeWindow {
  Eigen::Vector2d center;
  Eigen::Vector2d step_u;
  Eigen::Vector2d step_v;
  double reach_u = 0;  ///< as a share of the step
  double reach_v = 0;

  [[nodiscard]] std::array<double, 2> reachPx() const {
    return {reach_u * step_u.norm(), reach_v * step_v.norm()};
  }
  [[nodiscard]] double shorterReach() const { return std::min(reachPx()[0], reachPx()[1]); }
};

/// Takes every `stride`-th pixel of the window, in both directions, that is in the image. `origin` is the
/// pixel positions count from.
void gatherLattice(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                   int stride, EdgePixels& pixels);

/// Takes the pixels of the window that lie within `blur_reach` blurs + 0.5 px of one of the model's lines.
/// Line 0 runs along step_u, line 1 along step_v.
void gatherBands(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                 const EdgeModel& model, double blur_reach, EdgePixels& pixels);

}  // namespace alidade
