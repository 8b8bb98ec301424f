// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/files/rig_file.h"
#include "alidade/record/rig_record.h"

namespace alidade {

/// A rig of an ordinary lens and a fisheye, 0.12 m apart and turned against each other, with a covariance of
/// half a pixel for focal lengths and principal points, and 1 mm and 1 mrad for the pose.
inline RigRecord pairOfCameras() {
  const auto entry = [](const std::string& name, std::string_view model, const std::vector<double>& params,
                        const SE3& camera_from_rig) {
    CameraRecord record = bareRecord(AnyCamera::make(model, params), {640, 480}, "a test");
    record.name.name = name;
    return RigCameraRecord{.camera = record, .camera_from_rig = camera_from_rig};
  };
  const SE3 turned{SO3::exp(Eigen::Vector3d(0.02, -0.05, 0.03)), Eigen::Vector3d(-0.12, 0.004, 0.002)};
  RigRecord rig;
  rig.cameras = {entry("left", "radtan", {520, 522, 318, 241, -0.2, 0.05, 1e-3, -5e-4, 0}, {}),
                 entry("right", "kannala_brandt", {300, 301, 322, 239, 0.01, -0.002, 0, 0}, turned)};
  Eigen::VectorXd variances = Eigen::VectorXd::Constant(9 + 8 + 6, 1e-6);
  for (const Eigen::Index start : {0, 9}) {
    variances.segment(start, 4).setConstant(0.25);
    variances.segment(start + 4, start == 0 ? 5 : 4).setConstant(1e-8);
  }
  rig.covariance = lowerTriangle(variances.asDiagonal().toDenseMatrix());
  rig.created_by = "a test";
  return rig;
}

}  // namespace alidade
