// SPDX-License-Identifier: MIT
#include "alidade/validate/file_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Core>

#include "alidade/camera/camera_variant.h"
#include "alidade/camera/projection.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr int kGridColumns = 9;
constexpr int kGridRows = 7;
constexpr double kRoundingPx = 0.01;
// Decentring shifts the image's corner by this share of its distance from the middle at most, in lenses that
// are sold: of the real sets in docs/real_data.md none exceeds 0.4 %.
constexpr double kDecentringShare = 0.02;

Diagnosis checkUnknownKeys(const FileClaims& claims) {
  const bool is_clean = claims.unknown_keys.empty();
  return {
      .severity = is_clean ? Severity::kPass : Severity::kWarning,
      .id = "unknown_keys",
      .cause = is_clean ? "every key has a meaning" : fmt::format("{}", fmt::join(claims.unknown_keys, "\n")),
      .evidence = is_clean ? "none" : "some",
      .limit = "none"};
}

Diagnosis checkConventions(const FileClaims& claims) {
  constexpr const char* kStated = "stated, or fixed by the format";
  Diagnosis check{.severity = Severity::kPass,
                  .id = "conventions",
                  .cause = "nothing had to be guessed",
                  .evidence = kStated,
                  .limit = kStated};
  std::vector<std::string> remarks = claims.assumed;
  remarks.insert(remarks.end(), claims.not_carried.begin(), claims.not_carried.end());
  if (remarks.empty()) return check;
  check.severity = Severity::kWarning;
  check.evidence = claims.assumed.empty()       ? "not all is of the camera alone"
                   : claims.not_carried.empty() ? "assumed"
                                                : "assumed, and not all is of the camera alone";
  check.cause = fmt::format("{}", fmt::join(remarks, "\n"));
  return check;
}

Diagnosis checkSize(const FileClaims& claims) {
  const ImageSize size = claims.image_size.value_or(sizeAround(*claims.camera));
  return {
      .severity = claims.image_size ? Severity::kPass : Severity::kWarning,
      .id = "image_size",
      .cause = claims.image_size
                   ? "the file says how large the image is"
                   : fmt::format("the file does not say how large the image is; {}x{} was taken, with the "
                                 "principal point in the middle; --image-size tells",
                                 size.width, size.height),
      .evidence = claims.image_size ? fmt::format("{}x{} px", size.width, size.height) : "not stated",
      .limit = "stated"};
}

// By how much each parameter may have been rounded. Zeros at the end are mostly not written, so a short
// number tells nothing by itself: what counts is the longest, by decimals as "%.6f" cuts them and by digits
// as "%.6g" does. All zero if one has all the digits of a double.
std::vector<double> roundingOf(const FileClaims& claims) {
  constexpr double kFullDigits = 15;
  const std::span<const double> values = claims.camera->parameters();
  std::vector<double> rounding(values.size(), 0.0);
  double decimals = -std::numeric_limits<double>::infinity();
  double digits = 0;
  const auto exponentOf = [&](std::size_t i) {
    return values[i] == 0 ? 0.0 : std::floor(std::log10(std::abs(values[i])));
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (claims.half_units[i] == 0) continue;
    const double last_digit = std::round(std::log10(2 * claims.half_units[i]));
    decimals = std::max(decimals, -last_digit);
    digits = std::max(digits, exponentOf(i) - last_digit + 1);
  }
  if (digits >= kFullDigits) return rounding;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double unit = std::max(std::pow(10.0, -decimals), std::pow(10.0, exponentOf(i) - digits + 1));
    rounding[i] = std::min(claims.half_units[i], 0.5 * unit);
  }
  return rounding;
}

// Ranges of parameters as AnyCamera::make() has them: their ends are not a matter of digits.
template <class M>
bool isInRange(std::size_t parameter, double value) {
  if (parameter < 4) return parameter >= 2 || value > 0;
  const ParamRange range = M::kLensRanges[parameter - 4];
  return value >= range.min && value <= range.max;
}

// How far pixels move at most if every parameter is off by its rounding, all in the worst way. The rounded
// lens is not certified anew, which would cost as much as all else together: its rays are the file's.
double roundingEffect(const FileClaims& claims) {
  const ImageSize size = claims.image_size.value_or(sizeAround(*claims.camera));
  const std::vector<double> rounding = roundingOf(claims);
  return claims.camera->visit([&](const auto& camera) {
    using M = typename std::decay_t<decltype(camera)>::Model;
    double most = 0;
    for (int i = 0; i < kGridRows * kGridColumns; ++i) {
      const Eigen::Vector2d pixel(
          size.width * static_cast<double>(i % kGridColumns) / (kGridColumns - 1) - 0.5,
          size.height * static_cast<double>(i / kGridColumns) / (kGridRows - 1) - 0.5);
      const auto ray = camera.unproject(pixel);
      if (!ray) continue;
      double moved = 0;
      for (std::size_t k = 0; k < rounding.size(); ++k) {
        auto parameters = camera.params();
        parameters[k] += rounding[k];
        Eigen::Vector2d rounded;
        if (rounding[k] != 0 && isInRange<M>(k, parameters[k]) &&
            projectFormula<M>(parameters.data(), ray->data(), rounded.data()) && rounded.allFinite())
          moved += (rounded - pixel).norm();
      }
      most = std::max(most, moved);
    }
    return most;
  });
}

Diagnosis checkDigits(const FileClaims& claims) {
  const double effect = roundingEffect(claims);
  const bool is_fine = effect <= kRoundingPx;
  return {.severity = is_fine ? Severity::kPass : Severity::kWarning,
          .id = "digits",
          .cause = is_fine ? "the numbers have as many digits as projection needs"
                           : "if digits were cut off, rounding alone may move pixels by that much",
          .evidence = fmt::format("{:.2g} px at most", effect),
          .limit = fmt::format("{} px", kRoundingPx)};
}

// By what share of its distance from the middle p1 and p2 shift a corner of the image, at most.
double decentringShare(std::span<const double> parameters, double p1, double p2, ImageSize size) {
  const double x = std::max(parameters[2] + 0.5, size.width - 0.5 - parameters[2]) / parameters[0];
  const double y = std::max(parameters[3] + 0.5, size.height - 0.5 - parameters[3]) / parameters[1];
  const double r2 = x * x + y * y;
  const double dx = 2 * std::abs(p1) * x * y + std::abs(p2) * (r2 + 2 * x * x);
  const double dy = std::abs(p1) * (r2 + 2 * y * y) + 2 * std::abs(p2) * x * y;
  return std::hypot(dx, dy) / std::sqrt(r2);
}

// Only the models with p1 and p2 have an order that others write differently.
std::optional<Diagnosis> checkOrder(const FileClaims& claims) {
  const std::string_view model = claims.camera->modelId();
  if (model != "radtan" && model != "rational" && model != "thin_prism") return std::nullopt;
  const std::span<const double> p = claims.camera->parameters();
  const ImageSize size = claims.image_size.value_or(sizeAround(*claims.camera));
  const double share = decentringShare(p, p[6], p[7], size);
  // As k1 k2 k3 p1 p2 would have it.
  const double reordered = decentringShare(p, p[7], p[8], size);
  const bool is_usual = share <= kDecentringShare;
  std::string message = "the decentring coefficients are as small as those of real lenses";
  if (!is_usual) {
    message = "p1 and p2 are larger than those of real lenses";
    message += reordered <= kDecentringShare
                   ? "; read as k1 k2 k3 p1 p2 they would be usual: is that the order?"
                   : "; were coefficients permuted or taken from another model?";
  }
  return Diagnosis{.severity = is_usual ? Severity::kPass : Severity::kWarning,
                   .id = "coefficient_order",
                   .cause = std::move(message),
                   .evidence = fmt::format("p1, p2 shift the corner by {:.3g} %", 100 * share),
                   .limit = fmt::format("{:.3g} %", 100 * kDecentringShare)};
}

}  // namespace

ImageSize sizeAround(const AnyCamera& camera) {
  const auto side = [](double center) {
    constexpr double kMaxSide = 1e6;
    return static_cast<int>(std::clamp(std::round(2 * center + 1), 1.0, kMaxSide));
  };
  return {.width = side(camera.parameters()[2]), .height = side(camera.parameters()[3])};
}

std::vector<Diagnosis> checkStatement(const FileClaims& claims) {
  expect(claims.camera != nullptr, "a camera to check");
  std::vector<Diagnosis> checks = {checkUnknownKeys(claims), checkConventions(claims), checkSize(claims)};
  if (!claims.half_units.empty()) checks.push_back(checkDigits(claims));
  if (auto check = checkOrder(claims)) checks.push_back(*std::move(check));
  return checks;
}

}  // namespace alidade
