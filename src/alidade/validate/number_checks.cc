// SPDX-License-Identifier: MIT
#include "alidade/validate/number_checks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "alidade/camera/batch.h"

namespace alidade::detail {
namespace {

// Focal lengths as a share of the image's long side: a perspective field of view of 170 degrees, and of 0.2.
constexpr double kMinFocalShare = 0.04;
constexpr double kMaxFocalShare = 300;
// Of a file without an image size: focal lengths in mm, or relative to the image, are below.
constexpr double kMinFocalPx = 5;
constexpr double kAspectWarn = 1.1;  // analogue video: 1.09
constexpr double kAspectFail = 1.5;
// Distances from the image centre, as a share of the side.
constexpr double kOffCentre = 0.15;  // hardly ever reached by an image that is not cropped
constexpr double kOffSeen = 0.08;    // enough, where swapped or scaled numbers explain it
constexpr double kScaleTolerance = 0.1;
// Decentring moves the image corner by this share of its distance from the centre at most in real lenses:
// none of the sets in docs/real_data.md exceeds 0.4 %.
constexpr double kTangentialWarn = 0.02;
constexpr double kTangentialFail = 0.1;
constexpr double kTangentialUsual = 0.005;
// Share of the pixels that may lie beyond a fold: the corners of an image where no board was.
constexpr double kMaxFolded = 0.01;

std::string sizeText(ImageSize size) {
  return fmt::format("{}x{}", size.width, size.height);
}

// From the image centre, as shares of the sides.
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

// The same share of both sides, but not the half.
bool fitsOtherSize(const Eigen::Vector2d& offset) {
  if (offset.cwiseAbs().minCoeff() <= kOffSeen || offset.x() * offset.y() < 0) return false;
  const double scale = 1 + offset.sum();
  return std::abs(offset.x() - offset.y()) <= kScaleTolerance * scale;
}

// By which share of its distance from the centre p1 and p2 move an image corner at most.
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
  std::vector<double> u;
  std::vector<double> v;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      u.push_back((i + 0.5) * size.width / kColumns - 0.5);
      v.push_back((j + 0.5) * size.height / kRows - 0.5);
    }
  }
  std::vector<double> x(u.size());
  std::vector<double> y(u.size());
  std::vector<double> z(u.size());
  std::vector<ProjectStatus> status(u.size());
  unprojectBatch(camera, {.u = u, .v = v}, {.x = x, .y = y, .z = z, .status = status});
  return static_cast<double>(std::count(status.begin(), status.end(), ProjectStatus::kOk)) /
         static_cast<double>(status.size());
}

}  // namespace

FileCheck checkFocalLength(const CheckedNumbers& numbers) {
  const auto params = numbers.camera.parameters();
  const double side = std::max(numbers.size.width, numbers.size.height);
  const double min_px =
      numbers.is_size_guessed ? std::max(kMinFocalPx, kMinFocalShare * side) : kMinFocalShare * side;
  const double max_px = kMaxFocalShare * side;
  const bool is_possible =
      std::min(params[0], params[1]) >= min_px && std::max(params[0], params[1]) <= max_px;
  const std::string image = numbers.is_size_guessed ? "any image" : sizeText(numbers.size) + " px";
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

FileCheck checkAspect(const CheckedNumbers& numbers) {
  const auto params = numbers.camera.parameters();
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

FileCheck checkPrincipalPoint(const CheckedNumbers& numbers) {
  const auto params = numbers.camera.parameters();
  const ImageSize size = numbers.size;
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
  if (!numbers.is_proven && fitsOtherSize(offset)) {
    return end(Severity::kFailure,
               fmt::format(": fits an image of about {:.0f}x{:.0f}. Was the image resized?",
                           std::abs(2 * params[2] + 1), std::abs(2 * params[3] + 1)));
  }
  const std::string percent = fmt::format("{:.0f} % of the side", 100 * kOffCentre);
  if (off > 0.5) {
    return end(numbers.is_proven ? Severity::kNote : Severity::kFailure,
               ": outside the image. Was the image cropped?");
  }
  if (offset.cwiseAbs().minCoeff() > kOffCentre) {
    return end(
        numbers.is_proven ? Severity::kNote : Severity::kFailure,
        ": too far from the centre in both directions; limit " + percent + ". Is the image size right?");
  }
  if (off > kOffCentre) {
    return end(numbers.is_proven ? Severity::kNote : Severity::kWarning,
               ": far from the centre; limit " + percent + ". Was the image cropped?");
  }
  return check;
}

FileCheck checkProjectionMatrix(const CheckedNumbers& numbers, const Eigen::Vector2d& rectified_center) {
  constexpr double kFarShare = 0.05;  // of the long side
  const auto params = numbers.camera.parameters();
  const double side = std::max(numbers.size.width, numbers.size.height);
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

std::optional<FileCheck> checkTangential(const CheckedNumbers& numbers) {
  const std::string_view model = numbers.camera.modelId();
  if (model != "radtan" && model != "rational" && model != "thin_prism") return std::nullopt;
  const std::span<const double> p = numbers.camera.parameters();
  const double share = decentringShare(p, p[6], p[7], numbers.size);
  // As k1 k2 k3 p1 p2 would have it.
  const bool is_reordered = share > kTangentialWarn && p[8] != 0 &&
                            decentringShare(p, p[7], p[8], numbers.size) <= kTangentialUsual;
  const Severity severity = share <= kTangentialWarn                  ? Severity::kPass
                            : share > kTangentialFail || is_reordered ? Severity::kFailure
                                                                      : Severity::kWarning;
  std::string message = fmt::format("p1 and p2 move the image corner by {:.3g} %", 100 * share);
  if (severity != Severity::kPass) {
    message += fmt::format("; limit {:.3g} %, real lenses stay below {:.2g} %. {}", 100 * kTangentialWarn,
                           100 * kTangentialUsual,
                           is_reordered ? "Is the order of the file k1 k2 k3 p1 p2?"
                                        : "Are the coefficients in the right order, and of this model?");
  }
  return FileCheck{
      .severity = severity,
      .id = "tangential",
      .message = std::move(message),
      .values = {
          {"corner_shift_share", share}, {"warning_limit", kTangentialWarn}, {"limit", kTangentialFail}}};
}

FileCheck checkOneToOne(const CheckedNumbers& numbers, const DomainCertificate& domain) {
  const double share = domain.full_image ? 1.0 : rayShare(numbers.camera, numbers.size);
  const double degrees = domain.cone.max_angle_rad * 180 / std::numbers::pi;
  FileCheck check{
      .severity = Severity::kPass,
      .id = "one_to_one",
      .message = fmt::format("every pixel has one ray, up to {:.1f} degrees off-axis", degrees),
      .values = {
          {"ray_share", share}, {"limit", 1 - kMaxFolded}, {"max_angle_rad", domain.cone.max_angle_rad}}};
  if (domain.full_image) return check;
  const std::string percent = fmt::format("{:.2f} % of the image has a ray", 100 * share);
  if (!foldsInsideImage(domain)) {
    // A wide lens leaves the corners of the image dark.
    check.severity = Severity::kNote;
    check.message = fmt::format("{}; the lens ends {:.1f} degrees off-axis", percent, degrees);
    return check;
  }
  check.message = fmt::format("the distortion folds over inside the image: only {}; limit {:.0f} %", percent,
                              100 * (1 - kMaxFolded));
  // A size that was guessed proves nothing.
  const Severity severity = numbers.is_size_guessed ? Severity::kWarning : Severity::kFailure;
  check.severity = 1 - share > kMaxFolded ? severity : Severity::kNote;
  return check;
}

}  // namespace alidade::detail
