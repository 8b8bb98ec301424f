// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/camera_change.h"

#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"

namespace alidade {
namespace {

// Of the others 0 is not the lens without distortion, or is in no proportion to it.
bool isPolynomial(std::string_view model_id) {
  return model_id == "radtan" || model_id == "kannala_brandt" || model_id == "thin_prism";
}

// Two digits, and no exponent of ten for what people count.
std::string figure(double value) {
  return value < 100 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
}

}  // namespace

Eigen::VectorXd directionOf(CameraChange change, const AnyCamera& camera) {
  constexpr Eigen::Index kNumProjection = 4;  // fx fy cx cy, then the lens
  const auto params = camera.parameters();
  const auto n = static_cast<Eigen::Index>(params.size());
  const Eigen::Map<const Eigen::VectorXd> now(params.data(), n);
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(n);
  switch (change) {
    case CameraChange::kFocalLength:
      direction.head<2>() = now.head<2>();
      break;
    case CameraChange::kCenterX:
      direction(2) = 1;
      break;
    case CameraChange::kCenterY:
      direction(3) = 1;
      break;
    case CameraChange::kDistortion:
      if (!isPolynomial(camera.modelId())) return {};
      direction.tail(n - kNumProjection) = now.tail(n - kNumProjection);
      if (direction.isZero(0)) return {};
      break;
    case CameraChange::kPixelOrigin:
      direction.segment<2>(2).setOnes();
      break;
  }
  return direction;
}

std::optional<AnyCamera> changed(const AnyCamera& camera, CameraChange change, double amount) {
  const auto given = camera.parameters();
  std::vector<double> params(given.begin(), given.end());
  const Eigen::VectorXd direction = directionOf(change, camera);
  for (std::size_t i = 0; i < params.size() && direction.size() > 0; ++i)
    params[i] += amount * direction(static_cast<Eigen::Index>(i));
  try {
    return AnyCamera::make(camera.modelId(), params);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string complaintOf(CameraChange change, double amount, double std) {
  const double size = std::abs(amount);
  const bool is_too_large = amount < 0;  // something would have to be taken off
  // What has to be multiplied is off by a share of the right value, which is that of the file by this factor.
  constexpr double kLeastFactor = 0.1;  // less has no such share, or the other sign
  const double factor = 1 + amount;
  const auto ofRight = [&](double share) { return share / factor; };
  const double std_of_right = std / (factor * factor);
  const auto pixels = [&](const char* what) {
    return fmt::format("{} {} +- {} px too {}", what, figure(size), figure(std),
                       is_too_large ? "large" : "small");
  };
  switch (change) {
    case CameraChange::kFocalLength:
      if (factor < kLeastFactor)
        return fmt::format("its focal length would have to be {} +- {} times as long", figure(factor),
                           figure(std));
      return fmt::format("its focal length is {} +- {} % too {}", figure(100 * ofRight(size)),
                         figure(100 * std_of_right), is_too_large ? "long" : "short");
    case CameraChange::kCenterX:
      return pixels("its cx is");
    case CameraChange::kCenterY:
      return pixels("its cy is");
    case CameraChange::kDistortion:
      if (factor < kLeastFactor)
        return fmt::format("its distortion would have to be {} +- {} times as strong", figure(factor),
                           figure(std));
      return fmt::format("its distortion is {} +- {} % too {}", figure(100 * ofRight(size)),
                         figure(100 * std_of_right), is_too_large ? "strong" : "weak");
    case CameraChange::kPixelOrigin:
      return pixels("its cx and cy are both");
  }
  return "";
}

}  // namespace alidade
