// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "support/simulated_set.h"
#include "support/spoiled_set.h"

namespace alidade {
namespace {

// Views of a sheet of paper that waves by up to `height` of its half width, differently in each view.
std::vector<View> looseSheet(const SimulatedSet& set, double height, std::uint64_t seed) {
  const Eigen::Vector3d half = set.board.middle();
  Random random(seed);
  std::vector<View> views = set.views;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Eigen::Vector2d heights(random.normal(), random.normal());
    const Eigen::Vector2d phases(random.uniform(0, 6.28), random.uniform(0, 6.28));
    for (Corner& corner : views[v].corners) {
      Eigen::Vector3d p = set.board.corner(corner.id);
      const Eigen::Array2d at = 2.5 * (p - half).head<2>().array() / half.head<2>().array() + phases.array();
      p.z() = height * half.x() * heights.dot(at.sin().matrix());
      const Projection projection = set.camera.project(set.poses[v] * p);
      if (projection.ok()) corner.pixel = projection.pixel;
    }
  }
  dropOutside(views);
  return views;
}

// What a lens that explains it would have to be (folded, of unknown focal length) comes after it.
TEST(LooseSheet, IsTheFirstFailure) {
  int num_first = 0;
  for (const char* model : {"radtan", "kannala_brandt"}) {
    for (std::uint64_t i = 0; i < 3; ++i) {
      const SimulatedSet set = cleanSet(model, 15, 70 + i);
      const Calibration result = calibrate(set.board, looseSheet(set, 0.2, 80 + i), {});
      EXPECT_EQ(result.verdict(), Verdict::kNo) << model << " " << i;
      ASSERT_FALSE(result.diagnoses.empty());
      EXPECT_EQ(result.diagnoses.front().id, "misfit") << model << " " << i;
      num_first += result.diagnoses.front().id == "misfit" ? 1 : 0;
    }
  }
  EXPECT_EQ(num_first, 6);
}

}  // namespace
}  // namespace alidade
