// SPDX-License-Identifier: MIT
#include "support/lens_draw.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "alidade/camera/image_domain.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr double kWholeImageDeg = 140;

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// Coefficients that bend the image's border by the same share whatever the field: they go with the powers of
// the border's radius on the plane z = 1 (here relative to that of 60 degrees), for wide fields downwards.
double scaled(double coefficient, int power, double rim_rad) {
  constexpr double kReference = 0.577;  // tan(30 degrees)
  return coefficient * std::pow(std::min(kReference / std::tan(rim_rad), 3.0), power);
}

std::vector<double> drawPolynomial(double rim_rad, Random& random) {
  const double k1 = random.uniform(-0.35, 0.15);
  const double k2 = random.uniform(-0.05, 0.15);
  const double p1 = random.uniform(-1e-3, 1e-3);
  const double p2 = random.uniform(-1e-3, 1e-3);
  const double k3 = random.uniform(-0.03, 0.03);
  return {scaled(k1, 2, rim_rad), scaled(k2, 4, rim_rad), scaled(p1, 1, rim_rad), scaled(p2, 1, rim_rad),
          scaled(k3, 6, rim_rad)};
}

// tan(s theta) / (s tan(theta)) is 1 for a perspective (s = 1) and bends towards the stereographic lens
// (s = 1/2); as a quotient of polynomials in tan(theta)^2 it begins 1 + (s^2 - 1) / 3 r^2 + ...
std::vector<double> drawRational(double rim_rad, Random& random) {
  std::vector<double> lens = drawPolynomial(rim_rad, random);
  const double k4 = random.uniform(0, 0.7);
  const double k5 = random.uniform(0, 0.1);
  lens[0] += k4;
  lens[1] += 0.4 * k4 * k4 * random.uniform() + k5;
  lens.insert(lens.end(), {k4, k5, random.uniform(0, 0.01)});
  return lens;
}

std::vector<double> drawAnglePolynomial(Random& random) {
  const double k1 = random.uniform(-0.12, 0.15);
  const double k2 = random.uniform(-0.03, 0.03);
  const double k3 = random.uniform(-0.01, 0.01);
  return {k1, k2, k3, random.uniform(-0.002, 0.002)};
}

std::vector<double> drawLens(std::string_view model_id, double rim_rad, Random& random) {
  if (model_id == "pinhole") return {};
  if (model_id == "radtan") return drawPolynomial(rim_rad, random);
  if (model_id == "rational") return drawRational(rim_rad, random);
  if (model_id == "thin_prism") {
    std::vector<double> lens = drawRational(rim_rad, random);
    for (int i = 0; i < 4; ++i) lens.push_back(scaled(random.uniform(-1e-3, 1e-3), 1, rim_rad));
    return lens;
  }
  if (model_id == "tilted") {
    std::vector<double> lens = drawLens("thin_prism", rim_rad, random);
    for (int i = 0; i < 2; ++i) lens.push_back(random.uniform(-0.15, 0.15));
    return lens;
  }
  if (model_id == "kannala_brandt") return drawAnglePolynomial(random);
  if (model_id == "thin_prism_fisheye" || model_id == "fisheye624") {
    std::vector<double> lens = drawAnglePolynomial(random);
    const bool is_624 = model_id == "fisheye624";
    if (is_624) lens.insert(lens.end(), {random.uniform(-2e-4, 2e-4), random.uniform(-2e-5, 2e-5)});
    for (int i = 0; i < (is_624 ? 6 : 4); ++i) lens.push_back(random.uniform(-1e-3, 1e-3));
    return lens;
  }
  if (model_id == "ocam") {
    const double a2 = random.uniform(-0.45, -0.2);
    const double a3 = random.uniform(-0.05, 0.05);
    return {a2,
            a3,
            random.uniform(-0.06, 0),
            random.uniform(-0.01, 0.01),
            random.uniform(-2e-3, 2e-3),
            random.uniform(-1e-3, 1e-3),
            0};
  }
  if (model_id == "fov") return {random.uniform(0.4, 1.3)};
  const bool is_wide = rim_rad > radians(60);
  const double alpha = is_wide ? random.uniform(0.45, 0.68) : random.uniform(0.05, 0.75);
  if (model_id == "ucm") return {alpha};
  if (model_id == "eucm") return {alpha, random.uniform(0.7, 1.6)};
  if (model_id == "double_sphere") {
    const double xi = random.uniform(-0.3, 0.3);
    return {xi, alpha};
  }
  expect(model_id == "omni", "a model that can be drawn");
  std::vector<double> lens = {alpha / (1 - alpha)};
  lens.push_back(random.uniform(-0.2, 0.2));
  lens.push_back(random.uniform(-0.1, 0.1));
  lens.push_back(random.uniform(-1e-3, 1e-3));
  lens.push_back(random.uniform(-1e-3, 1e-3));
  return lens;
}

// Radius on the normalised plane of a ray along x at the rim, or nothing.
double rimRadius(const AnyCamera& unit, double rim_rad) {
  const Projection p = unit.project({std::sin(rim_rad), 0, std::cos(rim_rad)});
  return p.ok() ? p.pixel.x() : 0.0;
}

}  // namespace

DrawnCamera drawCamera(std::string_view model_id, double fov_deg, Random& random) {
  constexpr std::array<ImageSize, 5> kSizes = {
      {{640, 480}, {1280, 960}, {1920, 1200}, {1080, 1920}, {4000, 3000}}};
  constexpr int kMaxDraws = 10000;
  const ImageSize size = kSizes[random.index(kSizes.size())];
  const double rim_rad = radians(0.5 * fov_deg);
  for (int i = 0; i < kMaxDraws; ++i) {
    std::vector<double> params = {1, 1, 0, 0};
    const std::vector<double> lens = drawLens(model_id, rim_rad, random);
    params.insert(params.end(), lens.begin(), lens.end());
    const double radius = rimRadius(AnyCamera::make(model_id, params), rim_rad);
    const double aspect = 1 + random.uniform(-0.01, 0.01);
    const double off_x = random.uniform(-0.05, 0.05);
    const double off_y = random.uniform(-0.05, 0.05);
    if (!(radius > 0)) continue;
    params[0] = 0.5 * std::max(size.width, size.height) / radius;
    params[1] = aspect * params[0];
    params[2] = 0.5 * (size.width - 1) + off_x * size.width;
    params[3] = 0.5 * (size.height - 1) + off_y * size.height;
    const AnyCamera camera = AnyCamera::make(model_id, params);
    const bool is_whole = fov_deg <= kWholeImageDeg;
    if (is_whole && !certifyDomain(camera, size).full_image) continue;
    return {.camera = camera, .size = size, .rim_rad = is_whole ? std::numbers::pi : rim_rad};
  }
  expect(false, "a model that reaches this field");
  throw std::logic_error("unreachable");
}

}  // namespace alidade
