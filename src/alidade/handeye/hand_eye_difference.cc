// SPDX-License-Identifier: MIT
#include "alidade/handeye/hand_eye_difference.h"

#include <cmath>
#include <string>

#include "alidade/core/error.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {

bool HandEyeDifference::isSignificant() const {
  return sigmas > kNormalOneInThousand;
}

HandEyeDifference differenceOf(const HandEyeRecord& a, const HandEyeRecord& b, double distance_m) {
  if (a.camera_on != b.camera_on) {
    throw inputError({.where = "hand-eye transforms",
                      .found = "one camera on the hand and one on the base",
                      .expected = "two transforms of the same camera"});
  }
  const Vector6d tangent = (a.mount_from_camera.inverse() * b.mount_from_camera).log();
  const Eigen::Vector3d point(0, 0, distance_m);
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -hat(point);
  const Matrix6d covariance = a.covariance + b.covariance;
  HandEyeDifference difference{
      .translation_m = (b.mount_from_camera.translation - a.mount_from_camera.translation).norm(),
      .rotation_rad = tangent.tail<3>().norm(),
      .point_m = (a.mount_from_camera * point - b.mount_from_camera * point).norm(),
      .point_std_m = std::sqrt((J * covariance * J.transpose()).trace() / 3)};
  const bool is_known = !a.covariance.isZero(0) && !b.covariance.isZero(0);
  if (is_known) difference.sigmas = normalOfMeanSquare(tangent.dot(solveSpd6(covariance, tangent)) / 6, 6);
  return difference;
}

}  // namespace alidade
