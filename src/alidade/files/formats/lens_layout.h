// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/files/formats/lens_numbers.h"

namespace alidade::detail {

/// A lens as another program lists it.
struct LensLayout {
  std::string_view name;   ///< the program's own name of it
  std::string_view model;  ///< ours
  /// The parameters by our names, in the program's order: "xi fx fy cx cy". "f" is fx and fy alike; what is
  /// not listed is zero.
  std::string_view order;
};

[[nodiscard]] std::vector<std::string> listedNames(const LensLayout& layout);

/// The layout of this name; null if there is none.
[[nodiscard]] const LensLayout* findLayout(std::span<const LensLayout> layouts, std::string_view name);

/// The first layout that can say a camera of this model; there must be one.
[[nodiscard]] const LensLayout& layoutOf(std::span<const LensLayout> layouts, std::string_view model);

/// From the program's order to ours; `listed` has a number for each name.
[[nodiscard]] std::vector<StatedNumber> storageOrder(const LensLayout& layout,
                                                     std::span<const StatedNumber> listed);

/// From ours to the program's, whose first pixel has its centre at (origin, origin). What the layout does not
/// list is dropped, so it must be zero.
[[nodiscard]] std::vector<double> listedOrder(const LensLayout& layout, const AnyCamera& camera,
                                              double origin = 0);

/// From the origin of a program whose first pixel has its centre at (origin, origin) to ours: the principal
/// point is the third and fourth parameter.
void takeOrigin(std::span<StatedNumber> parameters, double origin);

}  // namespace alidade::detail
