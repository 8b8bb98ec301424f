// SPDX-License-Identifier: MIT
#include "alidade/validate/camera_checks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/image_domain.h"
#include "alidade/camera/model_traits.h"
#include "alidade/camera/pole.h"
#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/record/correlations.h"

namespace alidade {
namespace {

// Focal lengths as a share of the image's long side, for perspective fields of view of 170 and 0.2 degrees.
constexpr double kMinFocalShare = 0.04;
constexpr double kMaxFocalShare = 300;
// For a file without an image size. Smaller focal lengths are in mm or relative to the image.
constexpr double kMinFocalPx = 5;
constexpr double kAspectWarn = 1.1;  // analogue video: 1.09
constexpr double kAspectFail = 1.5;
// Distances from the image centre, as a share of the side.
constexpr double kOffCentre = 0.15;  // rarely exceeded by an uncropped image
constexpr double kOffSeen = 0.08;    // worth a note, and enough if swapped or scaled numbers explain it
constexpr double kScaleTolerance = 0.1;
// Real lenses move the image corner by decentring by at most this share of its distance from the centre: no
// set in docs/real_data.md exceeds 0.4 %.
constexpr double kTangentialWarn = 0.02;
constexpr double kTangentialFail = 0.1;
constexpr double kTangentialUsual = 0.005;
// Share of the pixels that may lie beyond a fold: image corners where no board was.
constexpr double kMaxFolded = 0.01;

// Offset from the image centre, as shares of the sides.
Eigen::Vector2d offsetOf(double cx, double cy, ImageSize size) {
  return {(cx + 0.5) / size.width - 0.5, (cy + 0.5) / size.height - 0.5};
}

double worstOf(const Eigen::Vector2d& offset) {
  return offset.cwiseAbs().maxCoeff();
}

bool fitsOnlySwapped(const Eigen::Vector2d& center, ImageSize size) {
  const double here = worstOf(offsetOf(center.x(), center.y(), size));
  const double swapped = worstOf(offsetOf(center.y(), center.x(), size));
  return here > kOffSeen && swapped <= kOffSeen && swapped < 0.5 * here;
}

// True if both coordinates are the same share of the sides, but not one half.
bool fitsOtherSize(const Eigen::Vector2d& offset) {
  if (offset.cwiseAbs().minCoeff() <= kOffSeen || offset.x() * offset.y() < 0) return false;
  const double scale = 1 + offset.sum();
  return std::abs(offset.x() - offset.y()) <= kScaleTolerance * scale;
}

// Largest displacement of an image corner by p1 and p2, as a share of its distance from the centre.
double decentringShare(std::span<const double> parameters, double p1, double p2, ImageSize size) {
  const double x = std::max(parameters[2] + 0.5, size.width - 0.5 - parameters[2]) / parameters[0];
  const double y = std::max(parameters[3] + 0.5, size.height - 0.5 - parameters[3]) / parameters[1];
  const double r2 = x * x + y * y;
  const double dx = 2 * std::abs(p1) * x * y + std::abs(p2) * (r2 + 2 * x * x);
  const double dy = std::abs(p1) * (r2 + 2 * y * y) + 2 * std::abs(p2) * x * y;
  return std::hypot(dx, dy) / std::sqrt(r2);
}

// Share of a grid of pixels that have a ray.
double rayShare(const AnyCamera& camera, ImageSize size) {
  constexpr int kColumns = 160;
  constexpr int kRows = 120;
  int num_seen = 0;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const Eigen::Vector2d pixel((i + 0.5) * size.width / kColumns - 0.5,
                                  (j + 0.5) * size.height / kRows - 0.5);
      num_seen += camera.unproject(pixel) ? 1 : 0;
    }
  }
  return static_cast<double>(num_seen) / (kColumns * kRows);
}

// Checks that the focal lengths are possible for the image size: a field of view between 0.2 and 170 degrees.
FileCheck checkFocalLength(const CameraRecord& record, bool is_size_guessed) {
  const auto params = record.camera.parameters();
  const double side = std::max(record.image_size.width, record.image_size.height);
  const double min_px =
      is_size_guessed ? std::max(kMinFocalPx, kMinFocalShare * side) : kMinFocalShare * side;
  const double max_px = kMaxFocalShare * side;
  const bool is_possible =
      std::min(params[0], params[1]) >= min_px && std::max(params[0], params[1]) <= max_px;
  const std::string image = is_size_guessed ? "any image" : sizeText(record.image_size) + " px";
  std::string message = fmt::format("fx {:.6g}, fy {:.6g} px", params[0], params[1]);
  if (!is_possible) {
    message += fmt::format(": impossible for {}; limits {:.4g} to {:.4g} px. Are the numbers in pixels?",
                           image, min_px, max_px);
  }
  return {.severity = is_possible ? Severity::kPass : Severity::kFailure,
          .id = "focal_length",
          .message = std::move(message),
          .values = {{"fx_px", params[0]}, {"fy_px", params[1]}, {"min_px", min_px}, {"max_px", max_px}}};
}

// Checks that pixels are about square.
FileCheck checkAspect(const CameraRecord& record) {
  const auto params = record.camera.parameters();
  const double aspect = std::max(params[0] / params[1], params[1] / params[0]);
  const Severity severity = aspect <= kAspectWarn   ? Severity::kPass
                            : aspect <= kAspectFail ? Severity::kWarning
                                                    : Severity::kFailure;
  std::string message = fmt::format("fx / fy is {:.6g}", params[0] / params[1]);
  if (severity != Severity::kPass) {
    message += fmt::format("; limits 1 / {0} to {0}. Almost all sensors have square pixels",
                           severity == Severity::kWarning ? kAspectWarn : kAspectFail);
  }
  return {.severity = severity,
          .id = "aspect",
          .message = std::move(message),
          .values = {
              {"fx_over_fy", params[0] / params[1]}, {"warning_limit", kAspectWarn}, {"limit", kAspectFail}}};
}

// Checks that the principal point fits the image: it must lie inside, and must not fit only with cx and cy
// swapped or only an image of a different size.
FileCheck checkPrincipalPoint(const CameraRecord& record, bool is_proven) {
  const auto params = record.camera.parameters();
  const ImageSize size = record.image_size;
  const Eigen::Vector2d offset = offsetOf(params[2], params[3], size);
  const double off = worstOf(offset);
  FileCheck check{
      .severity = Severity::kPass,
      .id = "principal_point",
      .message =
          fmt::format("cx {:.6g}, cy {:.6g} px in an image of {}", params[2], params[3], sizeText(size)),
      .values = {{"cx_px", params[2]}, {"cy_px", params[3]}, {"offset_share", off}, {"limit", kOffCentre}}};
  const auto end = [&](Severity severity, const std::string& reason) {
    check.severity = severity;
    check.message += reason;
    return check;
  };
  if (fitsOnlySwapped({params[2], params[3]}, size))
    return end(Severity::kFailure, ": fits only if cx and cy, or width and height, are swapped");
  if (!is_proven && fitsOtherSize(offset)) {
    return end(Severity::kFailure,
               fmt::format(": fits an image of about {:.0f}x{:.0f}. Was the image resized?",
                           std::abs(2 * params[2] + 1), std::abs(2 * params[3] + 1)));
  }
  const std::string percent = fmt::format("{:.0f} % of the side", 100 * kOffCentre);
  if (off > 0.5) {
    return end(is_proven ? Severity::kNote : Severity::kFailure,
               ": outside the image. Was the image cropped?");
  }
  if (offset.cwiseAbs().minCoeff() > kOffCentre) {
    return end(
        is_proven ? Severity::kNote : Severity::kFailure,
        ": too far from the centre in both directions; limit " + percent + ". Is the image size right?");
  }
  if (off <= kOffSeen || (is_proven && off <= kOffCentre)) return check;
  // The size that has it in its centre, of the sides along which it is off; sensors have even sides.
  const auto fitting = [](double share, int side) {
    return std::abs(share) > kOffSeen ? 2 * std::lround((0.5 + std::abs(share)) * side) : side;
  };
  return end(
      off > kOffCentre && !is_proven ? Severity::kWarning : Severity::kNote,
      fmt::format(": {:.0f} % of the side from the centre; limit {}. Was the image cropped, from about "
                  "{}x{}?",
                  100 * off, percent, fitting(offset.x(), size.width), fitting(offset.y(), size.height)));
}

// Compares the principal point with that of the rectified images, px, which ROS files also state.
FileCheck checkProjectionMatrix(const CameraRecord& record, const Eigen::Vector2d& rectified_center) {
  constexpr double kFarShare = 0.05;  // of the long side
  const auto params = record.camera.parameters();
  const double side = std::max(record.image_size.width, record.image_size.height);
  const double here = (Eigen::Vector2d(params[2], params[3]) - rectified_center).norm();
  const double swapped = (Eigen::Vector2d(params[3], params[2]) - rectified_center).norm();
  const bool is_swapped = here > kFarShare * side && swapped < 0.25 * here;
  std::string message = fmt::format("cx {:.6g}, cy {:.6g} px in the projection matrix", rectified_center.x(),
                                    rectified_center.y());
  if (is_swapped) {
    message += fmt::format(
        " fits cx {:.6g}, cy {:.6g} px in the camera matrix only if one of the two has cx and cy swapped",
        params[2], params[3]);
  }
  return {.severity = is_swapped ? Severity::kFailure : Severity::kPass,
          .id = "projection_matrix",
          .message = std::move(message),
          .values = {{"projection_cx_px", rectified_center.x()},
                     {"projection_cy_px", rectified_center.y()},
                     {"difference_px", here},
                     {"difference_swapped_px", swapped}}};
}

// Checks that p1 and p2 are possible; std::nullopt for models without them.
std::optional<FileCheck> checkTangential(const CameraRecord& record) {
  const auto names = record.camera.parameterNames();
  const std::span<const double> params = record.camera.parameters();
  const bool is_perspective = modelTraits(record.camera.modelId()).family == LensFamily::kPerspective;
  if (!is_perspective || !parameterIndex(names, "p1")) return std::nullopt;
  const auto named = [&](std::string_view name) {
    const auto i = parameterIndex(names, name);
    return i ? params[*i] : 0.0;
  };
  const double share = decentringShare(params, named("p1"), named("p2"), record.image_size);
  // For the order k1 k2 k3 p1 p2.
  const bool is_reordered =
      share > kTangentialWarn && named("k3") != 0 &&
      decentringShare(params, named("p2"), named("k3"), record.image_size) <= kTangentialUsual;
  const Severity severity = share <= kTangentialWarn                  ? Severity::kPass
                            : share > kTangentialFail || is_reordered ? Severity::kFailure
                                                                      : Severity::kWarning;
  std::string message = fmt::format("p1 and p2 move the image corner by {:.3g} %", 100 * share);
  if (severity != Severity::kPass) {
    message += fmt::format("; limit {:.3g} %, real lenses stay below {:.2g} %. {}", 100 * kTangentialWarn,
                           100 * kTangentialUsual,
                           is_reordered ? "Is the order in the file k1 k2 k3 p1 p2?"
                                        : "Are the coefficients in the right order, and for this model?");
  }
  return FileCheck{
      .severity = severity,
      .id = "tangential",
      .message = std::move(message),
      .values = {
          {"corner_shift_share", share}, {"warning_limit", kTangentialWarn}, {"limit", kTangentialFail}}};
}

// True if the left and the right edge of the image have no ray at the height of the principal point;
// otherwise only corners lack one, or one side.
bool foldsBeforeEdge(const CameraRecord& record) {
  const double cy = record.camera.parameters()[3];
  return !record.camera.unproject({-0.5, cy}) &&
         !record.camera.unproject({record.image_size.width - 0.5, cy});
}

// Adds whether a pole lies just outside an image of which each pixel has a ray. Programs that do not know
// where the lens ends project points beyond a pole into the image: a ring in undistorted images.
void addPole(const CameraRecord& record, FileCheck& check) {
  constexpr double kNear = 1.25;  // undistorted images with all pixels show rays that far out
  // Wide models end where they have no value, too, but not by a pole.
  const bool is_perspective = modelTraits(record.camera.modelId()).family == LensFamily::kPerspective;
  const std::optional<double> pole_rad = is_perspective ? poleAngle(record.camera) : std::nullopt;
  if (!pole_rad) return;
  double corner = 0;  // tangents of angles off-axis
  for (const double u : {-0.5, record.image_size.width - 0.5}) {
    for (const double v : {-0.5, record.image_size.height - 0.5}) {
      if (const auto ray = record.camera.unproject({u, v}))
        corner = std::max(corner, std::hypot(ray->x(), ray->y()) / ray->z());
    }
  }
  const double share = std::tan(*pole_rad) / corner;
  check.values.insert(check.values.end(), {{"pole_over_corner", share}, {"pole_limit", kNear}});
  if (share >= kNear) return;
  check.severity = Severity::kWarning;
  check.message += fmt::format(
      "; but the distortion has a pole (its denominator is zero) {:.3g} times as far out as the image corner; limit "
      "{:g}. OpenCV projects points beyond it into the image. Calibrate with boards in the corners, or with a "
      "smaller model",
      share, kNear);
}

// Checks what share of the image has a ray.
FileCheck checkOneToOne(const CameraRecord& record, const DomainCertificate& domain, bool is_size_guessed) {
  const double share = domain.full_image ? 1.0 : rayShare(record.camera, record.image_size);
  const double degrees = domain.cone.max_angle_rad * kDegPerRad;
  FileCheck check{
      .severity = Severity::kPass,
      .id = "one_to_one",
      .message = fmt::format("100 % of the image has a ray, up to {:.1f} degrees off-axis", degrees),
      .values = {
          {"ray_share", share}, {"limit", 1 - kMaxFolded}, {"max_angle_rad", domain.cone.max_angle_rad}}};
  if (domain.full_image) {
    addPole(record, check);
    return check;
  }
  const std::string percent = fmt::format(
      "{:.2f} % of {} has a ray", 100 * share,
      is_size_guessed ? "an image of " + sizeText(record.image_size) + " px around the principal point"
                      : "the image");
  const std::string where = std::string("before the image ") + (foldsBeforeEdge(record) ? "edge" : "corner");
  if (domain.cone.is_limited_by_fold) check.values.emplace_back("folds_before_edge", foldsBeforeEdge(record));
  if (!foldsInsideImage(domain)) {
    // A wide lens leaves the corners of the image dark.
    check.severity = Severity::kNote;
    check.message =
        fmt::format("{}; the lens model ends {:.1f} degrees off-axis, {}", percent, degrees, where);
    return check;
  }
  check.message =
      fmt::format("the distortion folds over inside the image: only {}; limit {:.0f} %; it folds {}", percent,
                  100 * (1 - kMaxFolded), where);
  // A guessed size proves nothing.
  const Severity severity = is_size_guessed ? Severity::kWarning : Severity::kFailure;
  check.severity = 1 - share > kMaxFolded ? severity : Severity::kNote;
  return check;
}

std::string coverageText(bool is_full_image) {
  return is_full_image ? "the whole image" : "a part of the image";
}

FileCheck checkDomainClaim(const DomainClaim& claim, const DomainCertificate& domain) {
  const double difference = std::abs(claim.max_angle_rad - domain.cone.max_angle_rad);
  constexpr double kDomainRad = 1e-6;
  const bool is_same = difference <= kDomainRad && claim.full_image == domain.full_image;
  std::string message = fmt::format("{:.7g} rad, {}", claim.max_angle_rad, coverageText(claim.full_image));
  if (!is_same) {
    message += fmt::format(" is stated; the parameters give {:.7g} rad, {}. Were numbers edited?",
                           domain.cone.max_angle_rad, coverageText(domain.full_image));
  }
  return {.severity = is_same ? Severity::kPass : Severity::kFailure,
          .id = "domain",
          .message = std::move(message),
          .values = {{"stated_max_angle_rad", claim.max_angle_rad},
                     {"max_angle_rad", domain.cone.max_angle_rad}}};
}

FileCheck checkSelfCheck(const CameraRecord& record, const SelfCheckOutcome& outcome) {
  const std::string worst = std::isfinite(outcome.worst_px)
                                ? fmt::format("{:.3g} px off at worst", outcome.worst_px)
                                : "one of them cannot be projected";
  FileCheck check{
      .severity = outcome.isPassed() ? Severity::kPass : Severity::kFailure,
      .id = "self_check",
      .message = fmt::format("{} points project to their stored pixels; {}", record.self_check.size(), worst),
      .values = {{"worst_px", outcome.worst_px}, {"limit_px", kSelfCheckPx}}};
  if (outcome.isPassed()) return check;
  check.message = fmt::format(
      "the parameters do not project the {} stored points to their pixels: {}; limit {} px. A number in the "
      "file was changed",
      record.self_check.size(), worst, kSelfCheckPx);
  if (outcome.outside_image) {
    check.message = fmt::format(
        "stored points lie outside the image of {}x{} px. The image size was changed, or width and height "
        "are swapped",
        record.image_size.width, record.image_size.height);
  }
  return check;
}

// Checks the covariance of a record that states one.
FileCheck checkCovariance(const CameraRecord& record) {
  constexpr double kStdShare = 1e-6;
  const auto n = static_cast<Eigen::Index>(record.camera.parameters().size());
  const CalibrationRecord& stated = *record.calibration;
  const Correlations correlations(stated.covariance, n);
  bool is_consistent = true;
  for (std::size_t i = 0; i < stated.parameter_std.size(); ++i) {
    const double expected = correlations.std(static_cast<Eigen::Index>(i));
    is_consistent = is_consistent && std::abs(stated.parameter_std[i] - expected) <= kStdShare * expected;
  }
  return covarianceCheck("covariance", "the covariance", correlations.isSemidefinite(), is_consistent,
                         "parameter_std");
}

// The record of the camera, with the image size to use in checks.
CameraRecord recordToCheck(const StatedCamera& stated) {
  if (stated.own) return *stated.own;
  return {.camera = stated.camera, .image_size = stated.image_size.value_or(sizeAround(stated.camera))};
}

}  // namespace

FileCheck covarianceCheck(DiagnosisId id, const std::string& what, bool is_semidefinite, bool is_consistent,
                          const std::string& std) {
  if (is_semidefinite && is_consistent)
    return {.severity = Severity::kPass, .id = id, .message = "the covariance matrix is valid"};
  return {.severity = Severity::kFailure,
          .id = id,
          .message = what + " is wrong (were numbers edited?): " +
                     (is_semidefinite ? "it contradicts " + std : "a variance is negative")};
}

FileCheck verdictCheck(DiagnosisId id, Verdict verdict, std::string message) {
  return {.severity = verdict == Verdict::kNo            ? Severity::kFailure
                      : verdict == Verdict::kTrustworthy ? Severity::kPass
                                                         : Severity::kNote,
          .id = id,
          .message = std::move(message)};
}

FileCheck fileCheck(const Diagnosis& diagnosis) {
  std::string message = diagnosis.message();
  if (diagnosis.severity > Severity::kNote && !diagnosis.limit.empty())
    message += "; limit: " + diagnosis.limit;
  if (!diagnosis.next_step.empty()) message += "\n  next: " + diagnosis.next_step;
  return {.severity = diagnosis.severity, .id = diagnosis.id, .message = std::move(message)};
}

ImageSize sizeAround(const AnyCamera& camera) {
  const auto side = [](double center) {
    constexpr double kMaxSide = 1e6;
    return static_cast<int>(std::clamp(std::round(2 * center + 1), 1.0, kMaxSide));
  };
  return {.width = side(camera.parameters()[2]), .height = side(camera.parameters()[3])};
}

std::string calibrationText(const CalibrationRecord& stated) {
  std::string text(verdictName(stated.verdict));
  if (!std::isfinite(stated.accuracy_px)) return text;
  constexpr double kLeastPx = 1e-4;  // for corners without noise
  text += fmt::format(", within {:.3g} px (95 %)", std::max(stated.accuracy_px, kLeastPx));
  if (std::isfinite(stated.accuracy_distance_m))
    text += fmt::format(" at {:g} m", stated.accuracy_distance_m);
  if (std::isfinite(stated.covered_share))
    text += fmt::format(" over {:.0f} % of the image", 100 * stated.covered_share);
  return text;
}

std::vector<FileCheck> checkCamera(const CameraRecord& record, bool is_size_guessed,
                                   const std::optional<Eigen::Vector2d>& rectified_center) {
  const DomainCertificate domain = certifyDomain(record.camera, record.image_size);
  const SelfCheckOutcome self_check = runSelfCheck(record.camera, record.image_size, record.self_check);
  std::vector<FileCheck> checks = {checkFocalLength(record, is_size_guessed), checkAspect(record)};
  if (!is_size_guessed) {
    // The self-check proves that Alidade wrote these numbers, so a principal point far from the centre comes
    // from a cropped image.
    checks.push_back(checkPrincipalPoint(record, !record.self_check.empty() && self_check.isPassed()));
  }
  if (rectified_center) checks.push_back(checkProjectionMatrix(record, *rectified_center));
  if (auto check = checkTangential(record)) checks.push_back(*std::move(check));
  checks.push_back(checkOneToOne(record, domain, is_size_guessed));
  if (!record.self_check.empty()) checks.push_back(checkSelfCheck(record, self_check));
  if (record.domain) checks.push_back(checkDomainClaim(*record.domain, domain));
  if (!record.calibration) return checks;
  if (!record.calibration->covariance.empty()) checks.push_back(checkCovariance(record));
  const Verdict verdict = record.calibration->verdict;
  checks.push_back(verdictCheck("calibration", verdict,
                                "the verdict was " + calibrationText(*record.calibration) +
                                    (verdict == Verdict::kNo ? ": the camera must not be used" : "")));
  return checks;
}

Severity CameraJudgement::severity() const {
  Severity worst = Severity::kPass;
  for (const FileCheck& check : checks) worst = std::max(worst, check.severity);
  return worst;
}

Severity FileJudgement::severity() const {
  Severity worst = error.empty() ? Severity::kPass : Severity::kFailure;
  for (const CameraJudgement& camera : cameras) worst = std::max(worst, camera.severity());
  for (const FileCheck& check : rig_checks) worst = std::max(worst, check.severity);
  return worst;
}

CameraJudgement judgeCamera(const StatedCamera& stated, const std::string& file) {
  CameraJudgement judgement{.name = cameraLabel(stated),
                            .camera = stated.camera,
                            .image_size = stated.image_size,
                            .calibration = stated.own ? stated.own->calibration : std::nullopt,
                            .label = stated.own ? stated.own->name : CameraName(),
                            .can_show_slips = stated.own && !stated.own->self_check.empty()};
  judgement.checks = checkCamera(recordToCheck(stated), !stated.image_size, stated.rectified_center);
  if (!stated.image_size) {
    judgement.checks.push_back({.severity = Severity::kNote,
                                .id = "image_size",
                                .message = "the file does not state the image size; --image-size adds it"});
  }
  // Every command prints these, but only an ignored key may be a slip.
  for (const Remark& remark : stated.remarks) {
    judgement.checks.push_back({.severity = remark.id == "unknown_keys" ? Severity::kWarning
                                            : remark.id == "bad_pose"   ? Severity::kFailure
                                                                        : Severity::kNote,
                                .id = DiagnosisId::read(remark.id),
                                .message = withoutPath(remark.message, cameraFilePath(file))});
  }
  return judgement;
}

std::string withoutPath(const std::string& message, const std::string& file) {
  if (!message.starts_with(file + ":")) return message;
  std::string rest = message.substr(file.size() + 1);
  const bool is_line = !rest.empty() && rest.front() >= '0' && rest.front() <= '9';
  if (is_line) return "line " + rest;
  return rest.starts_with(' ') ? rest.substr(1) : rest;
}

}  // namespace alidade
