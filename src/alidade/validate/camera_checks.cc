// SPDX-License-Identifier: MIT
#include "alidade/validate/camera_checks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "alidade/camera/any_camera.h"
#include "alidade/core/error.h"
#include "alidade/geometry/symmetric_eigen.h"
#include "alidade/validate/number_checks.h"
#include "alidade/validate/projection_std_check.h"

namespace alidade {
namespace {

constexpr double kDomainRad = 1e-6;
constexpr double kStdShare = 1e-6;

std::string coverageText(bool is_full_image) {
  return is_full_image ? "the whole image" : "a part of the image";
}

FileCheck checkDomainClaim(const DomainClaim& claim, const DomainCertificate& domain) {
  const double difference = std::abs(claim.max_angle_rad - domain.cone.max_angle_rad);
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
                                : "one of them does not project";
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

// Of a record that states one.
Diagnosis checkCovariance(const CameraRecord& record) {
  const auto n = static_cast<Eigen::Index>(record.camera.parameters().size());
  Diagnosis check{.severity = Severity::kPass, .id = "covariance", .cause = {}};
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
  if (!is_semidefinite) check.evidence = "a variance is negative";
  if (is_semidefinite && !is_consistent) check.evidence = "it contradicts parameter_std";
  check.cause = check.severity == Severity::kPass ? "the covariance matrix is valid"
                                                  : "the covariance is wrong; were numbers edited?";
  return check;
}

FileCheck checkVerdict(Verdict verdict) {
  const std::string name(verdictName(verdict));
  switch (verdict) {
    case Verdict::kTrustworthy:
      return {.severity = Severity::kPass, .id = "calibration", .message = "the verdict was " + name};
    case Verdict::kReservations:
      return {.severity = Severity::kNote, .id = "calibration", .message = "the verdict was " + name};
    case Verdict::kNo:
      break;
  }
  return {.severity = Severity::kFailure,
          .id = "calibration",
          .message = "the verdict was " + name + ": the calibration was rejected"};
}

}  // namespace

ImageSize sizeAround(const AnyCamera& camera) {
  const auto side = [](double center) {
    constexpr double kMaxSide = 1e6;
    return static_cast<int>(std::clamp(std::round(2 * center + 1), 1.0, kMaxSide));
  };
  return {.width = side(camera.parameters()[2]), .height = side(camera.parameters()[3])};
}

std::vector<FileCheck> checkCamera(const CameraRecord& record, const RecordContext& context) {
  const DomainCertificate domain = certifyDomain(record.camera, record.image_size);
  const SelfCheckOutcome self_check = runSelfCheck(record.camera, record.image_size, record.self_check);
  const detail::CheckedNumbers numbers{.camera = record.camera,
                                       .size = record.image_size,
                                       .is_size_guessed = context.is_size_guessed,
                                       .is_proven = !record.self_check.empty() && self_check.isPassed()};
  std::vector<FileCheck> checks = {detail::checkFocalLength(numbers), detail::checkAspect(numbers)};
  if (!context.is_size_guessed) checks.push_back(detail::checkPrincipalPoint(numbers));
  if (context.rectified_center)
    checks.push_back(detail::checkProjectionMatrix(numbers, *context.rectified_center));
  if (auto check = detail::checkTangential(numbers)) checks.push_back(*std::move(check));
  checks.push_back(detail::checkOneToOne(numbers, domain));
  if (!record.self_check.empty()) checks.push_back(checkSelfCheck(record, self_check));
  if (record.domain) checks.push_back(checkDomainClaim(*record.domain, domain));
  if (!record.calibration) return checks;
  if (!record.calibration->covariance.empty()) checks.push_back(fileCheck(checkCovariance(record)));
  // A warning: the file does not state all that the check needs.
  if (const auto check = checkProjectionStd(record); check && check->severity != Severity::kWarning)
    checks.push_back(fileCheck(*check));
  checks.push_back(checkVerdict(record.calibration->verdict));
  return checks;
}

}  // namespace alidade
