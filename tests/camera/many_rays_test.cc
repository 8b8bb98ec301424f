// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/batch.h"
#include "alidade/core/random.h"
#include "support/brute_force_domain.h"
#include "support/model_fixture.h"

// What the project promises of every model, on many rays and as many pixels of each of its sets of
// parameters, against formulas and a domain that the models have no part in. ALIDADE_PROOF_RAYS says how
// many; .ci/run takes a million, which is two minutes of one processor.

namespace alidade {
namespace {

constexpr double kRayTolerance = 1e-9;      // rad
constexpr double kPixelTolerance = 1e-7;    // px
constexpr double kFormulaTolerance = 1e-9;  // px, of double against more digits
constexpr double kAngleTolerance = 1e-4;    // rad that the certificate may leave unused
constexpr double kRimTolerance = 0.25;      // px, what that and the rim's polygon come to in the image
constexpr int kNumRimPoints = 1 << 14;

// Rays, and pixels, of each set.
int numRays() {
  constexpr int kDefault = 100'000;
  const char* text = std::getenv("ALIDADE_PROOF_RAYS");
  if (text == nullptr) return kDefault;
  const std::string_view given(text);
  int value = 0;
  const auto result = std::from_chars(given.data(), given.data() + given.size(), value);
  const bool is_number = result.ec == std::errc() && result.ptr == given.data() + given.size();
  if (is_number && value >= 10'000) return value;
  throw std::runtime_error("ALIDADE_PROOF_RAYS is '" + std::string(given) +
                           "'; expected a whole number of at least 10000, such as 1000000");
}

// What rounding does far outside of the image: towards a pole, a radius grows with the square of itself.
double tolerance(double px, const Eigen::Vector2d& pixel) {
  return px + 1e-15 * pixel.squaredNorm();
}

template <class M>
Eigen::Vector2d textbookPixel(const Camera<M>& camera, const Eigen::Vector3d& ray) {
  const auto m = TextbookLens<M>::project(camera.params().data() + 4, ray.cast<Real>());
  EXPECT_TRUE(m);
  const auto& p = camera.params();
  return m ? Eigen::Vector2d(static_cast<double>(p[0] * m->x() + p[2]),
                             static_cast<double>(p[1] * m->y() + p[3]))
           : Eigen::Vector2d::Constant(std::nan(""));
}

// The image of the brute-force domain's rim, as a polygon that goes once around the principal point.
template <class M>
class RimImage {
 public:
  RimImage(const Camera<M>& camera, double max_angle) : middle_(camera.params()[2], camera.params()[3]) {
    for (int i = 0; i < kNumRimPoints; ++i) {
      const double azimuth = 2 * std::numbers::pi * (i + 0.5) / kNumRimPoints;
      const Eigen::Vector2d pixel = textbookPixel(camera, rayAt(max_angle - 0.1 * M::kEndMargin, azimuth));
      points_.push_back(pixel);
    }
    const auto first = std::min_element(points_.begin(), points_.end(),
                                        [this](const auto& a, const auto& b) { return polar(a) < polar(b); });
    std::rotate(points_.begin(), first, points_.end());
    for (const auto& point : points_) polar_.push_back(polar(point));
    is_star_shaped_ = std::is_sorted(polar_.begin(), polar_.end());
  }

  [[nodiscard]] const std::vector<Eigen::Vector2d>& points() const { return points_; }
  [[nodiscard]] bool isStarShaped() const { return is_star_shaped_; }
  [[nodiscard]] const Eigen::Vector2d& middle() const { return middle_; }

  // How far a pixel lies outside of the edge that it sees along its own polar angle; negative inside.
  [[nodiscard]] double outside(const Eigen::Vector2d& pixel) const {
    const auto next = static_cast<std::size_t>(std::upper_bound(polar_.begin(), polar_.end(), polar(pixel)) -
                                               polar_.begin());
    const Eigen::Vector2d& b = points_[next % points_.size()];
    const Eigen::Vector2d& a = points_[(next + points_.size() - 1) % points_.size()];
    const Eigen::Vector2d edge = (b - a).normalized();
    return edge.y() * (pixel.x() - a.x()) - edge.x() * (pixel.y() - a.y());
  }

 private:
  [[nodiscard]] double polar(const Eigen::Vector2d& pixel) const {
    return std::atan2(pixel.y() - middle_.y(), pixel.x() - middle_.x());
  }

  Eigen::Vector2d middle_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<double> polar_;
  bool is_star_shaped_ = false;
};

struct RayCounts {
  long num_ok = 0;
  long num_refused = 0;
  double worst_rad = 0;
  double worst_formula_px = 0;
};

template <class M>
void proveRays(const Camera<M>& camera, const BruteForceDomain<M>& domain, RayCounts& counts) {
  Random random(11);
  const int num_rays = numRays();
  const double max_angle = domain.maxAngle();
  for (int i = 0; i < num_rays; ++i) {
    // Half of them evenly over the sphere, half over the angles up to a little beyond the domain.
    const double angle = i % 2 == 0 ? std::acos(random.uniform(-1, 1))
                                    : std::min(1.02 * max_angle, std::numbers::pi) * random.uniform();
    const double azimuth = random.uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector3d ray = rayAt(angle, azimuth);
    const Projection projection = camera.project(random.uniform(0.1, 50.0) * ray);
    if (!projection.ok()) {
      ASSERT_GE(angle, max_angle - kAngleTolerance) << "a ray of the domain has no pixel";
      ++counts.num_refused;
      continue;
    }
    ASSERT_LE(angle, max_angle) << "a ray outside of the domain has a pixel";
    ASSERT_TRUE(domain.keepsItsSide(angle, azimuth))
        << "folded at angle " << angle << ", azimuth " << azimuth;
    const double formula = (projection.pixel - textbookPixel(camera, ray)).norm();
    ASSERT_LE(formula, tolerance(kFormulaTolerance, projection.pixel)) << projection.pixel.transpose();
    const auto back = camera.unproject(projection.pixel);
    ASSERT_TRUE(back) << "angle " << angle << " of " << max_angle;
    const double error = angleBetween(*back, ray);
    ASSERT_LE(error, kRayTolerance) << "angle " << angle << " of " << max_angle;
    counts.worst_rad = std::max(counts.worst_rad, error);
    if (projection.pixel.norm() < 1e4) counts.worst_formula_px = std::max(counts.worst_formula_px, formula);
    ++counts.num_ok;
  }
}

struct PixelCounts {
  long num_with_ray = 0;
  long num_without = 0;
  double worst_px = 0;
};

// A ray that a pixel has leads back to it and is of the domain; one exists exactly inside the rim's image.
template <class M>
void provePixel(const Camera<M>& camera, double max_angle, const RimImage<M>& rim, const RimImage<M>& inner,
                const Eigen::Vector2d& pixel, PixelCounts& counts) {
  const auto ray = camera.unproject(pixel);
  const double outside = rim.outside(pixel);
  if (!ray) {
    ASSERT_GE(inner.outside(pixel), -kRimTolerance) << "no ray for " << pixel.transpose();
    ++counts.num_without;
    return;
  }
  ASSERT_LE(outside, kRimTolerance) << "a ray for " << pixel.transpose() << ", which has none";
  ASSERT_LE(std::atan2(std::hypot(ray->x(), ray->y()), ray->z()), max_angle + 1e-12) << pixel.transpose();
  const Projection back = camera.project(*ray);
  ASSERT_TRUE(back.ok()) << pixel.transpose();
  const double error = std::max((back.pixel - pixel).norm(), (textbookPixel(camera, *ray) - pixel).norm());
  ASSERT_LE(error, tolerance(kPixelTolerance, pixel)) << pixel.transpose();
  counts.worst_px = std::max(counts.worst_px, error);
  ++counts.num_with_ray;
}

template <class M>
class ManyRays : public testing::Test {
 protected:
  // Calls prove(camera, domain) for each set of the model.
  template <class F>
  static void forEachSet(const F& prove) {
    int set = 0;
    for (const auto& params : ModelFixture<M>::paramSets()) {
      SCOPED_TRACE("set " + std::to_string(set++));
      const Camera<M> camera(params);
      const BruteForceDomain<M> domain(camera.params().data() + 4);
      prove(camera, domain);
      if (testing::Test::HasFailure()) return;
    }
  }
  static long numSets() { return static_cast<long>(ModelFixture<M>::paramSets().size()); }
  static std::string id() { return std::string(M::kId); }
};
TYPED_TEST_SUITE(ManyRays, AllModelTypes, ModelName);

TYPED_TEST(ManyRays, ComeBackInsideTheDomainAndHaveNoPixelOutside) {
  RayCounts counts;
  this->forEachSet([&counts](const auto& camera, const auto& domain) { proveRays(camera, domain, counts); });
  std::printf("%-14s %8ld rays with a pixel, worst %.1e rad, %.1e px from the formula; %8ld without\n",
              this->id().c_str(), counts.num_ok, counts.worst_rad, counts.worst_formula_px,
              counts.num_refused);
  EXPECT_EQ(counts.num_ok + counts.num_refused, this->numSets() * numRays());
  EXPECT_GE(counts.num_ok, this->numSets() * numRays() * 45 / 100);
  EXPECT_GE(counts.num_refused, this->numSets() * 10);
}

TYPED_TEST(ManyRays, HavePixelsThatComeBackOrTrulyHaveNone) {
  PixelCounts counts;
  long num_beyond_rim = 0;
  const int num_pixels = numRays();
  this->forEachSet([&](const auto& camera, const auto& domain) {
    const RimImage rim(camera, domain.maxAngle());
    ASSERT_TRUE(rim.isStarShaped());
    // At the fold of a stated inverse, the image moves with the root of the angle that the domain ends before
    // it.
    using M = TypeParam;
    const RimImage inner(camera, domain.maxAngle() - (kIsStatedInverse<M> ? M::kEndMargin : 0));
    Random random(12);
    for (int i = 0; i < num_pixels && !testing::Test::HasFatalFailure(); ++i) {
      const Eigen::Vector2d pixel(random.uniform(-1.0, 2.0) * kTestImage.width,
                                  random.uniform(-1.0, 2.0) * kTestImage.height);
      provePixel(camera, domain.maxAngle(), rim, inner, pixel, counts);
    }
    // Beside the image of the rim, where it is near enough to tell.
    for (std::size_t i = 0; i < rim.points().size(); i += 16) {
      const Eigen::Vector2d& point = rim.points()[i];
      if ((point - rim.middle()).norm() > 1e5) continue;
      for (const double px : {1.0, 3.0, 30.0, 1e3, 1e6}) {
        const Eigen::Vector2d pixel = point + px * (point - rim.middle()).normalized();
        if (rim.outside(pixel) <= kRimTolerance) continue;
        ASSERT_FALSE(camera.unproject(pixel)) << pixel.transpose() << " is beyond the rim";
        ++num_beyond_rim;
      }
    }
  });
  std::printf("%-14s %8ld pixels with a ray, worst %.1e px; %8ld without, and %7ld beside the rim\n",
              this->id().c_str(), counts.num_with_ray, counts.worst_px, counts.num_without, num_beyond_rim);
  EXPECT_EQ(counts.num_with_ray + counts.num_without, this->numSets() * num_pixels);
  EXPECT_GE(counts.num_with_ray, this->numSets() * num_pixels / 10);
}

struct RayAndStatus {
  Eigen::Vector3d ray;
  ProjectStatus status;
};

// Rays of all pixels by the batch, after comparing each with that of the scalar function.
std::vector<RayAndStatus> raysBothWays(const AnyCamera& camera, const std::vector<Eigen::Vector2d>& pixels,
                                       double tolerance) {
  std::vector<double> rays(3 * pixels.size());
  std::vector<ProjectStatus> status(pixels.size());
  unprojectRows(camera, {pixels[0].data(), 2 * pixels.size()}, rays, status);
  std::vector<RayAndStatus> all;
  for (std::size_t i = 0; i < pixels.size() && !testing::Test::HasFailure(); ++i) {
    all.push_back({Eigen::Vector3d(rays.data() + 3 * i), status[i]});
    Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J;
    const auto one = camera.unproject(pixels[i], J.data());
    EXPECT_EQ(one.has_value(), status[i] == ProjectStatus::kOk) << pixels[i].transpose();
    if (!one) continue;
    // How far rounding of the pixel moves the ray: much where the lens nearly folds.
    const double rounding = 1e-13 * (1 + pixels[i].norm()) * J.norm();
    EXPECT_LE((all.back().ray - *one).norm(), tolerance + rounding) << pixels[i].transpose();
  }
  return all;
}

TYPED_TEST(ManyRays, AreThoseOfTheBatch) {
  long num_with_ray = 0;
  long num_compared = 0;
  for (const auto& params : ModelFixture<TypeParam>::paramSets()) {
    const AnyCamera camera = AnyCamera::make(TypeParam::kId, params);
    Random random(13);
    std::vector<Eigen::Vector2d> pixels(static_cast<std::size_t>(numRays()));
    for (Eigen::Vector2d& pixel : pixels) {
      pixel = {random.uniform(-1.0, 2.0) * kTestImage.width, random.uniform(-1.0, 2.0) * kTestImage.height};
    }
    for (const RayAndStatus& of_pixel : raysBothWays(camera, pixels, 1e-12)) {
      num_with_ray += of_pixel.status == ProjectStatus::kOk ? 1 : 0;
      ++num_compared;
    }
  }
  EXPECT_EQ(num_compared, this->numSets() * numRays());
  EXPECT_GE(num_with_ray, num_compared / 10);
}

// A lens whose denominator comes near to 0 inside the image, where the numerator does too: a has a bump
// within a narrow ring, and rounding there is many times that of other lenses.
struct NearPole {
  Real radius2, width2, shift;  // a = (1 + s / q) ((s - radius2)^2 + width2) / the same with radius2 shifted

  static constexpr Real kFar = 0.1L;
  [[nodiscard]] std::array<double, 3> polynomial(Real middle) const {
    const Real constant = middle * middle + width2;
    const Real linear = -2 * middle / constant;
    const Real square = 1 / constant;
    return {static_cast<double>(linear + 1 / kFar), static_cast<double>(square + linear / kFar),
            static_cast<double>(square / kFar)};
  }
  [[nodiscard]] std::vector<double> params(double p1, double p2) const {
    const auto up = polynomial(radius2 + shift);
    const auto down = polynomial(radius2);
    return {1000, 1003, 960, 600, up[0], up[1], p1, p2, up[2], down[0], down[1], down[2]};
  }
};

TEST(ManyRaysNearPoles, LoseNoPixel) {
  Random random(14);
  constexpr int kNumLenses = 20;
  long num_pixels = 0;
  double worst_px = 0;
  for (int lens = 0; lens < kNumLenses; ++lens) {
    const Real width = std::pow(10.0L, random.uniform(-3, -1.5));
    const NearPole pole{.radius2 = random.uniform(0.05, 0.5),
                        .width2 = width * width,
                        .shift = 0.3L * width * width * random.uniform(-1, 1)};
    const bool is_tangential = lens % 2 == 0;
    const auto params = pole.params(is_tangential ? 1e-3 : 0, is_tangential ? -2e-3 : 0);
    const AnyCamera camera = AnyCamera::make("rational", params);
    // By the formula in more digits: rising everywhere, so that each radius has its ray.
    const auto radius = [&params](Real r) {
      const Real s = r * r;
      return r * (1 + s * (params[4] + s * (params[5] + s * params[8]))) /
             (1 + s * (params[9] + s * (params[10] + s * params[11])));
    };
    const Real step = static_cast<Real>(width) / 50;
    for (Real r = step; r < 1.4L; r += step) ASSERT_GT(radius(r), radius(r - step));
    std::vector<Eigen::Vector2d> pixels(static_cast<std::size_t>(numRays() / kNumLenses));
    for (Eigen::Vector2d& pixel : pixels) {
      pixel = {random.uniform(0, kTestImage.width - 1.0), random.uniform(0, kTestImage.height - 1.0)};
      // Half of them in the ring.
      const double r = static_cast<double>(
          radius(std::sqrt(pole.radius2 + 20 * width * static_cast<Real>(random.uniform(-1, 1)))));
      const double azimuth = random.uniform(0, 2 * std::numbers::pi);
      if (random.uniform() < 0.5 && std::isfinite(r))
        pixel = {960 + 1000 * r * std::cos(azimuth), 600 + 1003 * r * std::sin(azimuth)};
    }
    const auto rays = raysBothWays(camera, pixels, kRayTolerance);
    ASSERT_EQ(rays.size(), pixels.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      ASSERT_EQ(rays[i].status, ProjectStatus::kOk) << "lens " << lens << ", " << pixels[i].transpose();
      const auto m = TextbookLens<Rational>::project(params.data() + 4, rays[i].ray.cast<Real>());
      ASSERT_TRUE(m);
      const Eigen::Vector2d back(static_cast<double>(1000 * m->x() + 960),
                                 static_cast<double>(1003 * m->y() + 600));
      worst_px = std::max(worst_px, (back - pixels[i]).norm());
      ++num_pixels;
    }
  }
  std::printf("%ld pixels of lenses with near poles, worst %.1e px\n", num_pixels, worst_px);
  EXPECT_EQ(num_pixels, numRays() / kNumLenses * kNumLenses);
  EXPECT_LE(worst_px, kPixelTolerance);
}

}  // namespace
}  // namespace alidade
