// SPDX-License-Identifier: MIT
#include "alidade/files/formats/pose_numbers.h"

#include "alidade/files/formats/lens_numbers.h"
#include "alidade/files/text/file_text.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade::detail {
namespace {

// Tolerance for typed or shortened numbers; a larger deviation is no rotation or a different convention.
constexpr double kFewDigits = 1e-3;

template <int kRows>
Eigen::Matrix<double, kRows, kRows> readSquare(const YamlNode& node) {
  const std::vector<StatedNumber> numbers = statedNumbers(node, static_cast<std::size_t>(kRows) * kRows);
  Eigen::Matrix<double, kRows, kRows> matrix;
  for (int i = 0; i < kRows * kRows; ++i)
    matrix(i / kRows, i % kRows) = numbers[static_cast<std::size_t>(i)].value;
  return matrix;
}

SO3 nearestRotation(const Eigen::Matrix3d& R, const YamlNode& node, std::vector<Remark>& remarks) {
  try {
    return rotationFromMatrix(R);
  } catch (const Error&) {
    SO3 rotation = withPlace(node.where(), [&] { return rotationFromMatrix(R, kFewDigits); });
    remarks.push_back({"assumed", node.where() +
                                      ": the matrix is a rotation only to about three decimals; the nearest "
                                      "rotation is used"});
    return rotation;
  }
}

}  // namespace

SO3 readRotation(const YamlNode& node, std::vector<Remark>& remarks) {
  return nearestRotation(readSquare<3>(node), node, remarks);
}

SE3 readMotion(const YamlNode& node, std::vector<Remark>& remarks) {
  const Eigen::Matrix4d matrix = readSquare<4>(node);
  constexpr double kRounding = 1e-6;
  if (!((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() <= kRounding)) {
    throw node.error("a last row other than 0 0 0 1", "a matrix [R t; 0 0 0 1]",
                     "write it row by row, not column by column");
  }
  return {nearestRotation(matrix.topLeftCorner<3, 3>(), node, remarks), matrix.topRightCorner<3, 1>()};
}

Eigen::Vector3d readVector(const YamlNode& node) {
  const std::vector<StatedNumber> numbers = statedNumbers(node, 3);
  return {numbers[0].value, numbers[1].value, numbers[2].value};
}

void requireFinite(std::span<const SE3> poses, const StatedCameras& cameras) {
  for (const StatedCamera& camera : cameras.cameras) {
    if (camera.number < poses.size() && !poses[camera.number].matrix().allFinite()) {
      throw inputError(
          {.where = "camera " + (camera.name.empty() ? std::to_string(camera.number) : camera.name),
           .found = "found a pose whose numbers are too large",
           .expected = "a rotation, and a translation in metres"});
    }
  }
}

std::vector<SE3> posesOf(std::span<const NamedCamera> cameras) {
  std::vector<SE3> poses;
  for (const NamedCamera& camera : cameras) {
    if (!camera.camera_from_rig) return {};
    poses.push_back(*camera.camera_from_rig);
  }
  return poses;
}

std::vector<SE3> posesFromFirst(std::span<const NamedCamera> cameras) {
  std::vector<SE3> poses = posesOf(cameras);
  if (poses.empty()) return poses;
  const SE3 rig_from_first = poses.front().inverse();
  for (SE3& pose : poses) pose = pose * rig_from_first;
  poses.front() = SE3();
  return poses;
}

std::vector<double> rowMajor(const Eigen::MatrixXd& matrix) {
  std::vector<double> numbers;
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) numbers.push_back(matrix(row, column));
  }
  return numbers;
}

}  // namespace alidade::detail
