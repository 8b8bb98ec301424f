// SPDX-License-Identifier: MIT
#include "alidade/geometry/rotation_conversions.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <string>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

Error rotationMatrixError(const std::string& found, const std::string& next_step) {
  return inputError({"rotation matrix", found, "orthonormal columns and determinant +1", next_step});
}

void checkRotationMatrix(const Eigen::Matrix3d& R, double tolerance) {
  expect(tolerance > 0.0 && tolerance < 1.0, "the tolerance on a rotation matrix is in (0, 1)");
  if (!R.allFinite()) throw rotationMatrixError("an entry is not a finite number", "");
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(R.col(i).squaredNorm() - 1.0) <= tolerance)) {
      throw rotationMatrixError("column " + std::to_string(i) + " has length " + exactText(R.col(i).norm()),
                                "write it with more digits, or remove the scale");
    }
    for (int j = 0; j < i; ++j) {
      if (!(std::abs(R.col(i).dot(R.col(j))) <= tolerance)) {
        throw rotationMatrixError("columns " + std::to_string(j) + " and " + std::to_string(i) +
                                      " are not perpendicular, their dot product is " +
                                      exactText(R.col(i).dot(R.col(j))),
                                  "write it with more digits, or check the order of its entries");
      }
    }
  }
  if (!(R.determinant() > 0.0)) {
    throw rotationMatrixError("a reflection, its determinant is " + exactText(R.determinant()),
                              "check that both frames are right-handed");
  }
}

}  // namespace

void detail::requireDirection(const std::array<double, 4>& xyzw) {
  const auto [x, y, z, w] = xyzw;
  if (std::isnormal(x * x + y * y + z * z + w * w)) return;
  throw inputError(
      {"quaternion",
       "x, y, z, w = " + exactText(x) + ", " + exactText(y) + ", " + exactText(z) + ", " + exactText(w),
       "finite numbers, not all zero", "normalise it to length 1"});
}

SO3 rotationFromMatrix(const Eigen::Matrix3d& R, double tolerance) {
  checkRotationMatrix(R, tolerance);
  const Svd3 svd = svdOf(R);
  const Eigen::Matrix3d nearest = svd.U * svd.V.transpose();
  return SO3::fromQuaternion(Eigen::Quaterniond(nearest));
}

SE3 motionFromMatrix(const Eigen::Matrix4d& matrix, double tolerance) {
  const Eigen::RowVector4d last_row = matrix.row(3);
  const Eigen::RowVector4d off = last_row - Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  if (!(off.array().abs() <= tolerance).all()) {
    throw inputError({"homogeneous matrix",
                      "the last row is " + exactText(last_row(0)) + " " + exactText(last_row(1)) + " " +
                          exactText(last_row(2)) + " " + exactText(last_row(3)),
                      "0 0 0 1", "check that the matrix is not transposed"});
  }
  const Eigen::Vector3d translation = matrix.topRightCorner<3, 1>();
  if (!translation.allFinite()) {
    throw inputError({"homogeneous matrix", "a translation that is not finite", "finite metres", ""});
  }
  return {rotationFromMatrix(matrix.topLeftCorner<3, 3>(), tolerance), translation};
}

SO3 rotationFromEuler(const EulerZyx& angles) {
  for (const double angle : {angles.yaw_rad, angles.pitch_rad, angles.roll_rad}) {
    if (!std::isfinite(angle)) {
      throw inputError({"Euler angles", exactText(angle), "finite yaw, pitch and roll in radians", ""});
    }
  }
  using Vec3 = Eigen::Vector3d;
  return SO3::exp(angles.yaw_rad * Vec3::UnitZ()) * SO3::exp(angles.pitch_rad * Vec3::UnitY()) *
         SO3::exp(angles.roll_rad * Vec3::UnitX());
}

EulerDecomposition eulerFromRotation(const SO3& rotation) {
  constexpr double kGimbalLockCosine = 1e-8;
  const Eigen::Matrix3d R = rotation.matrix();
  const double cos_pitch = std::hypot(R(0, 0), R(1, 0));
  EulerDecomposition result;
  EulerZyx& angles = result.angles;
  angles.pitch_rad = std::atan2(-R(2, 0), cos_pitch);
  result.gimbal_lock = cos_pitch < kGimbalLockCosine;
  if (result.gimbal_lock) {
    angles.yaw_rad = std::atan2(-R(0, 1), R(1, 1));
    return result;
  }
  angles.yaw_rad = std::atan2(R(1, 0), R(0, 0));
  // The second row of Rz(-yaw) R is (0, cos(roll), -sin(roll)). The last row of R would give another roll
  // than the one that belongs to this yaw: near the poles each is inaccurate, and only the pair is the
  // rotation.
  const double c = std::cos(angles.yaw_rad);
  const double s = std::sin(angles.yaw_rad);
  angles.roll_rad = std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1));
  return result;
}

std::optional<Eigen::Vector3d> rotationAxis(const Eigen::Matrix3d& R, double tolerance) {
  constexpr double kNone = 4 * std::numeric_limits<double>::epsilon();
  const SO3 rotation = rotationFromMatrix(R, tolerance);
  const Eigen::Matrix3d offset = rotation.matrix() - Eigen::Matrix3d::Identity();
  if (offset.cwiseAbs().maxCoeff() <= kNone) return std::nullopt;
  // Its singular values are 0, and 2 sin(angle / 2) twice.
  const Eigen::Vector3d axis = svdOf(offset).V.col(2);
  return axis.dot(rotation.log()) < 0.0 ? Eigen::Vector3d(-axis) : axis;
}

SO3 bestRotation(const Eigen::Matrix3d& correlation) {
  auto [U, values, V] = svdOf(correlation);
  if ((U * V.transpose()).determinant() < 0) U.col(2) = -U.col(2);
  const Eigen::Matrix3d R = U * V.transpose();
  return SO3::fromQuaternion(Eigen::Quaterniond(R));
}

}  // namespace alidade
