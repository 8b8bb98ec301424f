// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>

#include "alidade/core/random.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kTolerance = 1e-12;  // relative; the same numbers in another order of operations
constexpr int kNumRays = 2000;

// Both lenses agree on whether a ray has an image, and on the image times `scale`.
template <class A, class B>
int compareLenses(const double* a, const double* b, double scale) {
  Random random(4);
  const double end = std::min(A::maxAngle(a), B::maxAngle(b)) - 1e-4;
  int num_checked = 0;
  for (int i = 0; i < kNumRays; ++i) {
    const Eigen::Vector3d ray =
        random.uniform(0.1, 50.0) * rayAt(end * random.uniform(), random.uniform(0, 2 * std::numbers::pi));
    double ma[2] = {};
    double mb[2] = {};
    EXPECT_TRUE(A::lens(a, ray.data(), ma));
    EXPECT_TRUE(B::lens(b, ray.data(), mb));
    const double size = std::hypot(ma[0], ma[1]);
    // Close to a pole both divide by a small difference.
    const double tolerance = kTolerance * size * (1 + size);
    EXPECT_NEAR(ma[0], scale * mb[0], tolerance);
    EXPECT_NEAR(ma[1], scale * mb[1], tolerance);
    ++num_checked;
  }
  return num_checked;
}

TEST(ModelIdentities, RationalWithoutDenominatorIsRadtan) {
  int num_checked = 0;
  for (const auto& p : ModelFixture<Radtan>::paramSets()) {
    const double rational[8] = {p[4], p[5], p[6], p[7], p[8], 0, 0, 0};
    num_checked += compareLenses<Radtan, Rational>(p.data() + 4, rational, 1.0);
    const Camera<Radtan> camera(p);
    const Camera<Rational> same({p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], 0, 0, 0});
    EXPECT_NEAR(camera.cone().max_angle_rad, same.cone().max_angle_rad, 1e-9);
    EXPECT_EQ(camera.cone().is_limited_by_fold, same.cone().is_limited_by_fold);
  }
  EXPECT_EQ(num_checked, 6 * kNumRays);
}

TEST(ModelIdentities, ThinPrismWithoutPrismIsRational) {
  int num_checked = 0;
  for (const auto& p : ModelFixture<Rational>::paramSets()) {
    const double prism[12] = {p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11], 0, 0, 0, 0};
    num_checked += compareLenses<Rational, ThinPrism>(p.data() + 4, prism, 1.0);
  }
  EXPECT_EQ(num_checked, 7 * kNumRays);
}

TEST(ModelIdentities, OmniWithoutDistortionIsUcm) {
  int num_checked = 0;
  for (const double alpha : {0.0, 0.2, 0.5, 0.6, 0.9}) {
    const double xi = alpha / (1 - alpha);
    const double omni[5] = {xi, 0, 0, 0, 0};
    // Z + xi d = (1 + xi) ((1 - alpha) Z + alpha d)
    num_checked += compareLenses<Ucm, Omni>(&alpha, omni, 1 + xi);
    EXPECT_NEAR(Ucm::maxAngle(&alpha), Omni::maxAngle(omni), 2e-3) << "omni keeps away from the pole";
  }
  EXPECT_EQ(num_checked, 5 * kNumRays);
}

TEST(ModelIdentities, EucmWithBetaOneIsUcm) {
  int num_checked = 0;
  for (const double alpha : {0.0, 0.2, 0.5, 0.6, 0.9, 1.0}) {
    const double eucm[2] = {alpha, 1.0};
    num_checked += compareLenses<Ucm, Eucm>(&alpha, eucm, 1.0);
    EXPECT_EQ(Ucm::maxAngle(&alpha), Eucm::maxAngle(eucm));
  }
  EXPECT_EQ(num_checked, 6 * kNumRays);
}

TEST(ModelIdentities, DoubleSphereWithXiZeroIsUcm) {
  int num_checked = 0;
  for (const double alpha : {0.0, 0.2, 0.5, 0.6, 0.9, 1.0}) {
    const double double_sphere[2] = {0.0, alpha};
    num_checked += compareLenses<Ucm, DoubleSphere>(&alpha, double_sphere, 1.0);
    EXPECT_NEAR(Ucm::maxAngle(&alpha), DoubleSphere::maxAngle(double_sphere), 1e-12);
  }
  EXPECT_EQ(num_checked, 6 * kNumRays);
}

TEST(ModelIdentities, WithoutAParameterThePerspectiveRemains) {
  const double zero = 0;
  const double eucm[2] = {0, 1.7};
  const double double_sphere[2] = {0, 0};
  const double omni[5] = {0, 0, 0, 0, 0};
  int num_checked = compareLenses<Pinhole, Fov>(nullptr, &zero, 1.0);
  num_checked += compareLenses<Pinhole, Ucm>(nullptr, &zero, 1.0);
  num_checked += compareLenses<Pinhole, Eucm>(nullptr, eucm, 1.0);
  num_checked += compareLenses<Pinhole, DoubleSphere>(nullptr, double_sphere, 1.0);
  num_checked += compareLenses<Pinhole, Omni>(nullptr, omni, 1.0);
  EXPECT_EQ(num_checked, 5 * kNumRays);
}

// Mei's formula step by step as the paper has it: onto the unit sphere, shift, plane, distortion.
TEST(ModelIdentities, OmniIsMeisFormula) {
  int num_checked = 0;
  for (const auto& p : ModelFixture<Omni>::paramSets()) {
    const Camera<Omni> camera(p);
    const double xi = p[4], k1 = p[5], k2 = p[6], p1 = p[7], p2 = p[8];
    Random random(5);
    for (int i = 0; i < kNumRays; ++i) {
      const Eigen::Vector3d point =
          random.uniform(0.1, 50.0) * rayAt(0.95 * camera.cone().max_angle_rad * random.uniform(),
                                            random.uniform(0, 2 * std::numbers::pi));
      const Eigen::Vector3d sphere = point.normalized();
      const Eigen::Vector2d u = sphere.head<2>() / (sphere.z() + xi);
      const double r2 = u.squaredNorm();
      const Eigen::Vector2d radial = u * (1 + k1 * r2 + k2 * r2 * r2);
      const Eigen::Vector2d tangential(2 * p1 * u.x() * u.y() + p2 * (r2 + 2 * u.x() * u.x()),
                                       p1 * (r2 + 2 * u.y() * u.y()) + 2 * p2 * u.x() * u.y());
      const Eigen::Vector2d m = radial + tangential;
      const Projection projection = camera.project(point);
      ASSERT_TRUE(projection.ok());
      const Eigen::Vector2d expected(p[0] * m.x() + p[2], p[1] * m.y() + p[3]);
      EXPECT_LE((projection.pixel - expected).norm(), 1e-9 * (1 + expected.norm() / 1e4));
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 6 * kNumRays);
}

// Values of the formulas worked out by hand at 90 degrees and beyond.
TEST(ModelIdentities, WideModelsSeeBesideAndBehindTheCamera) {
  const auto radius = [](const auto& camera, double degrees) {
    const Projection projection = camera.project(rayAt(degrees * std::numbers::pi / 180, 0.0));
    EXPECT_TRUE(projection.ok()) << degrees;
    return projection.pixel.x();
  };
  const double pi = std::numbers::pi;
  EXPECT_NEAR(radius(Camera<KannalaBrandt>({1, 1, 0, 0, 0, 0, 0, 0}), 135), 0.75 * pi, 1e-12);
  EXPECT_NEAR(radius(Camera<Fov>({1, 1, 0, 0, pi / 2}), 90), 1.0, 1e-12);
  EXPECT_NEAR(radius(Camera<Fov>({1, 1, 0, 0, pi / 2}), 135), 2 - std::atan(2) / (pi / 2), 1e-12);
  // Stereographic: 2 tan(theta / 2).
  EXPECT_NEAR(radius(Camera<Ucm>({1, 1, 0, 0, 0.5}), 120), 2 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(radius(Camera<Eucm>({1, 1, 0, 0, 0.5, 1}), 120), 2 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(radius(Camera<DoubleSphere>({1, 1, 0, 0, 0, 0.5}), 120), 2 * std::sqrt(3), 1e-12);
  EXPECT_NEAR(radius(Camera<Omni>({2, 2, 0, 0, 1, 0, 0, 0, 0}), 120), 2 * std::sqrt(3), 1e-12);
  // xi = 1 halves the angle before the second sphere's perspective does: tan(theta / 2).
  EXPECT_NEAR(radius(Camera<DoubleSphere>({1, 1, 0, 0, 1, 0}), 120), std::sqrt(3), 1e-12);
}

}  // namespace
}  // namespace alidade
