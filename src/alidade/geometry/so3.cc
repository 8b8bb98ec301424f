// SPDX-License-Identifier: MIT
#include "alidade/geometry/so3.h"

#include <cmath>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade::detail {

void requireDirection(const Eigen::Vector4d& xyzw) {
  if (std::isnormal(xyzw.squaredNorm())) return;
  throw inputError({"quaternion",
                    "x, y, z, w = " + exactText(xyzw(0)) + ", " + exactText(xyzw(1)) + ", " +
                        exactText(xyzw(2)) + ", " + exactText(xyzw(3)),
                    "finite numbers, not all zero", "normalise it to length 1"});
}

}  // namespace alidade::detail
