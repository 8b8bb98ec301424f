// SPDX-License-Identifier: MIT
#include "alidade/geometry/rotation_conversions.h"

#include <Eigen/LU>
#include <algorithm>
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

Eigen::Vector4d quaternionXyzw(const SO3& rotation) {
  const Eigen::Vector4d q = rotation.quaternion().coeffs();
  return q.w() < 0 ? Eigen::Vector4d(-q) : q;
}

std::optional<EulerOrder> eulerOrder(std::string_view letters, bool is_fixed) {
  EulerOrder order{.axes = {}, .is_fixed = is_fixed};
  if (letters.size() != order.axes.size()) return std::nullopt;
  for (std::size_t i = 0; i < letters.size(); ++i) {
    order.axes[i] = letters[i] - 'x';
    if (order.axes[i] < 0 || order.axes[i] > 2 || (i > 0 && letters[i] == letters[i - 1]))
      return std::nullopt;
  }
  return order;
}

SO3 rotationFromEuler(const Eigen::Vector3d& angles_rad, const EulerOrder& order) {
  SO3 rotation;
  for (std::size_t i = 0; i < order.axes.size(); ++i) {
    const double angle = angles_rad[static_cast<Eigen::Index>(i)];
    if (!std::isfinite(angle))
      throw inputError({"Euler angles", exactText(angle), "three finite angles", ""});
    const SO3 turn = SO3::exp(angle * Eigen::Vector3d::Unit(order.axes[i]));
    rotation = order.is_fixed ? turn * rotation : rotation * turn;
  }
  return rotation;
}

EulerDecomposition eulerFromRotation(const SO3& rotation, const EulerOrder& order) {
  constexpr double kGimbalLockCosine = 1e-8;
  const Eigen::Matrix3d R = rotation.matrix();
  // Turns about fixed axes are those about moving ones in reverse.
  const int i = order.axes[order.is_fixed ? 2 : 0];
  const int j = order.axes[1];
  const int k = order.axes[order.is_fixed ? 0 : 2];
  const int h = 3 - i - j;  // the axis that is neither the first nor the second
  const double sign = (j - i + 3) % 3 == 1 ? 1.0 : -1.0;
  const bool is_proper = i == k;
  // Column k is Ri(first) applied to a vector that depends on the middle angle alone.
  const double off_pole = std::hypot(R(j, k), R(h, k));
  EulerDecomposition result;
  result.gimbal_lock = off_pole < kGimbalLockCosine;
  double first = is_proper ? std::atan2(R(j, k), -sign * R(h, k)) : std::atan2(-sign * R(j, k), R(h, k));
  const double middle = is_proper ? std::atan2(off_pole, R(i, i)) : std::atan2(sign * R(i, k), off_pole);
  double last = 0;
  if (result.gimbal_lock) {
    first = std::atan2(sign * R(h, j), R(j, j));
  } else {
    // Row j of Ri(-first) R has the sine and cosine of the last angle. Those in R would give another angle
    // than the one that belongs to this first one: near the poles each is inaccurate, and only the pair is
    // the rotation.
    const Eigen::RowVector3d row = std::cos(first) * R.row(j) + sign * std::sin(first) * R.row(h);
    last = std::atan2(is_proper ? -sign * row(h) : sign * row(i), row(j));
  }
  result.angles_rad = {first, middle, last};
  if (order.is_fixed) result.angles_rad.reverseInPlace();
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

PoseMean meanPose(std::span<const SE3> poses) {
  const double share = 1.0 / static_cast<double>(poses.size());
  PoseMean result;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const SE3& pose : poses) {
    sum += pose.rotation.matrix();
    result.mean.translation += share * pose.translation;
  }
  // The nearest rotation to the sum is close; the mean turn from there to the poses leads to the Karcher
  // mean.
  result.mean.rotation = bestRotation(sum);
  constexpr int kNumSteps = 30;
  for (int i = 0; i <= kNumSteps; ++i) {
    Eigen::Vector3d step = Eigen::Vector3d::Zero();
    result = {.mean = result.mean};
    for (const SE3& pose : poses) {
      const Eigen::Vector3d turn = (result.mean.rotation.inverse() * pose.rotation).log();
      step += share * turn;
      result.rms_rad += share * turn.squaredNorm();
      result.rms_m += share * (pose.translation - result.mean.translation).squaredNorm();
      result.max_rad = std::max(result.max_rad, turn.norm());
    }
    if (i < kNumSteps) result.mean.rotation = result.mean.rotation * SO3::exp(step);
  }
  result.rms_rad = std::sqrt(result.rms_rad);
  result.rms_m = std::sqrt(result.rms_m);
  return result;
}

}  // namespace alidade
