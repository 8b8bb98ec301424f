// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// The place of a patch of one image in a second image.
struct PatchPlace {
  Eigen::Vector2f pixel{0, 0};                               ///< of the patch's centre
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();       ///< offsets from it, by those in the first image
  Eigen::Matrix2f covariance = Eigen::Matrix2f::Identity();  ///< of the pixel, by the differences that remain
  float correlation = 0;                                     ///< with the first image, 1 for the same patch
};

/// The surroundings of a pixel, to be found again in other images as they look there: moved, deformed by an
/// affine map, and with another brightness and contrast. Gauss-Newton steps on the patch's own derivatives,
/// computed once (inverse compositional alignment: Baker and Matthews 2004, IJCV 56(3), section 3.2), with
/// brightness and contrast as two unknowns more. Images are interpolated by cubic convolution (Keys 1981).
class ImagePatch {
 public:
  static constexpr int kRadius = 7;  ///< pixels from the centre to the edge

  /// @returns nothing near the image's edge, and where there is no texture in some direction
  [[nodiscard]] static std::optional<ImagePatch> at(const GrayImage& image, const Eigen::Vector2f& pixel);

  /// @param guess  correct to about two pixels
  /// @returns nothing if the steps do not converge, go far, or leave the image
  [[nodiscard]] std::optional<PatchPlace> findIn(const GrayImage& image, const PatchPlace& guess) const;

 private:
  static constexpr int kSide = 2 * kRadius + 1;
  static constexpr int kPixels = kSide * kSide;
  static constexpr int kUnknowns = 8;  // shape, place, contrast, brightness
  using Samples = Eigen::Matrix<float, kPixels, 1>;

  Samples samples_;
  Eigen::Matrix<float, kPixels, kUnknowns> derivatives_;
  Eigen::Matrix<float, kUnknowns, kUnknowns> inverse_;  // of their normal equations
  float spread_ = 0;                                    // standard deviation of the samples
};

}  // namespace alidade
