// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/error.h"
#include "alidade/files/formats/stated_camera.h"
#include "alidade/files/text/yaml_node.h"
#include "alidade/geometry/se3.h"

// Reads and writes camera poses in the notations of other programs.
namespace alidade::detail {

/// A rotation matrix, 3x3 (rows, nine numbers, or {rows, cols, data}). A matrix with few digits, such as
/// three decimals, is replaced by the nearest rotation, with a remark. @throws Error (kInput) if it is not a
/// rotation
[[nodiscard]] SO3 readRotation(const YamlNode& node, std::vector<Remark>& remarks);

/// [R t; 0 0 0 1], 4x4 in the same notations.
[[nodiscard]] SE3 readMotion(const YamlNode& node, std::vector<Remark>& remarks);

/// Reads three numbers.
[[nodiscard]] Eigen::Vector3d readVector(const YamlNode& node);

/// @throws Error (kInput), naming the camera, if large numbers made a pose overflow
void requireFinite(std::span<const SE3> poses, const StatedCameras& cameras);

/// Assigns the poses that `read` returns, camera_from_rig by number, or none. The lens is usable even if a
/// pose is damaged, so errors of `read` become a remark (bad_pose), and no camera gets a pose. `read` takes a
/// list of remarks to append to.
template <class Read>
void statePoses(StatedCameras& all, const Read& read) {
  std::vector<Remark> remarks;
  try {
    const std::vector<SE3> poses = read(remarks);
    requireFinite(poses, all);
    for (StatedCamera& camera : all.cameras) {
      if (!poses.empty()) camera.camera_from_rig = poses.at(camera.number);
    }
  } catch (const Error& e) {
    if (e.code() != ErrorCode::kInput) throw;
    remarks.push_back({"bad_pose", e.what()});
  }
  if (all.cameras.empty()) return;
  std::vector<Remark>& told = all.cameras.front().remarks;
  told.insert(told.end(), remarks.begin(), remarks.end());
}

/// The poses of cameras to write; empty if they have none.
[[nodiscard]] std::vector<SE3> posesOf(std::span<const NamedCamera> cameras);

/// The same relative to the first camera: camera_from_first.
[[nodiscard]] std::vector<SE3> posesFromFirst(std::span<const NamedCamera> cameras);

/// The numbers of a matrix, row by row.
[[nodiscard]] std::vector<double> rowMajor(const Eigen::MatrixXd& matrix);

}  // namespace alidade::detail
