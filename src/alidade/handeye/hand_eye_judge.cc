// SPDX-License-Identifier: MIT
#include "alidade/handeye/hand_eye_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/mapped.h"
#include "alidade/core/statistics.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/handeye/next_pose.h"

namespace alidade {
namespace {

constexpr double kMmPerMetre = 1000;

Matrix6d mountCovariance(const RobotFit& fit, const Eigen::MatrixXd& covariance) {
  return covariance.block<6, 6>(fit.numParams(), fit.numParams());
}

// Factor on variances that an estimated noise of the robot costs: Student's t in place of a normal variable,
// with the degrees of freedom of the share of the variance that the robot has (Satterthwaite 1946).
double freedomFactor(const RobotFit& fit) {
  constexpr double kLess = 0.1;
  const auto varianceWith = [&fit](const RobotNoiseShares& shares) {
    return mountCovariance(fit, covarianceWith(fit, shares)).topLeftCorner<3, 3>().trace();
  };
  const double all = varianceWith({});
  const std::array<double, 2> rest = {varianceWith({.translation = kLess}),
                                      varianceWith({.rotation = kLess})};
  double inverse = 0;
  for (std::size_t part : {0U, 1U}) {
    const double share = std::clamp(1 - rest[part] / all, 0.0, 1.0);
    if (share > 0 && fit.noise_freedom[part] > 0) inverse += share * share / fit.noise_freedom[part];
  }
  constexpr double kFewest = 3;
  return inverse > 0 ? std::pow(studentT95(std::max(kFewest, 1 / inverse)) / kNormal95, 2) : 1;
}

// What would improve the answer most.
std::string limitOf(const RobotFit& fit, const Eigen::Vector3d& point) {
  constexpr double kLess = 0.1;
  struct Part {
    std::string_view name;
    RobotNoiseShares shares;
  };
  const std::array<Part, 3> parts = {Part{"the robot", {.translation = kLess, .rotation = kLess}},
                                     Part{"the corners", {.corners = kLess}},
                                     Part{"the lens", {.is_lens_known = true}}};
  const Part* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const Part& part : parts) {
    const double error = errorAt(mountCovariance(fit, covarianceWith(fit, part.shares)), point);
    if (error < least) best = &part, least = error;
  }
  return best == nullptr ? "" : std::string(best->name);
}

void addAccuracy(const RobotFit& fit, const HandEyeOptions& options, HandEyeCalibration& result) {
  const Severity severity = severityOf(result.error_m, options.tolerance_m);
  if (result.error_m <= options.tolerance_m) return;
  const std::string limit = limitOf(fit, {0, 0, result.board_distance_m});
  result.diagnoses.push_back(
      {.id = "hand_eye_inaccurate",
       .severity = std::max(severity, Severity::kWarning),
       .cause = "the transform is not known as well as required",
       .evidence = fmt::format("a point at {:.2g} m is known within {:.1f} mm (95 %), mostly because of {}",
                               result.board_distance_m, kMmPerMetre * result.error_m, limit),
       .limit = fmt::format("{:.3g} mm", kMmPerMetre * options.tolerance_m),
       .next_step = limit == "the robot"
                        ? "take more poses, with turns of 30 to 60 degrees about different axes"
                    : limit == "the lens" ? "calibrate the camera by more images, and give it with --camera"
                                          : "take more or sharper images, nearer to the board"});
}

// The robot and the board measure in the same metres.
void addScale(const RobotFit& fit, const HandEyeOptions& options, HandEyeCalibration& result) {
  constexpr double kSure = 4;  // standard deviations
  const RobotScale scale = robotScale(fit);
  if (!(std::abs(scale.excess) > kSure * scale.std)) return;
  const double effect_m = std::abs(scale.excess) * result.board_distance_m;
  result.diagnoses.push_back(
      {.id = "robot_scale",
       .severity = severityOf(effect_m, options.tolerance_m),
       .cause = fmt::format("by the robot's lengths, the board is {} than stated",
                            scale.excess > 0 ? "smaller" : "larger"),
       .evidence = fmt::format("by {:.2f} +- {:.2f} %, {:.2g} mm at its distance",
                               100 * std::abs(scale.excess), 100 * scale.std, kMmPerMetre * effect_m),
       .next_step = "measure the board, also for --board, and check the unit of the robot's poses"});
}

}  // namespace

void judgeMotion(const ClosedForm& form, HandEyeCalibration& result) {
  constexpr double kLeastTurn = 3 * std::numbers::pi / 180;
  const double turn = std::sqrt(form.rotation_firmness);
  if (turn >= kLeastTurn) return;
  const Eigen::Vector3d& axis = form.main_axis;
  result.diagnoses.push_back(
      {.id = "robot_motion_poor",
       .cause = "the robot hardly turned the camera about more than one axis",
       .evidence = fmt::format(
           "across its main axis ({:.2f}, {:.2f}, {:.2f}) in the camera frame, poses differ by {:.2g} degrees",
           axis.x(), axis.y(), axis.z(), kDegPerRad * turn),
       .limit = fmt::format("{:.2g} degrees", kDegPerRad * kLeastTurn),
       .next_step = "add poses that are turned by 20 degrees or more about an axis across it"});
}

void judgeHandEye(const RobotFit& fit, const std::vector<std::size_t>& left_out,
                  const HandEyeOptions& options, HandEyeCalibration& result) {
  result.fit = fit.fit;
  result.camera_on = fit.camera_on;
  result.mount_from_camera = fit.mount_from_camera;
  result.world_from_boards = fit.world_from_boards;
  const Eigen::Index size = fit.covariance.rows() - fit.numParams();
  const double factor = freedomFactor(fit);
  result.covariance = factor * fit.covariance.bottomRightCorner(size, size);
  result.robot_noise = fit.noise;
  const Matrix6d of_mount = result.covariance.topLeftCorner<6, 6>();
  result.error_m = errorAt(of_mount, {0, 0, result.board_distance_m});
  result.tool_error_m = errorAt(of_mount, fit.mount_from_camera.inverse().translation);
  for (const Diagnosis& diagnosis : result.camera.diagnoses)
    if (diagnosis.severity == Severity::kFailure) result.diagnoses.push_back(diagnosis);
  if (!fit.is_converged)
    result.diagnoses.push_back({.id = "not_converged",
                                .cause = "the joint fit of robot and camera did not converge",
                                .next_step = "check the poses' units and conventions"});
  if (!left_out.empty()) {
    const auto names = mapped(left_out, [&](std::size_t f) { return result.frames[f].image; });
    result.diagnoses.push_back(
        {.id = "robot_poses_left_out",
         .severity = 4 * left_out.size() > fit.frames.size() + left_out.size() ? Severity::kFailure
                                                                               : Severity::kWarning,
         .cause = "some robot poses contradict the others and were left out",
         .evidence = join(names, ", "),
         .next_step = "check these poses; was the robot still when the image was taken?"});
  }
  addScale(fit, options, result);
  addAccuracy(fit, options, result);
  sortDiagnoses(result.diagnoses);
}

}  // namespace alidade
