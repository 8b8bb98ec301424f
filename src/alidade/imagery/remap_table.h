// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"
#include "alidade/imagery/output_view.h"

namespace alidade {

/// Where in a source image a pixel of an output image comes from. Pixel (0, 0) is the centre of the top left
/// pixel.
struct SourcePixel {
  float x = 0;
  float y = 0;

  /// False where the output shows nothing of the source; both coordinates are NaN then.
  [[nodiscard]] bool exists() const { return x == x; }
};

/// The source pixels of all pixels of an output image, rows one after another. Each is within 1e-4 pixels of
/// the camera's projection, beside the rounding of the result to a float.
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

/// Projects the ray of each pixel of `view` by `camera`. No source has a pixel without a ray, a ray that the
/// camera does not see (behind it, beyond a fold, out of its domain), and one that falls outside of the image
/// [-0.5, width - 0.5) x [-0.5, height - 0.5).
///
/// Most pixels come from polynomials over tiles, checked against the camera to 1e-5 pixels between their
/// nodes: at the middles of the nodes' grid and every 4 pixels on the way from the pixel nearest to the
/// optical axis to the farthest one, which crosses every ring that a lens may have. Where that fails tiles
/// are halved; by the end of the cone and by the image's border pixels are projected themselves. An
/// unevenness of the lens that is neither a ring nor as wide as the grid of the checks, a twelfth of a tile,
/// would not be seen; no model of the list has such a term.
/// @param num_jobs  threads; 0: one a processor. The table does not depend on it.
/// @throws Cancelled once `cancel` is raised
[[nodiscard]] RemapTable makeRemapTable(const AnyCamera& camera, ImageSize source_size,
                                        const OutputView& view, int num_jobs = 1,
                                        const CancelFlag* cancel = nullptr);

/// The same into a table that may have been used before: its memory is taken again if it is large enough.
/// Whatever is thrown leaves an empty table.
void fillRemapTable(const AnyCamera& camera, ImageSize source_size, const OutputView& view, RemapTable& table,
                    int num_jobs = 1, const CancelFlag* cancel = nullptr);

}  // namespace alidade
