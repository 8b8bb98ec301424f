// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/imagery/output_view.h"

namespace alidade {

/// Source position of a pixel of an output image. Pixel (0, 0) is the centre of the top left pixel.
struct SourcePixel {
  float x = 0;
  float y = 0;

  /// False if the output shows nothing of the source there; both coordinates are then NaN.
  [[nodiscard]] bool exists() const { return x == x; }
};

/// The source pixels of all pixels of an output image, rows one after another.
struct RemapTable {
  ImageSize source_size;
  ImageSize size;
  std::vector<SourcePixel> pixels;
  std::size_t num_without_source = 0;

  [[nodiscard]] const SourcePixel& at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) +
                  static_cast<std::size_t>(x)];
  }
};

/// Projects the ray of each pixel of `view` by `camera`. A pixel has no source if it has no ray, or if the
/// camera does not see the ray (behind it, beyond a fold, outside its domain) or sees it outside the image
/// [-0.5, width - 0.5) x [-0.5, height - 0.5).
/// @param num_jobs  threads; 0: one per processor. The table does not depend on it.
/// @throws Cancelled once `cancel` is set
[[nodiscard]] RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size,
                                        const OutputView& view, int num_jobs = 1,
                                        const CancelFlag* cancel = nullptr);

/// The same for any layout of an output image: `rays_of` sets the rays of the pixels of a row, in the camera
/// frame, and is called from several threads.
using RaysOfRow = std::function<void(std::size_t row, const RayColumns& rays)>;
[[nodiscard]] RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size, ImageSize size,
                                        const RaysOfRow& rays_of, int num_jobs = 1,
                                        const CancelFlag* cancel = nullptr);

enum class Interpolation {
  kLinear,  ///< between the four nearest pixels
  kCubic,   ///< cubic convolution (a = -3/4) of the 16 nearest pixels: sharper, may overshoot at edges
};

/// Largest side of the images that remap() reads and makes, in pixels.
inline constexpr int kMaxRemapSide = 32766;

/// The output image of a table by cv::remap(): each pixel gets the samples of the source at its position,
/// with the same number of channels and bits. Pixels without a source are 0 in all channels. Beyond the
/// centres of the outer pixels, the border repeats, so that edges do not darken. Positions are rounded to
/// 1/32 pixel.
///
/// If the output has a lower resolution than the source, nothing is averaged, and fine patterns may alias.
/// @param image  of the table's source size, with samples of 8 or 16 bits
/// @param num_jobs  threads; 0: one per processor. The image does not depend on it.
/// @throws std::logic_error for another image
[[nodiscard]] RasterImage remap(const RemapTable& table, const RasterImage& image,
                                Interpolation interpolation, int num_jobs = 1);

}  // namespace alidade
