// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/own_images.h"

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "alidade/geometry/so3.h"

namespace alidade {
namespace {

std::string nameOf(const std::string& image) {
  return std::filesystem::path(image).filename().string();
}

}  // namespace

bool isSameBoardPose(const Checkerboard& board, const SE3& camera_from_board, const SE3& other_from_board) {
  constexpr double kOfDistance = 0.02;
  constexpr double kMaxTurn = 0.02;  // rad
  const Eigen::Vector3d corner_to_middle = board.middle();
  const Eigen::Vector3d middle = camera_from_board * corner_to_middle;
  const Eigen::Vector3d other_middle = other_from_board * corner_to_middle;
  if (!((middle - other_middle).norm() <= kOfDistance * other_middle.norm())) return false;
  constexpr int kQuarters = 4;
  const SO3 turn = camera_from_board.rotation.inverse() * other_from_board.rotation;
  for (const double turned_over : {0.0, std::numbers::pi}) {
    for (int quarter = 0; quarter < kQuarters; ++quarter) {
      const SO3 renumbered = SO3::exp(Eigen::Vector3d(turned_over, 0, 0)) *
                             SO3::exp(Eigen::Vector3d(0, 0, quarter * std::numbers::pi / 2));
      if ((turn * renumbered).log().norm() <= kMaxTurn) return true;
    }
  }
  return false;
}

Diagnosis ownImagesCheck(std::span<const ViewRecord> recorded, const Checkerboard& board,
                         std::span<const HeldOutView> views, int num_given) {
  std::vector<std::string> own;
  for (const HeldOutView& view : views) {
    const bool is_own = view.camera_from_board &&
                        std::any_of(recorded.begin(), recorded.end(), [&](const ViewRecord& record) {
                          return nameOf(record.image) == nameOf(view.image) &&
                                 isSameBoardPose(board, *view.camera_from_board, record.camera_from_board);
                        });
    if (is_own) own.push_back(view.image);
  }
  const bool is_clean = own.empty();
  return {.severity = is_clean ? Severity::kPass : Severity::kWarning,
          .id = "held_out_names",
          .cause = is_clean ? "no image has both the name and the board's pose of one that the camera was "
                              "calibrated from"
                            : "images have the names of the file's own views and show the board where those "
                              "do, such as " +
                                  own.front() +
                                  ": they were fitted and cannot show that the camera is wrong; take others",
          .evidence = fmt::format("{} of {} images", own.size(), num_given),
          .limit = "none with the name and the board's pose of a view of the file's own calibration"};
}

}  // namespace alidade
