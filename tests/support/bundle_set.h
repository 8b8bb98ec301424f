// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/bundle_adjustment.h"
#include "support/model_fixture.h"
#include "support/simulated_set.h"

namespace alidade {

/// A bundle adjustment to be solved: corners with noise and all kinds of weights, and a start beside the
/// truth.
template <class M>
struct BundleSet {
  std::vector<std::vector<Observation>> views;
  BundleState state;

  /// @param outlier_px  how far every ninth corner is off in both coordinates
  BundleSet(int num_views, double outlier_px,
            const Checkerboard& board = {.columns = 9, .rows = 6, .square_m = 0.025}) {
    const auto p = ModelFixture<M>::paramSets().front();
    const SimulatedSet set = simulateSet(AnyCamera(Camera<M>(p)), kTestImage, num_views, 0.2, 5, {}, board);
    Random random(6);
    for (std::size_t v = 0; v < set.views.size(); ++v) {
      views.emplace_back();
      for (const Corner& corner : set.views[v].corners) {
        const double off = corner.id % 9 == 4 ? outlier_px : 0.0;
        views.back().push_back({.p_board = set.board.corner(corner.id),
                                .pixel = corner.pixel + Eigen::Vector2d(off, -off),
                                .weight = random.uniform(0.2, 3.0)});
      }
      SE3 pose = set.poses[v];
      pose.translation.z() *= 1.03;
      state.camera_from_board.push_back(pose);
    }
    state.params.assign(p.begin(), p.end());
    state.params[0] *= 1.02;
    state.params[2] += 3;
  }
};

}  // namespace alidade
