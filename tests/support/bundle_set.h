// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/camera/camera_variant.h"
#include "support/fit_set.h"
#include "support/model_fixture.h"

namespace alidade {

/// A fit to be solved: corners with noise and all kinds of weights, and a start beside the truth. Every ninth
/// corner is off in both coordinates.
template <class M>
[[nodiscard]] Fit bundleSet(int num_views, double outlier_px, HuberLoss loss = kNoLoss,
                            const Checkerboard& board = {.columns = 9, .rows = 6, .square_m = 0.025}) {
  const auto p = ModelFixture<M>::paramSets().front();
  const SimulatedSet set = simulateSet(AnyCamera(Camera<M>(p)), kTestImage, num_views, 0.2, 5, {}, board);
  Fit fit = fitAt(set, std::string(M::kId), {p.begin(), p.end()}, loss);
  Random random(6);
  for (FitView& view : fit.views) {
    for (Observation& corner : view.corners) {
      const double off = corner.id % 9 == 4 ? outlier_px : 0.0;
      corner.pixel += Eigen::Vector2d(off, -off);
      corner.sigma_px = std::numeric_limits<double>::quiet_NaN();
      corner.weight = random.uniform(0.2, 3.0);
    }
    fit.placements[view.placement].rig_from_body.translation.z() *= 1.03;
  }
  fit.cameras.front().params[0] *= 1.02;
  fit.cameras.front().params[2] += 3;
  return fit;
}

}  // namespace alidade
