// SPDX-License-Identifier: MIT
#include "alidade/files/formats/pose_numbers.h"

#include <cmath>

#include <fmt/format.h>

#include "alidade/core/mapped.h"
#include "alidade/files/text/file_text.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade::detail {
namespace {

// Tolerance for typed or shortened numbers; a larger deviation is no rotation or a different convention.
constexpr double kFewDigits = 1e-3;

template <int kRows>
Eigen::Matrix<double, kRows, kRows> readSquare(const YamlNode& node) {
  const auto numbers = mapped(statedNumbers(node, std::size_t{kRows} * kRows), &StatedNumber::value);
  return Eigen::Map<const Eigen::Matrix<double, kRows, kRows, Eigen::RowMajor>>(numbers.data());
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

Eigen::Vector3d translationOf(std::span<const StatedNumber> P) {
  const double z = P[11].value;
  return {(P[3].value - P[2].value * z) / P[0].value, (P[7].value - P[6].value * z) / P[5].value, z};
}

void remarkLongBaseline(const std::string& where, double length, std::vector<Remark>& remarks) {
  constexpr double kLongBaseline = 5;  // m
  if (!(length > kLongBaseline)) return;
  remarks.push_back(
      {"assumed", where + fmt::format(": taken as metres, a baseline of {:.4g} m; many programs write it in "
                                      "the unit of the board's squares",
                                      length)});
}

Eigen::Vector3d readVector(const YamlNode& node) {
  const std::vector<StatedNumber> numbers = statedNumbers(node, 3);
  return {numbers[0].value, numbers[1].value, numbers[2].value};
}

void requireFinite(std::span<const SE3> poses, const CameraSource& cameras) {
  for (const StatedCamera& camera : cameras.cameras) {
    if (camera.number < poses.size() && !poses[camera.number].matrix().allFinite()) {
      throw errorAt("camera " + cameraLabel(camera), "found a pose whose numbers are too large",
                    "a rotation, and a translation in metres");
    }
  }
}

bool statesPair(const CameraDocument& document) {
  return document.isMap() && document.has("R") && document.has("T");
}

SE3 readPair(const YamlNode& root, std::vector<Remark>& remarks) {
  const YamlNode rotation = root.at("R");
  const YamlNode translation = root.at("T");
  const bool is_vector = statedNumbers(rotation).size() == 3;
  const SE3 second_from_first{is_vector ? SO3::exp(readVector(rotation)) : readRotation(rotation, remarks),
                              readVector(translation)};
  remarkLongBaseline(translation.where(), second_from_first.translation.norm(), remarks);
  return second_from_first;
}

std::optional<SE3> readRectification(const YamlNode& root, const std::string& rotation_key,
                                     const std::string& projection_key, std::vector<Remark>& remarks) {
  const auto listed = [&root](const std::string& key, std::size_t count) {
    const auto node = root.find(key);
    return node && !node->isNull() ? statedNumbers(*node, count) : std::vector<StatedNumber>();
  };
  const std::vector<StatedNumber> P = listed(projection_key, 12);
  const std::vector<StatedNumber> R = listed(rotation_key, 9);
  if (P.empty() || R.empty()) return std::nullopt;
  if (areZero(P)) {
    remarks.push_back(
        {"no_pose", root.whereKey(projection_key) +
                        ": only zeros, as from drivers that do not know it, so no pose is read"});
  }
  if (!(P[0].value > 0 && P[5].value > 0)) return std::nullopt;
  if (areZero(R)) {
    const double baseline = std::hypot(P[3].value / P[0].value, P[7].value / P[5].value);
    remarks.push_back(
        {"no_pose",
         root.whereKey(rotation_key) +
             ": only zeros, as from drivers whose images are already rectified, so no pose is read; "
             "if they are, write the identity (1 0 0 0 1 0 0 0 1)" +
             (baseline > 0 ? fmt::format("; {} states a baseline of {:.4g} m", projection_key, baseline)
                           : fmt::format("; {} of the other camera states the baseline", projection_key))});
    return std::nullopt;
  }
  const Eigen::Vector3d rectified_from_rig = translationOf(P);
  const SO3 camera_from_rectified = readRotation(root.at(rotation_key), remarks).inverse();
  return SE3(camera_from_rectified, camera_from_rectified * rectified_from_rig);
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
  const auto numbers = matrix.reshaped<Eigen::RowMajor>();
  return {numbers.begin(), numbers.end()};
}

}  // namespace alidade::detail
