// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "alidade/files/formats/lens_numbers.h"

// Lenses of COLMAP: names and orders of the parameters in colmap/sensor/models.h. COLMAP counts pixels from
// the image's corner: the centre of the first one is (0.5, 0.5).
namespace alidade::detail {

inline constexpr double kColmapOrigin = 0.5;  ///< px, of the first pixel's centre

/// If several entries have the same model, the first one is written.
inline constexpr std::array<LensLayout, 13> kColmapLenses = {
    {{"PINHOLE", "pinhole", "fx fy cx cy"},
     {"OPENCV", "radtan", "fx fy cx cy k1 k2 p1 p2"},
     {"FULL_OPENCV", "rational", "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"},
     {"OPENCV_FISHEYE", "kannala_brandt", "fx fy cx cy k1 k2 k3 k4"},
     {"FOV", "fov", "fx fy cx cy w"},
     {"EUCM", "eucm", "fx fy cx cy alpha beta"},
     {"SIMPLE_PINHOLE", "pinhole", "f cx cy"},
     {"SIMPLE_RADIAL", "radtan", "f cx cy k1"},
     {"RADIAL", "radtan", "f cx cy k1 k2"},
     {"SIMPLE_FISHEYE", "kannala_brandt", "f cx cy"},
     {"FISHEYE", "kannala_brandt", "fx fy cx cy"},
     {"SIMPLE_RADIAL_FISHEYE", "kannala_brandt", "f cx cy k1"},
     {"RADIAL_FISHEYE", "kannala_brandt", "f cx cy k1 k2"}}};

}  // namespace alidade::detail
