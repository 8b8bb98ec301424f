// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdio>

// The header is plain C and does not say so to C++; what it includes must not be wrapped with it.
#include <stdbool.h>
#include <stdint.h>
extern "C" {
#include <mrcal/mrcal.h>
}

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-9;  // px; both evaluate the same formula in double
constexpr int kNumPoints = 2000;     // of each set
constexpr double kFar = 1e4;  // px; farther out, towards a pole, rounding alone is more than kTolerance
// mrcal's inverse is an optimisation that stops early where the image hardly moves, so that its rays may miss
// their own pixel by more than ours do; px.
constexpr double kTheirInverse = 1e-4;

template <class M>
struct Mrcal {
  mrcal_lensmodel_t model{};
  const Camera<M>& camera;

  mrcal_point2_t project(const Eigen::Vector3d& ray) const {
    mrcal_point3_t p;
    p.x = ray.x();
    p.y = ray.y();
    p.z = ray.z();
    mrcal_point2_t q;
    EXPECT_TRUE(mrcal_project(&q, nullptr, nullptr, &p, 1, &model, camera.params().data()));
    return q;
  }

  Eigen::Vector3d unproject(const mrcal_point2_t& q) const {
    mrcal_point3_t v;
    EXPECT_TRUE(mrcal_unproject(&v, &q, 1, &model, camera.params().data()));
    return Eigen::Vector3d(v.x, v.y, v.z).normalized();
  }
};

// Points all over the domain, up to its rim: both project them alike, and our ray of a pixel has that pixel
// in theirs too. Their rays are ours as far as their inverse goes; some are beyond a fold, which it knows
// nothing of.
template <class M>
void compare(mrcal_lensmodel_type_t type, int num_sets) {
  int num_checked = 0;
  int num_inverted = 0;
  double worst_px = 0;
  double worst_inverse_px = 0;
  const auto distance = [](const Eigen::Vector2d& a, const mrcal_point2_t& b) {
    return std::hypot(a.x() - b.x, a.y() - b.y);
  };
  for (const auto& params : ModelFixture<M>::paramSets()) {
    const Camera<M> camera(params);
    Mrcal<M> theirs{.camera = camera};
    theirs.model.type = type;
    ASSERT_EQ(mrcal_lensmodel_num_params(&theirs.model), kNumParams<M>);
    const double max_angle = std::min(camera.cone().max_angle_rad, 1.4);
    Random random(3);
    for (int i = 0; i < kNumPoints; ++i) {
      const Eigen::Vector3d point =
          random.uniform(0.5, 20.0) *
          rayAt(max_angle * random.uniform(), random.uniform(0, 2 * std::numbers::pi));
      const Projection ours = camera.project(point);
      ASSERT_TRUE(ours.ok());
      const mrcal_point2_t pixel = theirs.project(point);
      if (std::max(std::abs(pixel.x), std::abs(pixel.y)) > kFar) continue;
      worst_px = std::max(worst_px, distance(ours.pixel, pixel));
      const Eigen::Vector2d same_pixel(pixel.x, pixel.y);
      const auto ray = camera.unproject(same_pixel);
      ASSERT_TRUE(ray);
      worst_inverse_px = std::max(worst_inverse_px, distance(same_pixel, theirs.project(*ray)));
      ++num_checked;
      const Projection their_ray = camera.project(theirs.unproject(pixel));
      if (their_ray.ok() && distance(their_ray.pixel, pixel) <= kTheirInverse) ++num_inverted;
    }
  }
  std::printf(
      "%-12s %d points: projections differ by %.1e px at most, inverses by %.1e px; %d of their inverses\n",
      std::string(M::kId).c_str(), num_checked, worst_px, worst_inverse_px, num_inverted);
  EXPECT_LE(worst_px, kTolerance);
  EXPECT_LE(worst_inverse_px, kTolerance);
  EXPECT_GE(num_checked, num_sets * kNumPoints * 4 / 5);
  EXPECT_LE(num_checked, num_sets * kNumPoints);
  EXPECT_GE(num_inverted, num_checked * 95 / 100);
}

TEST(MrcalAgreement, PinholeIsItsPinhole) {
  compare<Pinhole>(MRCAL_LENSMODEL_PINHOLE, 3);
}
TEST(MrcalAgreement, RadtanIsItsOpencv5) {
  compare<Radtan>(MRCAL_LENSMODEL_OPENCV5, 6);
}
TEST(MrcalAgreement, RationalIsItsOpencv8) {
  compare<Rational>(MRCAL_LENSMODEL_OPENCV8, 7);
}
TEST(MrcalAgreement, ThinPrismIsItsOpencv12) {
  compare<ThinPrism>(MRCAL_LENSMODEL_OPENCV12, 5);
}

}  // namespace
}  // namespace alidade
