// SPDX-License-Identifier: MIT
#include "alidade/files/trajectory_file.h"

#include <iterator>

#include <fmt/format.h>

#include "alidade/core/error_text.h"

namespace alidade {

std::string trajectoryText(std::span<const std::string> comments, std::span<const TrajectoryPiece> pieces) {
  std::string text;
  for (const std::string& comment : comments) text += "# " + oneLine(comment) + "\n";
  // Right above the first row, where readers look for the names of columns.
  constexpr const char* kColumns = "# timestamp tx ty tz qx qy qz qw\n";
  for (const TrajectoryPiece& piece : pieces) {
    for (const std::string& comment : piece.comments) text += "# " + oneLine(comment) + "\n";
    if (&piece == pieces.data()) text += kColumns;
    for (const TimedPose& pose : piece.poses) {
      const SE3 world_from_camera = pose.camera_from_world.inverse();
      const Eigen::Vector3d& t = world_from_camera.translation;
      Eigen::Vector4d q = world_from_camera.rotation.quaternion().coeffs();
      if (q.w() < 0) q = -q;
      fmt::format_to(std::back_inserter(text), "{:.6f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                     pose.time, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
    }
  }
  return text;
}

std::string pointCloudText(std::span<const std::string> comments,
                           std::span<const std::vector<Eigen::Vector3d>> pieces) {
  std::size_t count = 0;
  for (const auto& points : pieces) count += points.size();
  std::string text = "ply\nformat ascii 1.0\n";
  for (const std::string& comment : comments) text += "comment " + oneLine(comment) + "\n";
  text += fmt::format(
      "element vertex {}\nproperty double x\nproperty double y\nproperty double z\nproperty int piece\n"
      "end_header\n",
      count);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (const Eigen::Vector3d& p : pieces[i])
      fmt::format_to(std::back_inserter(text), "{:.9g} {:.9g} {:.9g} {}\n", p.x(), p.y(), p.z(), i + 1);
  }
  return text;
}

}  // namespace alidade
