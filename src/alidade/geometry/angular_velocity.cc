// SPDX-License-Identifier: MIT
#include "alidade/geometry/angular_velocity.h"

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

/// vee(rate), where `rate` should be skew-symmetric and as large as the derivative that it was made from.
Eigen::Vector3d veeOfSkew(const Eigen::Matrix3d& rate, double tolerance) {
  const double symmetric_norm = (0.5 * (rate + rate.transpose())).norm();
  const double norm = rate.norm();
  if (!(symmetric_norm <= tolerance * norm)) {
    throw inputError(
        {"derivative of a rotation matrix",
         "the symmetric part of dR/dt R^T has norm " + exactText(symmetric_norm) + " of " + exactText(norm),
         "a skew-symmetric matrix within " + exactText(tolerance) + " of its norm",
         "check that the rotation and its derivative belong to the same time, and that neither is "
         "transposed"});
  }
  return vee(rate);
}

}  // namespace

Eigen::Vector3d angularVelocity(const SO3& fixed_from_body, const Eigen::Matrix3d& derivative,
                                double tolerance) {
  return veeOfSkew(derivative * fixed_from_body.matrix().transpose(), tolerance);
}

Eigen::Vector3d bodyAngularVelocity(const SO3& fixed_from_body, const Eigen::Matrix3d& derivative,
                                    double tolerance) {
  return veeOfSkew(fixed_from_body.matrix().transpose() * derivative, tolerance);
}

}  // namespace alidade
