// SPDX-License-Identifier: MIT
#include "alidade/files/text/pose_forms.h"

#include <numbers>
#include <string_view>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade {
namespace {

// The numbers of a pose in every way. Where each begins:
enum Place {
  kQuaternion = 0,
  kTranslation = 4,
  kVector = 7,
  kAxis = 10,
  kEuler = 14,
  kMatrix = 17,
  kEnd = 33
};
using AllNumbers = Eigen::Matrix<double, kEnd, 1>;

// Places of a 4x4 matrix, row by row.
const std::vector<int> kMatrixPlaces = {17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32};
const std::vector<int> kEulerPlaces = {14, 15, 16};
constexpr const char* kEulerHelp =
    "yaw, pitch, roll: about z, the new y, the new x. Other orders: euler_xyz_rad, euler_zxz_deg, ...;\n"
    "    about axes that stay: euler_fixed_xyz_rad (roll, pitch, yaw; URDF's rpy), ...";

// Radians per unit of the angles.
double unitOf(const std::string& name) {
  return name.ends_with("_deg") ? std::numbers::pi / 180 : 1.0;
}

// "euler_zyx_deg", "euler_fixed_xyz_rad"; nothing for other names.
std::optional<EulerOrder> orderIn(std::string_view name) {
  if (!name.ends_with("_deg") && !name.ends_with("_rad")) return std::nullopt;
  name.remove_suffix(4);
  for (const std::string_view prefix : {"euler_fixed_", "euler_"}) {
    if (name.starts_with(prefix)) return eulerOrder(name.substr(prefix.size()), prefix != "euler_");
  }
  return std::nullopt;
}

SO3 rotationOf(const AllNumbers& all, int last, const std::string& name) {
  const Eigen::Vector3d axis = all.segment<3>(kAxis);
  if (last >= kEuler) return rotationFromEuler(all.segment<3>(kEuler), orderIn(name).value());
  if (last >= kAxis && all[last] != 0 && axis.isZero(0))
    throw inputError({"rotation axis", "0, 0, 0", "a direction", ""});
  if (last >= kAxis) return SO3::exp(all[last] * axis.stableNormalized());
  if (last >= kVector) return SO3::exp(all.segment<3>(kVector));
  return SO3::fromQuaternion({all[3], all[0], all[1], all[2]});
}

}  // namespace

NamedPose PoseForm::read(std::span<const double> numbers) const {
  expect(numbers.size() == places.size(), "one number per place");
  AllNumbers all = AllNumbers::Zero();
  for (const int place : {17, 22, 27, 32}) all[place] = 1;  // the diagonal of the matrix
  for (std::size_t i = 0; i < places.size(); ++i)
    all[places[i]] = numbers[i] * (i + num_angles < places.size() ? 1.0 : unitOf(name));
  const int last = places.back();
  NamedPose pose{.has_translation = hasTranslation()};
  if (last >= kMatrix) {
    pose.stated = motionFromMatrix(all.tail<16>().reshaped(4, 4).transpose());
  } else {
    pose.stated = {rotationOf(all, last, name), all.segment<3>(kTranslation)};
  }
  if (last < kTranslation) pose.quaternion_length = all.head<4>().stableNorm();
  return pose;
}

std::vector<double> PoseForm::write(const SE3& pose, bool& gimbal_lock) const {
  const Eigen::Vector3d vector = pose.rotation.log();
  const double angle = vector.stableNorm();
  const Eigen::Vector3d axis = angle > 0 ? Eigen::Vector3d(vector / angle) : Eigen::Vector3d::UnitZ();
  const auto euler = eulerFromRotation(pose.rotation, orderIn(name).value_or(EulerOrder()));
  gimbal_lock = gimbal_lock || (orderIn(name) && euler.gimbal_lock);
  AllNumbers all;
  all << quaternionXyzw(pose.rotation), pose.translation, vector, axis, angle, euler.angles_rad,
      pose.matrix().transpose().reshaped();
  std::vector<double> numbers;
  for (std::size_t i = 0; i < places.size(); ++i)  // 0 is added to have no -0
    numbers.push_back(all[places[i]] / (i + num_angles < places.size() ? 1.0 : unitOf(name)) + 0.0);
  return numbers;
}

const std::vector<PoseForm>& poseForms() {
  static const std::vector<PoseForm> kForms = {
      {"quaternion_xyzw", {0, 1, 2, 3}, 0, "w last (ROS, SciPy, TUM); written with w >= 0"},
      {"quaternion_wxyz", {3, 0, 1, 2}, 0, "w first (COLMAP, MuJoCo, Eigen's constructor)"},
      {"rotation_vector_rad", {7, 8, 9}, 3, "axis times angle, as OpenCV's rvec"},
      {"rotation_vector_deg", {7, 8, 9}, 3, "the same in degrees"},
      {"axis_angle_rad", {10, 11, 12, 13}, 1, "the axis x, y, z of any length, then the angle"},
      {"axis_angle_deg", {10, 11, 12, 13}, 1, "the same in degrees"},
      {"euler_zyx_rad", kEulerPlaces, 3, kEulerHelp},
      {"euler_zyx_deg", kEulerPlaces, 3, "the same in degrees"},
      {"rotation_matrix", {17, 18, 19, 21, 22, 23, 25, 26, 27}, 0, "3x3, row by row"},
      {"matrix", kMatrixPlaces, 0, "4x4, row by row: [R t; 0 0 0 1]"},
      {"matrix_3x4", {kMatrixPlaces.begin(), kMatrixPlaces.end() - 4}, 0, "3x4, row by row: [R t]"},
      {"xyz_xyzw", {4, 5, 6, 0, 1, 2, 3}, 0, "translation, then quaternion, as ROS tools print transforms"},
  };
  return kForms;
}

std::optional<PoseForm> findPoseForm(const std::string& name) {
  for (PoseForm form : poseForms()) {
    if (form.name != name && !(form.places == kEulerPlaces && orderIn(name))) continue;
    form.name = name;
    return form;
  }
  return std::nullopt;
}

std::string poseFormAdvice(const std::string& name) {
  if (findPoseForm(name + "_deg"))
    return "write " + name + "_deg for degrees or " + name + "_rad for radians";
  return didYouMean(name, mapped(poseForms(), &PoseForm::name), "alidade pose --help lists all forms");
}

}  // namespace alidade
