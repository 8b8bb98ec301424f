// SPDX-License-Identifier: MIT
#include "alidade/simulate/ray_lattice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "alidade/core/random.h"

namespace alidade {
namespace {

constexpr ImageSize kSize = {.width = 330, .height = 245};  // not in whole blocks

struct LatticeCase {
  const char* name;
  const char* model;
  std::vector<double> params;
};

std::vector<LatticeCase> lensesWithoutRim() {
  return {{"pinhole of 70 degrees", "pinhole", {240, 240, 164, 122}},
          {"radtan of 60 degrees", "radtan", {280, 285, 170, 118, -0.25, 0.08, 1e-3, -5e-4, 0}}};
}

// For which the domain ends inside the image.
AnyCamera lensWithRim() {
  return AnyCamera::make("radtan", std::vector<double>{160, 160, 170, 118, -0.35, 0, 0, 0, 0});
}

Eigen::Vector3d rayAt(const RayExpansion& pixel, double x, double y) {
  Eigen::Matrix<double, 6, 1> powers;
  powers << 1, x, y, x * x, x * y, y * y;
  return pixel.terms * powers;
}

// What the header states, in pixels; the bound below adds its 1.5 d^3 / f^2 for the third order.
constexpr double kCentreError = 1e-5;

TEST(RayLattice, IsExactWhereThereIsNoRim) {
  for (const LatticeCase& lens : lensesWithoutRim()) {
    SCOPED_TRACE(lens.name);
    const AnyCamera camera = AnyCamera::make(lens.model, lens.params);
    const RayLattice lattice(camera, kSize, 1);
    Random random(2);
    std::vector<RayExpansion> row;
    double worst_centre = 0;
    double worst_share = 0;
    int num_checked = 0;
    for (int y = 0; y < kSize.height; ++y) {
      lattice.expandRow(y, row);
      ASSERT_EQ(row.size(), static_cast<std::size_t>(kSize.width));
      for (int x = 0; x < kSize.width; ++x) {
        const RayExpansion& pixel = row[static_cast<std::size_t>(x)];
        ASSERT_TRUE(pixel.has_ray);
        worst_centre =
            std::max(worst_centre, (camera.project(rayAt(pixel, 0, 0)).pixel - Eigen::Vector2d(x, y)).norm());
        const Eigen::Vector2d d(random.uniform(-2, 2), random.uniform(-2, 2));
        const Eigen::Vector2d at = camera.project(rayAt(pixel, d.x(), d.y())).pixel;
        const double bound = kCentreError + 1.5 * std::pow(d.norm(), 3) / (lens.params[0] * lens.params[0]);
        worst_share = std::max(worst_share, (at - Eigen::Vector2d(x, y) - d).norm() / bound);
        ++num_checked;
      }
    }
    EXPECT_EQ(num_checked, kSize.width * kSize.height);
    EXPECT_LT(worst_centre, kCentreError);
    EXPECT_LT(worst_share, 1);
  }
}

TEST(RayLattice, HasARayExactlyWhereTheCameraHasOne) {
  const AnyCamera camera = lensWithRim();
  const RayLattice lattice(camera, kSize, 1);
  std::vector<RayExpansion> row;
  int num_with_ray = 0;
  for (int y = 0; y < kSize.height; ++y) {
    lattice.expandRow(y, row);
    for (int x = 0; x < kSize.width; ++x) {
      const RayExpansion& pixel = row[static_cast<std::size_t>(x)];
      const auto ray = camera.unproject({x, y});
      ASSERT_EQ(pixel.has_ray, ray.has_value()) << x << " " << y;
      if (!ray) continue;
      ++num_with_ray;
      ASSERT_LT((rayAt(pixel, 0, 0) - *ray).norm(), 1e-5 / 160) << x << " " << y;
    }
  }
  // A disc of 104 pixels' radius.
  EXPECT_GT(num_with_ray, 30000);
  EXPECT_LT(num_with_ray, 36000);
}

TEST(RayLattice, ExpandsPixelsNearTheRim) {
  const AnyCamera camera = lensWithRim();
  const RayLattice lattice(camera, kSize, 1);
  std::vector<RayExpansion> row;
  lattice.expandRow(118, row);
  double worst = 0;
  int num_checked = 0;
  for (int x = 170; x < 170 + 85; ++x) {  // the rim is at 274; the nearer, the worse any series
    const RayExpansion& pixel = row[static_cast<std::size_t>(x)];
    worst = std::max(worst, (camera.project(rayAt(pixel, 1, 1)).pixel - Eigen::Vector2d(x + 1, 119)).norm());
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 85);
  EXPECT_LT(worst, 1e-3);
}

TEST(RayLattice, DoesNotDependOnTheNumberOfThreads) {
  const RayLattice one(lensWithRim(), kSize, 1);
  const RayLattice four(lensWithRim(), kSize, 4);
  std::vector<RayExpansion> row_one;
  std::vector<RayExpansion> row_four;
  for (int y = 0; y < kSize.height; ++y) {
    one.expandRow(y, row_one);
    four.expandRow(y, row_four);
    for (std::size_t x = 0; x < row_one.size(); ++x) ASSERT_EQ(row_one[x].terms, row_four[x].terms);
  }
}

}  // namespace
}  // namespace alidade
