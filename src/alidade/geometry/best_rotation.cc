// SPDX-License-Identifier: MIT
#include "alidade/geometry/best_rotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace alidade {

SO3 bestRotation(const Eigen::Matrix3d& correlation) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(correlation, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  const Eigen::Matrix3d R = U * svd.matrixV().transpose();
  return SO3::fromQuaternion(Eigen::Quaterniond(R));
}

}  // namespace alidade
