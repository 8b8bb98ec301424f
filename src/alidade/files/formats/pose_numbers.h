// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/error.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/lens_numbers.h"
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

/// t of a projection K [I t], 3x4 row by row.
[[nodiscard]] Eigen::Vector3d translationOf(std::span<const StatedNumber> P);

/// Adds a remark if cameras this far apart (m) are unusual: the unit may be another one.
void remarkLongBaseline(const std::string& where, double length, std::vector<Remark>& remarks);

/// Reads three numbers.
[[nodiscard]] Eigen::Vector3d readVector(const YamlNode& node);

/// True if the file holds results of cv::stereoCalibrate(): R and T. The cameras may be in the same file, or
/// in a separate one as the sample stereo_calib writes them.
[[nodiscard]] bool statesPair(const CameraDocument& document);

/// second_from_first: X2 = R X1 + T. R is a rotation matrix or a rotation vector. T is in the unit of the
/// board, which no file states; metres are assumed, with a remark if it is longer than usual for rigs.
/// @throws Error (kInput) with the place
[[nodiscard]] SE3 readPair(const YamlNode& root, std::vector<Remark>& remarks);

/// camera_from_rig of a camera that states how it is rectified (sensor_msgs/CameraInfo): R maps directions of
/// the camera to the rectified frame, which all cameras of a rig share, and P = K' [I t] projects points in
/// the rectified frame of the first camera, which is the rig's frame. Nothing, with a remark (no_pose), if a
/// driver wrote zeros for one of the two.
[[nodiscard]] std::optional<SE3> readRectification(const YamlNode& root, const std::string& rotation_key,
                                                   const std::string& projection_key,
                                                   std::vector<Remark>& remarks);

/// @throws Error (kInput), naming the camera, if large numbers made a pose overflow
void requireFinite(std::span<const SE3> poses, const CameraSource& cameras);

/// Assigns the poses that `read` returns, camera_from_rig by number, or none. The lens is usable even if a
/// pose is damaged, so errors of `read` become a remark (bad_pose), and no camera gets a pose. `read` takes a
/// list of remarks to append to.
template <class Read>
void statePoses(CameraSource& all, const Read& read) {
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
