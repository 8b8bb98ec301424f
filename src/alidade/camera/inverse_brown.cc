// SPDX-License-Identifier: MIT
#include "alidade/camera/inverse_brown.h"

#include <cmath>

#include "alidade/camera/domain.h"

namespace alidade {

double InverseBrown::lastRadius(const double* k) {
  const ConeLimits limits{.model_rad = Radtan::kMaxAngle,
                          .closed_form_rad = Radtan::maxAngle(k),
                          .is_axially_symmetric = Radtan::isAxiallySymmetric(k)};
  return std::tan(certifyCone(lensFunction<Radtan>(k), limits).max_angle_rad);
}

}  // namespace alidade
