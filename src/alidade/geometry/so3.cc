// SPDX-License-Identifier: MIT
#include "alidade/geometry/so3.h"

#include <cmath>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade::detail {

void requireDirection(const std::array<double, 4>& xyzw) {
  const auto [x, y, z, w] = xyzw;
  if (std::isnormal(x * x + y * y + z * z + w * w)) return;
  throw inputError(
      {"quaternion",
       "x, y, z, w = " + exactText(x) + ", " + exactText(y) + ", " + exactText(z) + ", " + exactText(w),
       "finite numbers, not all zero", "normalise it to length 1"});
}

}  // namespace alidade::detail
