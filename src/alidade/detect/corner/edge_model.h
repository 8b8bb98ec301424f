// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "alidade/detect/corner/edge_pixels.h"

namespace alidade {

/// The image of two edges that cross: an X-corner. With the signed distances d1 and d2 of a pixel to two
/// slightly curved lines through the corner, z_i = d_i / s_i and E = erf(z1 / sqrt 2) erf(z2 / sqrt 2), its
/// grey level is
///
///   (1 + sx X + sy Y) (a + b E + c (1 - E^2))
///
/// erf is a straight edge under Gaussian blur of standard deviation s; c bends the tone curve between dark
/// and bright, as gamma, clipping and spreading ink do, and the first factor is shading. d = v - k u^2 / 2,
/// where u runs along the line's direction (cos t, sin t) from the corner and v across it, towards (-sin t,
/// cos t).
///
/// All lengths are pixels, t radians, k 1/px, a b c grey levels; the caller chooses the origin of
/// positions.
struct EdgeModel {
  enum Parameter : std::size_t {
    kX,
    kY,
    kAngle1,
    kAngle2,
    kCurvature1,
    kCurvature2,
    kBlur1,
    kBlur2,
    kMean,           ///< a
    kAmplitude,      ///< b
    kTone,           ///< c
    kShadeX,         ///< sx
    kShadeY,         ///< sy
    kNumParameters,  ///< their number
  };

  std::array<double, kNumParameters> values{};

  [[nodiscard]] double operator[](std::size_t i) const { return values[i]; }
  [[nodiscard]] double& operator[](std::size_t i) { return values[i]; }

  [[nodiscard]] Eigen::Vector2d corner() const { return {values[kX], values[kY]}; }
  /// Direction of line 0 or 1 at the corner, and the normal along which its distances are counted.
  [[nodiscard]] Eigen::Vector2d direction(std::size_t line) const {
    return {std::cos(values[kAngle1 + line]), std::sin(values[kAngle1 + line])};
  }
  [[nodiscard]] Eigen::Vector2d normal(std::size_t line) const {
    return {-std::sin(values[kAngle1 + line]), std::cos(values[kAngle1 + line])};
  }
  [[nodiscard]] double largerBlur() const { return std::fmax(values[kBlur1], values[kBlur2]); }
  /// Brightness at the corner relative to the origin.
  [[nodiscard]] double shadeAtCorner() const {
    return 1 + values[kShadeX] * values[kX] + values[kShadeY] * values[kY];
  }
};

using EdgeSums = NormalEquations<EdgeModel::kNumParameters>;

/// Residuals and derivatives of each pixel after a fit.
struct EdgeResiduals {
  std::vector<float> residual;  ///< observed - modelled, grey levels
  std::vector<float> slope1;    ///< derivative of the modelled grey level by d1, 1/px
  std::vector<float> slope2;    ///< by d2
  std::vector<float> pattern;   ///< E
};

/// Single precision per pixel: erf is accurate to 1.5e-7 (Abramowitz and Stegun 1964, 7.1.26), relative
/// errors of the sums are about 1e-6. Results are the same on every thread; between processors with and
/// without AVX2, they may differ by rounding.
void sumNormalEquations(const EdgePixels& pixels, const EdgeModel& model, EdgeSums& sums);

/// Fills columns of at least pixels.size() values.
void evaluateResiduals(const EdgePixels& pixels, const EdgeModel& model, EdgeResiduals& residuals);

}  // namespace alidade
