// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "alidade/adjust/board/fit.h"

namespace alidade {

/// Views of two cameras, or of two settings of one.
struct TwoCameras {
  std::vector<std::size_t> minority = {};  ///< indices of the views of the camera with fewer views
  std::vector<double> params_step = {};    ///< N: its parameters less those of the other one, to first order
};

/// Tests whether the views fall into two groups, each with its own intrinsics. To first order each place of
/// the board (placesOf()) gives an information and a gradient of the intrinsics. Two groups that the names
/// suggest are compared by an F test. Otherwise k-means in this metric finds two offsets and the places of
/// each, and along the line between the offsets a mixture of two normal distributions is compared with a
/// single one, whose width is free: a lens that does not follow the model, a focus that breathes or a moving
/// board vary continuously.
/// @param fit       of one camera, solved
/// @param names     of the views' images
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @returns std::nullopt if nothing speaks for two groups of at least three places each
[[nodiscard]] std::optional<TwoCameras> twoCameras(const Fit& fit, std::span<const std::string> names,
                                                   double variance);

}  // namespace alidade
