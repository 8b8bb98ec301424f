// SPDX-License-Identifier: MIT
#include "alidade/geometry/best_rotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "alidade/geometry/decompositions.h"

namespace alidade {

SO3 bestRotation(const Eigen::Matrix3d& correlation) {
  auto [U, values, V] = svdOf(correlation);
  if ((U * V.transpose()).determinant() < 0) U.col(2) = -U.col(2);
  const Eigen::Matrix3d R = U * V.transpose();
  return SO3::fromQuaternion(Eigen::Quaterniond(R));
}

}  // namespace alidade
