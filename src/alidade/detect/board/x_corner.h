// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// A place where four alternately dark and bright sectors meet: an inner corner of a checkerboard, or a local
/// pattern that resembles one.
struct XCorner {
  Eigen::Vector2d pixel;  ///< accurate to about half a pixel
  /// Unit directions of the four edges that leave the corner, clockwise in the image.
  std::array<Eigen::Vector2d, 4> edges{};
  bool first_sector_is_dark = false;  ///< the sector from edges[0] clockwise to edges[1]
  double contrast = 0;                ///< between bright and dark sectors, grey levels

  /// True if the sector that follows edge k clockwise is dark.
  [[nodiscard]] bool sectorIsDark(int k) const { return first_sector_is_dark == (k % 2 == 0); }
};

/// Position in the whole image of a pixel of the image that was halved `times` times by detail::shrunk().
[[nodiscard]] inline Eigen::Vector2d fromHalved(const Eigen::Vector2d& pixel, int times) {
  const double scale = 1 << times;
  return scale * (pixel.array() + 0.5).matrix() - Eigen::Vector2d(0.5, 0.5);
}

/// The image smoothed by the 5 x 5 binomial kernel, times 256.
struct SmoothImage {
  ImageSize size;
  std::vector<std::uint16_t> values;

  [[nodiscard]] const std::uint16_t* row(int y) const {
    return values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width);
  }
  /// Grey level between pixels, bilinear.
  /// @pre covers(pixel)
  [[nodiscard]] double at(const Eigen::Vector2d& pixel) const {
    const int x = static_cast<int>(pixel.x());
    const int y = static_cast<int>(pixel.y());
    const double fx = pixel.x() - x;
    const double fy = pixel.y() - y;
    const std::uint16_t* upper = row(y) + x;
    const std::uint16_t* lower = upper + size.width;
    return ((1 - fy) * ((1 - fx) * upper[0] + fx * upper[1]) + fy * ((1 - fx) * lower[0] + fx * lower[1])) /
           256;
  }
  /// True if at() may be called.
  [[nodiscard]] bool covers(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < size.width - 1 && pixel.y() < size.height - 1;
  }
};

[[nodiscard]] SmoothImage smoothed(const GrayImage& image);

/// All X-corners whose squares are at least about six pixels wide: maxima of the saddle response
/// Ixy^2 - Ixx Iyy (minus the determinant of the Hessian; Beaudet 1978, Rotationally invariant image
/// operators), kept if a circle around them crosses from dark to bright exactly four times, in opposite
/// pairs.
[[nodiscard]] std::vector<XCorner> findXCorners(const SmoothImage& image);

/// The X-corner at the strongest saddle within about `radius_px` of `guess`, tested on a circle of `ring_px`
/// around it. False if there is none.
[[nodiscard]] bool xCornerNear(const SmoothImage& image, const Eigen::Vector2d& guess, double radius_px,
                               double ring_px, XCorner& corner);

}  // namespace alidade
