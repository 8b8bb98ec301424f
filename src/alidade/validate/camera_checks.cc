// SPDX-License-Identifier: MIT
#include "alidade/validate/camera_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "alidade/geometry/symmetric_eigen.h"
#include "alidade/validate/projection_std_check.h"

namespace alidade {
namespace {

// From a field of view of 2 degrees over the long side to 170.
constexpr double kMinFocalShare = 0.04;
constexpr double kMaxFocalShare = 30;
constexpr double kAspectWarn = 1.03;
constexpr double kAspectFail = 1.25;
// Share of the image's side by which the principal point may miss its middle before it is odd.
constexpr double kCentreWarn = 0.15;
constexpr double kSwappedShare = 0.05;  // of a swapped one, to be noticed as such
constexpr double kDomainRad = 1e-6;
constexpr double kStdShare = 1e-6;

double degrees(double rad) {
  return rad * 180 / std::numbers::pi;
}

Diagnosis checkFocal(const CameraRecord& record) {
  const auto params = record.camera.parameters();
  const double side = std::max(record.image_size.width, record.image_size.height);
  const bool is_usual = std::min(params[0], params[1]) >= kMinFocalShare * side &&
                        std::max(params[0], params[1]) <= kMaxFocalShare * side;
  return {.severity = is_usual ? Severity::kPass : Severity::kWarning,
          .id = "focal_length",
          .cause = is_usual ? "the focal lengths suit the image's size"
                            : "the focal lengths do not suit the image's size; was the image resized?",
          .evidence = fmt::format("fx {:.6g}, fy {:.6g} px", params[0], params[1]),
          .limit = fmt::format("{:.4g} to {:.4g} px", kMinFocalShare * side, kMaxFocalShare * side)};
}

Diagnosis checkAspect(const CameraRecord& record) {
  const auto params = record.camera.parameters();
  const double aspect = std::max(params[0] / params[1], params[1] / params[0]);
  const Severity status = aspect <= kAspectWarn   ? Severity::kPass
                          : aspect <= kAspectFail ? Severity::kWarning
                                                  : Severity::kFailure;
  return {.severity = status,
          .id = "aspect",
          .cause = status == Severity::kPass ? "pixels are square"
                                             : "fx and fy differ; pixels of almost all sensors are square",
          .evidence = fmt::format("{:.6g}", params[0] / params[1]),
          .limit = fmt::format("1 / {0} to {0}", kAspectWarn)};
}

Diagnosis checkPrincipalPoint(const CameraRecord& record) {
  const auto params = record.camera.parameters();
  const double x = (params[2] + 0.5) / record.image_size.width;
  const double y = (params[3] + 0.5) / record.image_size.height;
  const double off = std::max(std::abs(x - 0.5), std::abs(y - 0.5));
  const Severity status = off <= kCentreWarn ? Severity::kPass
                          : off < 0.5        ? Severity::kWarning
                                             : Severity::kFailure;
  // A principal point that suits the image lying on its side.
  const bool looks_swapped =
      off > kCentreWarn &&
      std::max(std::abs((params[2] + 0.5) / record.image_size.height - 0.5),
               std::abs((params[3] + 0.5) / record.image_size.width - 0.5)) <= kSwappedShare;
  std::string message = "the principal point is near the image's middle";
  if (status == Severity::kWarning)
    message = "the principal point is far from the image's middle; was the image cropped?";
  if (status == Severity::kFailure)
    message = "the principal point is outside the image; are width and height swapped?";
  if (looks_swapped)
    message = "cx and cy suit the image lying on its side: are they, or width and height, swapped?";
  return {.severity = status,
          .id = "principal_point",
          .cause = message,
          .evidence = fmt::format("({:.6g}, {:.6g}) px", params[2], params[3]),
          .limit = fmt::format("within {:.0f} % of the middle of {}x{}", 100 * kCentreWarn,
                               record.image_size.width, record.image_size.height)};
}

Diagnosis checkOneToOne(const DomainCertificate& domain) {
  std::string value = fmt::format("up to {:.2f} degrees from the axis", degrees(domain.cone.max_angle_rad));
  if (domain.pixel_without_ray) {
    value += fmt::format("; pixel ({:.1f}, {:.1f}) has no ray", domain.pixel_without_ray->x(),
                         domain.pixel_without_ray->y());
  }
  Diagnosis check{.severity = Severity::kPass,
                  .id = "one_to_one",
                  .cause = "the projection is one-to-one over the whole image",
                  .evidence = value,
                  .limit = "a ray for every pixel"};
  if (foldsInsideImage(domain)) {
    check.severity = Severity::kFailure;
    check.cause = "the projection folds over inside the image";
  } else if (!domain.full_image) {
    // As in calibration: a wide lens leaves the image's corners dark.
    check.severity = Severity::kWarning;
    check.cause = "the model ends inside the image; does the lens leave these pixels dark?";
  }
  return check;
}

Diagnosis checkDomainClaim(const CameraRecord& record, const DomainCertificate& domain) {
  Diagnosis check{.severity = Severity::kWarning,
                  .id = "domain",
                  .cause = {},
                  .evidence = "not stated",
                  .limit = "as recomputed"};
  if (!record.domain) {
    check.cause = "the file does not say up to which angle it holds";
    return check;
  }
  const double difference = std::abs(record.domain->max_angle_rad - domain.cone.max_angle_rad);
  const bool is_same = difference <= kDomainRad && record.domain->full_image == domain.full_image;
  check.severity = is_same ? Severity::kPass : Severity::kFailure;
  check.evidence = fmt::format("{:.7g} rad, {}", record.domain->max_angle_rad,
                               record.domain->full_image ? "full image" : "part of the image");
  check.limit = fmt::format("{:.7g} rad, {}", domain.cone.max_angle_rad,
                            domain.full_image ? "full image" : "part of the image");
  check.cause = is_same ? "the stated domain is right"
                        : "the stated domain is not that of the parameters; were they edited?";
  return check;
}

Diagnosis checkSelfCheck(const CameraRecord& record) {
  Diagnosis check{.severity = Severity::kWarning,
                  .id = "self_check",
                  .cause = {},
                  .evidence = "no points",
                  .limit = fmt::format("{} px", kSelfCheckPx)};
  if (record.self_check.empty()) {
    check.cause = "the file has no self-check points, so a slip in its numbers cannot be seen";
    return check;
  }
  const SelfCheckOutcome outcome = runSelfCheck(record.camera, record.image_size, record.self_check);
  const bool is_same = outcome.worst_px <= kSelfCheckPx;
  check.severity = is_same ? Severity::kPass : Severity::kFailure;
  check.evidence = fmt::format("{:.3g} px at worst of {} points", outcome.worst_px, record.self_check.size());
  if (outcome.outside_image) {
    check.severity = Severity::kFailure;
    check.evidence += ", some outside the image";
    check.cause =
        "self-check points lie outside the image: its size was changed, or width and height swapped";
    return check;
  }
  check.cause =
      is_same ? "the parameters project the self-check points to their pixels"
              : "the parameters do not project the self-check points to their pixels; a number was changed";
  return check;
}

// A lower triangle row by row as a matrix of correlations, and the standard deviations: the units of the
// parameters span ten orders of magnitude.
struct Correlations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd std;

  Correlations(std::span<const double> triangle, Eigen::Index n) : matrix(n, n) {
    expect(static_cast<Eigen::Index>(triangle.size()) == n * (n + 1) / 2, "a whole lower triangle");
    std::size_t k = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) matrix(i, j) = matrix(j, i) = triangle[k++];
    }
    std = matrix.diagonal().cwiseSqrt();
    for (Eigen::Index i = 0; i < n; ++i) {
      // A parameter that was held has neither variance nor covariance.
      const double scale = matrix.row(i).isZero(0) ? 1 : 1 / std(i);
      matrix.row(i) *= scale;
      matrix.col(i) *= scale;
    }
  }

  // One focal length for both axes makes it singular, so that rounding may leave an eigenvalue below zero.
  [[nodiscard]] bool isSemidefinite() const {
    constexpr double kRounding = 1e-10;
    if (!matrix.allFinite()) return false;
    const SymmetricEigen solver(matrix);
    return solver.eigenvalues().minCoeff() >= -kRounding * static_cast<double>(matrix.rows());
  }
};

Diagnosis checkCovariance(const CameraRecord& record) {
  const auto n = static_cast<Eigen::Index>(record.camera.parameters().size());
  Diagnosis check{.severity = Severity::kWarning,
                  .id = "covariance",
                  .cause = {},
                  .evidence = "not stated",
                  .limit = "no negative variance in any direction"};
  if (!record.calibration || record.calibration->covariance.empty()) {
    check.cause = "the file does not say how well the parameters are known";
    return check;
  }
  const CalibrationRecord& stated = *record.calibration;
  const Correlations correlations(stated.covariance, n);
  const bool is_semidefinite =
      correlations.isSemidefinite() &&
      (stated.stated_covariance.empty() || Correlations(stated.stated_covariance, n).isSemidefinite());
  bool is_consistent = true;
  for (std::size_t i = 0; i < stated.parameter_std.size(); ++i) {
    const double expected = correlations.std(static_cast<Eigen::Index>(i));
    is_consistent = is_consistent && std::abs(stated.parameter_std[i] - expected) <= kStdShare * expected;
  }
  check.severity = is_semidefinite && is_consistent ? Severity::kPass : Severity::kFailure;
  check.evidence = !is_semidefinite ? "a negative variance"
                   : is_consistent  ? "no negative variance"
                                    : "does not agree with parameter_std";
  check.cause = check.severity == Severity::kPass ? "the covariance is one"
                                                  : "the covariance cannot be right; were numbers edited?";
  return check;
}

Diagnosis checkCalibration(const CameraRecord& record) {
  Diagnosis check{.severity = Severity::kWarning,
                  .id = "calibration",
                  .cause = "the file does not say how its numbers came about",
                  .evidence = "not stated",
                  .limit = "trustworthy"};
  if (!record.calibration) return check;
  check.evidence = verdictName(record.calibration->verdict);
  switch (record.calibration->verdict) {
    case Verdict::kTrustworthy:
      check.severity = Severity::kPass;
      check.cause = "the calibration found no reason to doubt itself";
      break;
    case Verdict::kReservations:
      check.cause = "the calibration has reservations, which its findings name";
      break;
    case Verdict::kNo:
      check.severity = Severity::kFailure;
      check.cause = "the calibration itself said that it is not to be trusted";
      break;
  }
  return check;
}

// Nobody can be blamed for what a guess of ours leads to.
void soften(std::vector<Diagnosis>& checks) {
  for (Diagnosis& check : checks) {
    const bool needs_size = check.id == "principal_point" || check.id == "one_to_one";
    if (!needs_size || check.severity != Severity::kFailure) continue;
    check.severity = Severity::kWarning;
    check.cause += "; the size of the image was guessed, --image-size tells it";
  }
}

}  // namespace

std::string_view checkStatusName(Severity severity) {
  switch (severity) {
    case Severity::kPass:
    case Severity::kNote:
      return "PASS";
    case Severity::kWarning:
      return "WARN";
    case Severity::kFailure:
      return "FAIL";
  }
  return "UNKNOWN";
}

std::vector<Diagnosis> checkCamera(const CameraRecord& record, const RecordContext& context) {
  const DomainCertificate domain = certifyDomain(record.camera, record.image_size);
  std::vector<Diagnosis> checks = {checkFocal(record), checkAspect(record), checkPrincipalPoint(record),
                                   checkOneToOne(domain)};
  if (context.is_size_guessed) soften(checks);
  if (!context.can_say_more) return checks;
  checks.push_back(checkDomainClaim(record, domain));
  checks.push_back(checkSelfCheck(record));
  checks.push_back(checkCovariance(record));
  if (auto check = checkProjectionStd(record)) checks.push_back(*std::move(check));
  checks.push_back(checkCalibration(record));
  return checks;
}

}  // namespace alidade
