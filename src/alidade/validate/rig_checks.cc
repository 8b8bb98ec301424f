// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/text.h"
#include "alidade/files/rig_file.h"
#include "alidade/record/correlations.h"
#include "alidade/record/rig_record.h"
#include "alidade/validate/camera_checks.h"

namespace alidade {
namespace {

const std::string& nameOf(const RigRecord& rig, std::size_t camera) {
  return rig.cameras[camera].camera.name.name;
}

// Detects lengths in millimetres, the commonest slip: no rig is as large as a street.
FileCheck checkExtent(const RigRecord& rig) {
  constexpr double kLargest = 30;  // m
  double extent_m = 0;
  std::string pair;
  for (std::size_t a = 0; a < rig.cameras.size(); ++a) {
    const SE3 rig_from_a = rig.cameras[a].camera_from_rig.inverse();
    for (std::size_t b = 0; b < a; ++b) {
      const double distance_m = (rig.cameras[b].camera_from_rig * rig_from_a).translation.norm();
      if (!(distance_m > extent_m)) continue;
      extent_m = distance_m;
      pair = nameOf(rig, b) + " and " + nameOf(rig, a);
    }
  }
  const bool is_huge = !(extent_m <= kLargest);
  std::string message =
      extent_m == 0 ? "all cameras are at one place" : fmt::format("{} are {:.5g} m apart", pair, extent_m);
  if (rig.cameras.size() > 2 && extent_m > 0) message += ", farther than all others";
  if (is_huge) message += fmt::format("; limit: {} m (are the lengths in metres?)", kLargest);
  return {.severity = is_huge ? Severity::kWarning : Severity::kPass,
          .id = "extent",
          .message = std::move(message),
          .values = {{"extent_m", extent_m}}};
}

// Two cameras with the same view from one place indicate a pose that was copied or never filled in.
FileCheck checkSamePose(const RigRecord& rig) {
  constexpr double kSame = 1e-9;  // m, rad
  std::vector<std::string> pairs;
  for (std::size_t a = 0; a < rig.cameras.size(); ++a) {
    const SE3 rig_from_a = rig.cameras[a].camera_from_rig.inverse();
    for (std::size_t b = 0; b < a && pairs.size() < 3; ++b) {
      const SE3 b_from_a = rig.cameras[b].camera_from_rig * rig_from_a;
      if (b_from_a.translation.norm() < kSame && b_from_a.rotation.log().norm() < kSame)
        pairs.push_back(nameOf(rig, b) + " and " + nameOf(rig, a));
    }
  }
  if (pairs.empty())
    return {.severity = Severity::kPass, .id = "poses", .message = "no two cameras have the same pose"};
  return {.severity = Severity::kWarning,
          .id = "poses",
          .message = "the same pose: " + join(pairs, "; ") + " (was a pose copied, or never filled in?)"};
}

// A point must have one row (or column, for cameras above each other) in both rectified images, or no stereo
// program finds matches. Both files state the camera of these images.
FileCheck checkRows(const StatedCamera& a, const StatedCamera& b) {
  constexpr double kLimitPx = 0.1;
  const Eigen::Vector3d baseline = (*b.camera_from_rig * a.camera_from_rig->inverse()).translation;
  const int across = std::abs(baseline.x()) >= std::abs(baseline.y()) ? 1 : 0;
  const double focal_px = std::abs((*a.rectified_focal)(across) - (*b.rectified_focal)(across));
  const double centre_px = std::abs((*a.rectified_center)(across) - (*b.rectified_center)(across));
  const double off_px = std::max(focal_px, centre_px);
  const bool is_off = !(off_px <= kLimitPx);
  return {.severity = is_off ? Severity::kFailure : Severity::kPass,
          .id = "rows",
          .message =
              is_off ? fmt::format("the rectified images have different {}: the projection matrices "
                                   "differ by {:.3g} px; limit {} px (are both files of one pair?)",
                                   across == 1 ? "rows" : "columns", off_px, kLimitPx)
                     : fmt::format("the rectified images share their {}", across == 1 ? "rows" : "columns"),
          .values = {{"difference_px", off_px}}};
}

FileCheck checkRigVerdict(const RigRecord& rig) {
  std::string message =
      fmt::format("the verdict was {} with {} frames", verdictName(rig.verdict), rig.num_frames);
  if (!rig.findings.empty()) message += ": " + join(rig.findings, ", ");
  if (rig.verdict == Verdict::kNo) message += "; the rig must not be used";
  return verdictCheck("rig_calibration", rig.verdict, std::move(message));
}

// Checks a stated covariance, whose last rows are the poses of all cameras but the first.
FileCheck checkJointCovariance(const RigRecord& rig) {
  constexpr double kStdShare = 1e-6;
  Eigen::Index at = 0;
  for (const RigCameraRecord& camera : rig.cameras)
    at += static_cast<Eigen::Index>(camera.camera.camera.parameters().size());
  const Correlations correlations(rig.covariance,
                                  at + 6 * (static_cast<Eigen::Index>(rig.cameras.size()) - 1));
  bool is_consistent = true;
  for (std::size_t i = 1; i < rig.cameras.size(); ++i, at += 6) {
    Eigen::Matrix<double, 6, 1> stated;
    stated << rig.cameras[i].translation_std_m, rig.cameras[i].rotation_std_rad;
    const Eigen::Matrix<double, 6, 1> expected = correlations.std.segment<6>(at);
    is_consistent = is_consistent && (stated - expected).norm() <= kStdShare * expected.norm();
  }
  return covarianceCheck("rig_covariance", "the covariance of the rig", correlations.isSemidefinite(),
                         is_consistent, "camera_from_rig_std");
}

}  // namespace

std::vector<FileCheck> checkRig(const CameraSource& source) {
  const bool is_rig = source.cameras.size() > 1 && source.refused.empty() &&
                      std::ranges::all_of(source.cameras, [](const StatedCamera& camera) {
                        return camera.camera_from_rig.has_value();
                      });
  if (!is_rig) return {};
  CameraSource sized = source;  // files of other tools need no image size
  for (StatedCamera& camera : sized.cameras) {
    if (!camera.image_size) camera.image_size = sizeAround(camera.camera);
  }
  const RigRecord rig = rigOf(sized);
  std::vector<FileCheck> checks = {checkExtent(rig), checkSamePose(rig)};
  if (!rig.covariance.empty()) checks.push_back(checkJointCovariance(rig));
  if (rig.isCalibrated()) checks.push_back(checkRigVerdict(rig));
  const auto hasRows = [](const StatedCamera& camera) {
    return camera.rectified_center.has_value() && camera.rectified_focal.has_value();
  };
  if (source.cameras.size() == 2 && std::ranges::all_of(source.cameras, hasRows))
    checks.push_back(checkRows(source.cameras[0], source.cameras[1]));
  return checks;
}

}  // namespace alidade
