// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <type_traits>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/camera_variant.h"
#include "alidade/camera/image_domain.h"
#include "alidade/core/random.h"
#include "support/brute_force_domain.h"
#include "support/model_fixture.h"
#include "support/project_formula.h"

namespace alidade {
namespace {

constexpr double kAngleTolerance = 1e-4;  // rad; the certificate keeps 1e-5 away from the fold on purpose

template <class M>
class CertificateOf : public testing::Test {};
TYPED_TEST_SUITE(CertificateOf, AllModelTypes, ModelName);

TYPED_TEST(CertificateOf, ModelAgreesWithBruteForce) {
  using M = TypeParam;
  auto sets = ModelFixture<M>::paramSets();
  Random random(8);
  for (int i = 0; i < 20; ++i) sets.push_back(ModelFixture<M>::randomParams(random));
  int num_limited = 0;
  double worst = 0;
  for (const auto& params : sets) {
    std::string text;
    for (const double value : params) text += " " + std::to_string(value);
    SCOPED_TRACE("set" + text);
    const Camera<M> camera(params);
    const double fold = BruteForceDomain<M>(params.data() + 4).maxAngle();
    if (fold < M::kMaxAngle) ++num_limited;
    worst = std::max(worst, std::abs(camera.cone().max_angle_rad - fold));
    EXPECT_NEAR(camera.cone().max_angle_rad, fold, kAngleTolerance);
    EXPECT_LE(camera.cone().max_angle_rad, fold);
  }
  std::printf("%-14s %d of %zu end at a fold or pole, worst disagreement %.1e rad\n",
              std::string(M::kId).c_str(), num_limited, sets.size(), worst);
}

// Where a closed form is given, it is where the formula ends: nothing is lost before it, nothing seen beyond.
TYPED_TEST(CertificateOf, ClosedFormIsWhereTheFormulaEnds) {
  using M = TypeParam;
  int num_closed = 0;
  auto sets = ModelFixture<M>::paramSets();
  Random random(9);
  for (int i = 0; i < 200; ++i) sets.push_back(ModelFixture<M>::randomParams(random));
  for (const auto& params : sets) {
    const double* lens = params.data() + 4;
    const double end = M::maxAngle(lens);
    EXPECT_LE(end, M::kMaxAngle);
    if (end == M::kMaxAngle) continue;
    ++num_closed;
    double m[2];
    // The closed form of a tilted sensor is that of the lens before it.
    using Closed = std::conditional_t<std::is_same_v<M, Tilted>, ThinPrism, M>;
    EXPECT_TRUE(Closed::lens(lens, rayAt(end - 1e-7, 1.0).eval().data(), m));
    // Some stop where digits are lost, or where the ray of a pixel turns back, not where the formula ends.
    constexpr std::array<std::string_view, 6> kEndEarlier = {"fov",  "omni",           "division",
                                                             "ocam", "ftheta_inverse", "inverse_brown"};
    if (std::ranges::find(kEndEarlier, M::kId) != kEndEarlier.end()) continue;
    EXPECT_FALSE(M::lens(lens, rayAt(end + 1e-7, 1.0).eval().data(), m));
  }
  constexpr std::array<std::string_view, 8> kWithout = {
      "pinhole",    "radtan", "brown", "kannala_brandt", "kannala_brandt_skew", "thin_prism_fisheye",
      "fisheye624", "ftheta"};
  EXPECT_EQ(num_closed > 0, std::ranges::find(kWithout, M::kId) == kWithout.end());
}

// Cameras remember the domains of the last lenses; these are more lenses than they remember, in any order,
// each placed on the sensor in another way.
TYPED_TEST(CertificateOf, RememberedLensHasItsOwnDomain) {
  using M = TypeParam;
  constexpr int kNumDraws = 60;
  Random random(17);
  std::vector<typename Camera<M>::Params> lenses = ModelFixture<M>::paramSets();
  while (lenses.size() < 7) lenses.push_back(ModelFixture<M>::randomParams(random));
  std::vector<double> certified;
  for (const auto& params : lenses) {
    const double* lens = params.data() + kNumAffine;
    certified.push_back(
        certifyCone(lensFunction<M>(lens), {.model_rad = M::kMaxAngle,
                                            .closed_form_rad = M::maxAngle(lens),
                                            .is_axially_symmetric = M::isAxiallySymmetric(lens),
                                            .is_one_to_one_without_fold = M::kIsOneToOneWithoutFold,
                                            .margin_rad = M::kEndMargin})
            .max_angle_rad);
  }
  for (int draw = 0; draw < kNumDraws; ++draw) {
    const std::size_t i = random.index(lenses.size());
    typename Camera<M>::Params params = lenses[i];
    params[2] += draw;
    const Camera<M> camera(params);
    ASSERT_EQ(camera.cone().max_angle_rad, certified[i]) << i;
    // Its inverse is the lens' own, too.
    const Eigen::Vector3d ray(0.1, -0.05, 1);
    const Projection seen = camera.project(ray);
    ASSERT_TRUE(seen.ok());
    const auto back = camera.unproject(seen.pixel);
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - ray.normalized()).norm(), 1e-9);
  }
}

TEST(Certificate, GivesNothingBeyondAPoleInsideTheImage) {
  // 1 / (1 - r^2) has its pole at 45 degrees; beyond it the formula goes on, mirrored.
  const Camera<Rational> camera({1000, 1000, 960, 600, -0.9, 0, 0, 0, 0, -1.0, 0, 0});
  EXPECT_TRUE(camera.cone().is_limited_by_fold);
  EXPECT_NEAR(camera.cone().max_angle_rad, std::numbers::pi / 4 - kFoldMargin, 1e-9);
  int num_beyond = 0;
  for (double angle = std::numbers::pi / 4 + 1e-6; angle < 1.57; angle += 1e-4) {
    EXPECT_EQ(camera.project(rayAt(angle, 0.3)).status, ProjectStatus::kOutsideDomain);
    ++num_beyond;
  }
  EXPECT_GT(num_beyond, 7000);
}

TEST(Certificate, FindsAPoleTooNarrowForSampling) {
  // (1 - (2.5 + e) r^2) / (1 - 2.5 r^2) is 1 but for a pole at r^2 = 0.4. It goes to minus infinity there,
  // and has folded a root of e before.
  for (const double e : {1e-4, 1e-7, 1e-10}) {
    const Camera<Rational> camera({1000, 1000, 960, 600, -2.5 - e, 0, 0, 0, 0, -2.5, 0, 0});
    const double pole = std::atan(std::sqrt(0.4));
    EXPECT_TRUE(camera.cone().is_limited_by_fold);
    EXPECT_LE(camera.cone().max_angle_rad, pole - kFoldMargin);
    EXPECT_GE(camera.cone().max_angle_rad, pole - kFoldMargin - std::sqrt(e));
  }
}

// Beyond it, the formula gives mirrored points.
TEST(Certificate, EndsWhereATiltedSensorPassesTheCentre) {
  int num_beyond = 0;
  for (const double tilt : {-1.2, -0.9, 0.9, 1.2}) {
    Camera<Tilted>::Params params{1000, 1000, 960, 600};
    params[4 + 12] = tilt;
    const Camera<Tilted> camera(params);
    const double pole = std::numbers::pi / 2 - std::abs(tilt);
    EXPECT_TRUE(camera.cone().is_limited_by_fold);
    EXPECT_LE(camera.cone().max_angle_rad, pole);
    EXPECT_GE(camera.cone().max_angle_rad, pole - kAngleTolerance);
    const double azimuth = std::copysign(std::numbers::pi / 2, tilt);
    for (double angle = pole + 1e-6; angle < 1.57; angle += 1e-3) {
      double m[2];
      EXPECT_FALSE(Tilted::lens(params.data() + 4, rayAt(angle, azimuth).eval().data(), m));
      EXPECT_EQ(camera.project(rayAt(angle, azimuth)).status, ProjectStatus::kOutsideDomain);
      ++num_beyond;
    }
    double m[2];
    EXPECT_TRUE(Tilted::lens(params.data() + 4, rayAt(pole - 1e-6, azimuth).eval().data(), m));
  }
  EXPECT_GT(num_beyond, 4000);
}

// Where a lens folds again farther out, the search for the image of an angle may take a later root. The
// domain ends before.
TEST(Certificate, EndsWhereAStatedInverseLosesItsFirstRoot) {
  Random random(13);
  int num_twice = 0;
  int num_short = 0;
  int num_checked = 0;
  for (int set = 0; set < 400; ++set) {
    Camera<FThetaInverse>::Params params{900, 900, 960, 600, 20.6949, -62.3492, 19.6303, 84.4725, -64.9319};
    if (set > 0) {
      for (std::size_t i = 4; i < params.size(); ++i) params[i] = random.uniform(-30, 30);
    }
    const Camera<FThetaInverse> camera(params);
    const double end = camera.cone().max_angle_rad;
    const double fold = BruteForceDomain<FThetaInverse>(params.data() + 4).maxAngle();
    ASSERT_LE(end, fold + 2e-7) << set;  // to which the sampling is right
    num_short += end < fold - kAngleTolerance ? 1 : 0;
    num_twice += fold < FThetaInverse::kMaxAngle ? 1 : 0;
    for (int i = 1; i <= 100; ++i) {
      const double angle = 0.00999 * i * std::min(fold, 1.1 * end);
      const Eigen::Vector3d ray = rayAt(angle, 0.7);
      const Projection seen = camera.project(ray);
      ASSERT_EQ(seen.ok(), angle <= end);
      if (!seen.ok()) continue;
      const auto m = TextbookLens<FThetaInverse>::project(params.data() + 4, ray.cast<Real>());
      ASSERT_TRUE(m);
      const Eigen::Vector2d expected = 900 * m->cast<double>() + Eigen::Vector2d(960, 600);
      ASSERT_LE((seen.pixel - expected).norm(), 1e-7) << set;
      const auto back = camera.unproject(seen.pixel);
      ASSERT_TRUE(back);
      ASSERT_LE(angleBetween(*back, ray), 1e-9);
      ++num_checked;
    }
  }
  std::printf("%d of 400 sets fold, %d of them end early; %d rays\n", num_twice, num_short, num_checked);
  EXPECT_GE(num_short, 1);
  EXPECT_GT(num_checked, 20'000);
}

// A public calibration (pylon-ros-camera, issue 143), whose numerator and denominator nearly cancel within
// the image: it folds nowhere there.
TEST(Certificate, LosesNoPixelWhereAPoleNearlyCancels) {
  const std::vector<double> params = {1874.63171,  1879.55762, 647.5,       485.5,
                                      -13.238113,  -98.012135, 0.001444,    0.002849,
                                      1357.782415, -13.050801, -102.363353, 1383.055291};
  const AnyCamera camera = AnyCamera::make("rational", params);
  constexpr ImageSize kSize{.width = 1296, .height = 972};
  EXPECT_TRUE(certifyDomain(camera, kSize).full_image);
  EXPECT_FALSE(foldsInsideImage(camera, kSize));
  int num_checked = 0;
  for (int y = 0; y < kSize.height; y += 3) {
    for (int x = 0; x < kSize.width; x += 3) {
      const auto ray = camera.unproject({x, y});
      ASSERT_TRUE(ray) << x << ", " << y;
      ASSERT_LE((camera.project(*ray).pixel - Eigen::Vector2d(x, y)).norm(), 1e-8);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 432 * 324);
}

// exp(3 x) in the complex plane: never folds, and takes y and y + 2 pi / 3 to the same point.
struct Spiral {
  static bool hasValue(const double*, const double*) { return true; }
  static void formula(const double*, const double* ray, double* m, double* J, double*) {
    const double x = ray[0] / ray[2];
    const double y = ray[1] / ray[2];
    const double e = std::exp(3 * x);
    m[0] = e * std::cos(3 * y);
    m[1] = e * std::sin(3 * y);
    detail::warpJacobian({.mx = m[0],
                          .my = m[1],
                          .dmx_dx = 3 * m[0],
                          .dmx_dy = -3 * m[1],
                          .dmy_dx = 3 * m[1],
                          .dmy_dy = 3 * m[0]},
                         x, y, 1 / ray[2], J);
  }
};

// det > 0 everywhere does not keep a map that is no gradient from wrapping round: here the rim's image, and
// it alone, tells that two rays meet in one pixel.
TEST(Certificate, SeesARimThatCrossesItself) {
  const ConeLimits limits{.model_rad = 1.4,
                          .closed_form_rad = 1.4,
                          .is_axially_symmetric = false,
                          .is_one_to_one_without_fold = false};
  const CertifiedCone cone = certifyCone(lensFunction<Spiral>(nullptr), limits);
  // The first rays to meet are those at y = +-pi / 3, x = 0.
  EXPECT_TRUE(cone.is_limited_by_fold);
  EXPECT_NEAR(cone.max_angle_rad, std::atan(std::numbers::pi / 3), 1e-3);
}

TEST(Certificate, FindsTheFoldOfASingleCoefficientExactly) {
  // r (1 + k r^2) turns at r^2 = -1 / (3 k).
  int num_checked = 0;
  for (const double k1 : {-0.01, -0.1, -0.3, -1.0, -10.0}) {
    const Camera<Radtan> camera({1000, 1000, 500, 500, k1, 0, 0, 0, 0});
    EXPECT_NEAR(camera.cone().max_angle_rad, std::atan(std::sqrt(-1 / (3 * k1))) - kFoldMargin, 1e-9);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
}

TEST(Certificate, SeesFoldsThatTurnBackWithinATinyAngle) {
  // 1 - s^n / ((2 n + 1) t^n) of s = r^2 folds at s = t. Soon after it is negative and mirrors the image,
  // which is no fold any more: near 90 degrees all of this happens within a thousandth of a radian.
  int num_cameras = 0;
  for (double rho = 3; rho < 900; rho *= 1.03) {
    for (int n = 1; n <= 3; ++n) {
      const double k = -1 / ((2 * n + 1) * std::pow(rho, 2 * n));
      for (const double p1 : {0.0, 1e-9}) {  // without and with other azimuths
        const Camera<Radtan> camera(
            {1000, 1000, 960, 600, n == 1 ? k : 0, n == 2 ? k : 0, p1 / rho, 0, n == 3 ? k : 0});
        EXPECT_LE(camera.cone().max_angle_rad, std::atan(rho)) << "n " << n << " rho " << rho << " p1 " << p1;
        EXPECT_GE(camera.cone().max_angle_rad, std::atan(rho) - 1e-3 / rho - 2 * kFoldMargin);
        ++num_cameras;
      }
    }
  }
  // (1 - (2.5 + e) s) / (1 - 2.5 s) is 1 but for a pole at s = 0.4, before which it falls to minus infinity.
  for (double e = 1e-3; e > 1e-7; e /= 1.1) {
    double low = 0;
    double high = std::sqrt(0.4) * (1 - 1e-9);
    for (int i = 0; i < 100; ++i) {
      const double r = 0.5 * (low + high);
      const double below = 1 - 2.5 * r * r;
      // The slope of r - e r^3 / below.
      (1 - e * r * r * (3 * below + 5 * r * r) / (below * below) > 0 ? low : high) = r;
    }
    for (const double p1 : {0.0, 1e-12}) {
      const Camera<Rational> camera({1000, 1000, 960, 600, -2.5 - e, 0, p1, 0, 0, -2.5, 0, 0});
      EXPECT_LE(camera.cone().max_angle_rad, std::atan(low)) << "e " << e << " p1 " << p1;
      EXPECT_GE(camera.cone().max_angle_rad, std::atan(low) - 2 * kFoldMargin) << "e " << e << " p1 " << p1;
      ++num_cameras;
    }
  }
  EXPECT_GT(num_cameras, 1000);
}

TEST(Certificate, SeesANarrowDipBetweenSamples) {
  // g(r) = r (1 + k1 r^2 + k2 r^4) has g' = 1 + 3 k1 s + 5 k2 s^2 with s = r^2. Choosing the two roots in s
  // to lie 1e-4 apart gives a fold that reopens at once.
  const double s0 = 0.36;
  const double s1 = s0 + 1e-4;
  const double k2 = 1 / (5 * s0 * s1);
  const double k1 = -(s0 + s1) / (3 * s0 * s1);
  const Camera<Radtan> camera({1000, 1000, 500, 500, k1, k2, 0, 0, 0});
  EXPECT_TRUE(camera.cone().is_limited_by_fold);
  EXPECT_NEAR(camera.cone().max_angle_rad, std::atan(std::sqrt(s0)), kAngleTolerance);
}

// A lens that folds in a wedge that is narrower than the steps between azimuths, and opens again; elsewhere
// it folds only at 1.1 rad.
TEST(Certificate, SeesANarrowWedgeBetweenAzimuths) {
  const Camera<Radtan> camera({1000, 1000, 500, 500, -1.4974037474203887, 1.1237574303460274,
                               0.0010062284427863038, 0.0017284398516951205, -0.16735247802128575});
  EXPECT_TRUE(camera.cone().is_limited_by_fold);
  EXPECT_NEAR(camera.cone().max_angle_rad, 0.6003, kAngleTolerance);
}

// A fold that all but happens costs the inverse its digits as a fold does. With one root s0 in s = r^2 and a
// slope of `slope` left over, g' = (1 - slope) (1 - s / s0)^2 + slope.
TEST(Certificate, EndsWhereTheInverseWouldLoseItsDigits) {
  const double s0 = 0.36;
  const double dip = std::atan(std::sqrt(s0));
  int num_checked = 0;
  double worst = 0;
  for (const double slope : {1e-3, 1e-4, 1e-5, 1e-6, 5e-7, 3e-7, 2e-7, 1e-7, 1e-8, 1e-10, 0.0}) {
    const double k2 = (1 - slope) / (5 * s0 * s0);
    const double k1 = -2.0 / 3 * (1 - slope) / s0;
    const Camera<Radtan> camera({1000, 1000, 960, 600, k1, k2, 0, 0, 0});
    if (slope >= 1e-6) {
      EXPECT_FALSE(camera.cone().is_limited_by_fold);
    }
    if (slope <= 1e-7) {
      EXPECT_TRUE(camera.cone().is_limited_by_fold);
      EXPECT_NEAR(camera.cone().max_angle_rad, dip, 4e-4);
      EXPECT_LT(camera.cone().max_angle_rad, dip);
    }
    for (double off = 1e-9; off < 1e-2; off *= 1.1) {
      for (const double angle : {dip - off, dip + off, camera.cone().max_angle_rad - off}) {
        const Eigen::Vector3d ray = rayAt(angle, 0.4);
        const Projection projection = camera.project(ray);
        if (!projection.ok()) continue;
        const auto back = camera.unproject(projection.pixel);
        ASSERT_TRUE(back) << "slope " << slope << " at " << angle;
        const double error = angleBetween(*back, ray);
        worst = std::max(worst, error);
        ASSERT_LE(error, 1e-9) << "slope " << slope << " at " << angle - dip << " from the dip";
        ++num_checked;
      }
    }
  }
  std::printf("%d rays beside the dip, worst %.1e rad\n", num_checked, worst);
  EXPECT_GE(num_checked, 2000);
}

TEST(Certificate, RefusesTheRaysThatOtherLibrariesFoldIntoTheImage) {
  // With these parameters the bare polynomial puts rays at 65 to 69 degrees back inside the 1920x1200 image.
  const Camera<Radtan> camera({1003, 1003, 959.5, 599.5, -0.28, 0.08, 5e-4, -4e-4, -0.01});
  int num_folded_in = 0;
  for (double deg = 60; deg < 89; deg += 0.05) {
    for (int a = 0; a < 36; ++a) {
      const Eigen::Vector3d ray = rayAt(deg * std::numbers::pi / 180, a * std::numbers::pi / 18);
      double px[2];
      ASSERT_TRUE(projectFormula<Radtan>(camera.params().data(), ray.data(), px));
      const bool is_in_image = px[0] > -0.5 && px[0] < 1919.5 && px[1] > -0.5 && px[1] < 1199.5;
      const Projection projection = camera.project(ray);
      if (deg * std::numbers::pi / 180 > camera.cone().max_angle_rad) {
        EXPECT_EQ(projection.status, ProjectStatus::kOutsideDomain);
        num_folded_in += is_in_image ? 1 : 0;
      }
    }
  }
  EXPECT_GT(num_folded_in, 100) << "the trap that this test is about";
}

TEST(CertifyDomain, TellsWhetherEveryPixelHasARay) {
  const ImageSize size{.width = 640, .height = 480};
  const std::vector<double> good = {535, 534, 320, 240, -0.28, 0.08, 0, 0, 0};
  const DomainCertificate whole = certifyDomain(AnyCamera::make("radtan", good), size);
  EXPECT_TRUE(whole.full_image);
  EXPECT_FALSE(whole.pixel_without_ray);
  EXPECT_GT(whole.min_relative_det, 0.2);

  // A fold at 45 degrees maps to a radius of 2/3 f = 357 px, short of the corners at 400 px.
  const std::vector<double> folded = {535, 535, 319.5, 239.5, -1.0 / 3, 0, 0, 0, 0};
  const DomainCertificate part = certifyDomain(AnyCamera::make("radtan", folded), size);
  EXPECT_FALSE(part.full_image);
  ASSERT_TRUE(part.pixel_without_ray);
  EXPECT_GT((*part.pixel_without_ray - Eigen::Vector2d(319.5, 239.5)).norm(), 2.0 / 3 * 535 - 1e-2);
  EXPECT_EQ(part.min_relative_det, 0.0);

  // The quick answer to one question of these is the same.
  int num_folded = 0;
  for (const std::vector<double>& params : {good, folded}) {
    const AnyCamera camera = AnyCamera::make("radtan", params);
    EXPECT_EQ(foldsInsideImage(camera, size), foldsInsideImage(certifyDomain(camera, size)));
    num_folded += foldsInsideImage(camera, size) ? 1 : 0;
  }
  EXPECT_EQ(num_folded, 1);
}

}  // namespace
}  // namespace alidade
