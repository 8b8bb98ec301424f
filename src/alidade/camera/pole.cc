// SPDX-License-Identifier: MIT
#include "alidade/camera/pole.h"

#include <cmath>
#include <variant>

#include "alidade/camera/camera_variant.h"

namespace alidade {

std::optional<double> poleAngle(const AnyCamera& camera) {
  const auto find = []<class M>(const Camera<M>& c) -> std::optional<double> {
    const double* lens = c.params().data() + 4;
    const double angle = M::maxAngle(lens);
    if (!(angle < M::kMaxAngle)) return std::nullopt;
    // A lens has no value beyond a pole, unlike beyond a fold.
    constexpr double kBeyond = 1e-9;
    const double ray[3] = {std::sin(angle + kBeyond), 0, std::cos(angle + kBeyond)};
    return M::hasValue(lens, ray) ? std::nullopt : std::optional(angle);
  };
  return std::visit(find, camera.variant().camera);
}

}  // namespace alidade
