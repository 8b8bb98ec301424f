// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/formats/stated_camera.h"

namespace alidade::detail {

/// Scaramuzza's lens in the notation of his toolbox and its descendants. A pixel is A (x, y) + centre with
/// A = [c d; e 1], and its ray (x, y, a0 + a2 r^2 + a3 r^3 + ...) with r = |(x, y)| in pixels. The ray's
/// third component points forwards or backwards, by the sign of a0.
struct OcamNumbers {
  std::vector<StatedNumber> polynomial;  ///< a0, a1 (which must be 0), a2, ...
  std::array<StatedNumber, 3> affine;    ///< c, d, e
  std::array<StatedNumber, 2> centre;    ///< px, in the order of x and y
  bool is_row_first = false;             ///< x counts rows (downwards) and y columns
  double origin = 0;                     ///< of the first pixel's centre, px
};

/// @param place  for messages
/// @throws Error (kInput) for numbers that describe no lens; UnsupportedCamera for a polynomial of higher
/// degree
[[nodiscard]] StatedCamera stateOcam(const std::string& place, const OcamNumbers& numbers,
                                     std::optional<ImageSize> image_size, std::vector<Remark> remarks = {});

/// The numbers of an `ocam` camera, with a positive a0.
[[nodiscard]] OcamNumbers ocamNumbers(const AnyCamera& camera, bool is_row_first, double origin);

}  // namespace alidade::detail
