// SPDX-License-Identifier: MIT
#include "alidade/footage/follow/image_patch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/LU>

#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// Weights of four samples around a position, by Keys' cubic convolution.
inline void cubicWeights(float t, float* w) {
  const float t2 = t * t;
  const float t3 = t2 * t;
  w[0] = -0.5F * t3 + t2 - 0.5F * t;
  w[1] = 1.5F * t3 - 2.5F * t2 + 1;
  w[2] = -1.5F * t3 + 2 * t2 + 0.5F * t;
  w[3] = 0.5F * t3 - 0.5F * t2;
}

// @pre at least one pixel from the edge
inline float cubicAt(const GrayImage& image, float x, float y) {
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  float wx[4];
  float wy[4];
  cubicWeights(x - static_cast<float>(ix), wx);
  cubicWeights(y - static_cast<float>(iy), wy);
  const std::ptrdiff_t width = image.size.width;
  const std::uint8_t* row = image.pixels.data() + (iy - 1) * width + (ix - 1);
  float sum = 0;
  for (int r = 0; r < 4; ++r, row += width)
    sum += wy[r] * (wx[0] * row[0] + wx[1] * row[1] + wx[2] * row[2] + wx[3] * row[3]);
  return sum;
}

bool isInside(const GrayImage& image, const Eigen::Vector2f& pixel, float reach) {
  // One pixel for the interpolation, and one for rounding.
  return pixel.x() >= reach + 2 && pixel.y() >= reach + 2 &&
         pixel.x() < static_cast<float>(image.size.width) - reach - 3 &&
         pixel.y() < static_cast<float>(image.size.height) - reach - 3;
}

}  // namespace

std::optional<ImagePatch> ImagePatch::at(const GrayImage& image, const Eigen::Vector2f& pixel) {
  if (!isInside(image, pixel, kRadius + 1)) return std::nullopt;
  ImagePatch patch;
  constexpr int kWide = kSide + 2;  // with a border for the derivatives
  Eigen::Matrix<float, kWide, kWide> wide;
  for (int y = 0; y < kWide; ++y) {
    for (int x = 0; x < kWide; ++x)
      wide(y, x) = cubicAt(image, pixel.x() + static_cast<float>(x - kRadius - 1),
                           pixel.y() + static_cast<float>(y - kRadius - 1));
  }
  const float mean = wide.mean();  // without it, contrast and brightness would be nearly one unknown
  int i = 0;
  for (int y = 1; y <= kSide; ++y) {
    for (int x = 1; x <= kSide; ++x, ++i) {
      const auto u = static_cast<float>(x - 1 - kRadius);
      const auto v = static_cast<float>(y - 1 - kRadius);
      const float dx = 0.5F * (wide(y, x + 1) - wide(y, x - 1));
      const float dy = 0.5F * (wide(y + 1, x) - wide(y - 1, x));
      patch.samples_[i] = wide(y, x);
      patch.derivatives_.row(i) << dx * u, dy * u, dx * v, dy * v, dx, dy, wide(y, x) - mean, 1;
    }
  }
  patch.spread_ = std::sqrt((patch.samples_.array() - patch.samples_.mean()).square().mean());
  Eigen::Matrix<float, kUnknowns, kUnknowns> normal = patch.derivatives_.transpose() * patch.derivatives_;
  constexpr float kLeastTexture = 0.5F * kPixels;  // sum of squared grey values per pixel squared
  Eigen::Matrix2f place = normal.block<2, 2>(4, 4);
  const float half = 0.5F * place.trace();
  const float least = half - std::sqrt(std::max(0.0F, half * half - place.determinant()));
  if (!(least > kLeastTexture)) return std::nullopt;
  // Keeps deformations that the texture does not determine.
  constexpr float kStiffness = 1e-3F;
  for (int k = 0; k < 4; ++k) normal(k, k) += kStiffness * kRadius * kRadius * place.trace();
  patch.inverse_ = inverseSpd(normal.cast<double>()).cast<float>();
  return patch;
}

std::optional<PatchPlace> ImagePatch::findIn(const GrayImage& image, const PatchPlace& guess) const {
  constexpr int kMostSteps = 15;
  constexpr float kSettled = 0.01F;  // px
  constexpr float kFar = 3;          // px
  PatchPlace place = guess;
  Samples residuals;
  for (int step = 0; step < kMostSteps; ++step) {
    const float reach = kRadius * (place.shape.cwiseAbs().rowwise().sum().maxCoeff());
    if (!isInside(image, place.pixel, reach)) return std::nullopt;
    int i = 0;
    for (int v = -kRadius; v <= kRadius; ++v) {
      for (int u = -kRadius; u <= kRadius; ++u, ++i) {
        const auto fu = static_cast<float>(u);
        const auto fv = static_cast<float>(v);
        const float x = place.pixel.x() + place.shape(0, 0) * fu + place.shape(0, 1) * fv;
        const float y = place.pixel.y() + place.shape(1, 0) * fu + place.shape(1, 1) * fv;
        residuals[i] = cubicAt(image, x, y) - samples_[i];
      }
    }
    const Eigen::Matrix<float, kUnknowns, 1> pull = derivatives_.transpose() * residuals;
    const Eigen::Matrix<float, kUnknowns, 1> delta = inverse_ * pull;
    const float contrast = 1 + delta[6];
    if (!(contrast > 0.3F && contrast < 3)) return std::nullopt;
    Eigen::Matrix2f stretch;
    stretch << delta[0], delta[2], delta[1], delta[3];
    stretch = Eigen::Matrix2f::Identity() + stretch / contrast;
    const Eigen::Vector2f moved = delta.segment<2>(4) / contrast;
    const float det = stretch.determinant();
    if (!(det > 0.4F && det < 2.5F)) return std::nullopt;
    // The image at the expected u of the patch shows stretch * u + moved, so the map is corrected by the
    // inverse.
    place.shape = place.shape * Eigen::Matrix2f(stretch.inverse());
    const Eigen::Vector2f shift = -place.shape * moved;
    place.pixel += shift;
    if (!((place.pixel - guess.pixel).squaredNorm() < kFar * kFar)) return std::nullopt;
    const float turned =
        kRadius * (stretch - Eigen::Matrix2f::Identity()).cwiseAbs().rowwise().sum().maxCoeff();
    if (shift.norm() > kSettled || turned > 10 * kSettled) continue;
    const Samples left = residuals - derivatives_ * delta;
    const float sum = left.squaredNorm();
    const float variance = sum / (kPixels - kUnknowns);
    place.covariance = place.shape * (variance / (contrast * contrast) * inverse_.block<2, 2>(4, 4)) *
                       place.shape.transpose();
    const float explained = (contrast * spread_) * (contrast * spread_) * kPixels;
    place.correlation = std::sqrt(explained / (explained + sum));
    return place;
  }
  return std::nullopt;
}

}  // namespace alidade
