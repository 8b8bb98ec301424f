// SPDX-License-Identifier: MIT
#include "alidade/imagery/tile_polynomial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace alidade {
namespace {

// Of degree 5 in each coordinate, far from the origin.
Eigen::Vector2d surface(double s, double t) {
  return {1234.567 + 60 * s + 3 * t - 2 * s * s * t + 0.3 * std::pow(s, 5) - 0.1 * std::pow(s * t, 3),
          -345.678 + 55 * t + s * t - 0.4 * std::pow(t, 5) + 0.2 * std::pow(s, 4) * std::pow(t, 5)};
}

TilePolynomial polynomialOfSurface() {
  std::vector<Eigen::Vector2d> values;
  for (const double t : TilePolynomial::nodes()) {
    for (const double s : TilePolynomial::nodes()) values.push_back(surface(s, t));
  }
  return TilePolynomial(values);
}

TEST(TilePolynomial, GoesThroughAnySurfaceOfItsDegree) {
  const TilePolynomial polynomial = polynomialOfSurface();
  std::vector<double> s, t;
  for (int i = 0; i < 40; ++i) {
    s.push_back(std::cos(7.0 * i));
    t.push_back(std::sin(3.0 * i + 1));
  }
  std::vector<double> x(s.size()), y(s.size());
  polynomial.evaluate(s, t, x.data(), y.data());
  int num_checked = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const Eigen::Vector2d expected = surface(s[i], t[i]);
    EXPECT_NEAR(x[i], expected.x(), 1e-11);
    EXPECT_NEAR(y[i], expected.y(), 1e-11);
    EXPECT_LE(std::abs(x[i] - polynomial.centre().x()), polynomial.spread().x());
    EXPECT_LE(std::abs(y[i] - polynomial.centre().y()), polynomial.spread().y());
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 40);
}

TEST(TilePolynomial, WritesTilesOfAnySizeAndNothingBesideThem) {
  const TilePolynomial polynomial = polynomialOfSurface();
  int num_checked = 0;
  for (const int width : {8, 9, 11, 15, 16, 17, 31, 64, 100, 160}) {
    for (const int height : {8, 15, 16, 17, 33}) {
      const std::ptrdiff_t stride = width + 3;
      std::vector<SourcePixel> pixels(static_cast<std::size_t>(stride * height), SourcePixel{-1, -2});
      polynomial.write(width, height, pixels.data(), stride);
      double worst = 0;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < stride; ++x) {
          const SourcePixel& found = pixels[static_cast<std::size_t>(y * stride + x)];
          if (x >= width) {
            EXPECT_EQ(found.x, -1);
            EXPECT_EQ(found.y, -2);
            continue;
          }
          const Eigen::Vector2d expected = surface(2.0 * x / (width - 1) - 1, 2.0 * y / (height - 1) - 1);
          worst = std::max({worst, std::abs(found.x - expected.x()) - 6.2e-5,  // half a unit of 1234.567
                            std::abs(found.y - expected.y()) - 1.6e-5});
        }
      }
      EXPECT_LE(worst, 1.5e-5) << width << "x" << height;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 50);
}

TEST(TilePolynomial, RefusesTilesSmallerThanAVector) {
  const TilePolynomial polynomial = polynomialOfSurface();
  std::vector<SourcePixel> pixels(64);
  EXPECT_THROW(polynomial.write(7, 8, pixels.data(), 8), std::logic_error);
}

}  // namespace
}  // namespace alidade
