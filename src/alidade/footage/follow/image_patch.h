// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Position of a patch of one image in a second image.
struct PatchPlace {
  Eigen::Vector2f pixel{0, 0};                               ///< of the patch's centre
  Eigen::Matrix2f shape = Eigen::Matrix2f::Identity();       ///< maps offsets in the first image
  Eigen::Matrix2f covariance = Eigen::Matrix2f::Identity();  ///< of the pixel, from the remaining differences
  float correlation = 0;                                     ///< with the first image, 1 for the same patch
};

/// The surroundings of a pixel, to be found in other images after a displacement and an affine deformation,
/// with different brightness and contrast. Gauss-Newton steps use the patch's own derivatives, computed once
/// (inverse compositional alignment: Baker and Matthews 2004, IJCV 56(3), section 3.2), with brightness and
/// contrast as two further unknowns. Images are interpolated by cubic convolution (Keys 1981).
class ImagePatch {
 public:
  static constexpr int kRadius = 7;  ///< pixels from the centre to the edge

  /// @returns nothing near the image's edge, or if there is no texture in some direction
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
