// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/camera_change.h"

#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/adjust/errors.h"
#include "alidade/core/error.h"
#include "alidade/core/statistics.h"

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

// The views posed for another camera of the model: refitted from where they are and, where they are given,
// from the freed camera's poses, of which the better counts, for far from the truth a pose may rest in a
// tilt that is not the board's. Nothing where a view is not seen from either.
std::optional<PosedViews> reposed(const AnyCamera& camera, const PosedViews& near, const PosedViews* freed) {
  const auto params = camera.parameters();
  PosedViews posed = near;
  onlyCamera(posed.fit).params.assign(params.begin(), params.end());
  for (std::size_t v = 0; v < near.fit.views.size(); ++v) {
    std::vector<SE3> starts = {cameraFromBoard(near.fit, near.fit.views[v])};
    if (freed != nullptr) starts.push_back(cameraFromBoard(freed->fit, freed->fit.views[v]));
    const auto pose = bestPose(camera, cornersOnShape(near.fit, near.fit.views[v]), kNoLoss, starts);
    if (!pose) return std::nullopt;
    setCameraFromBoard(posed.fit, posed.fit.views[v], *pose);
  }
  return posed;
}

// A camera on the way, with the views posed for it.
struct Stop {
  AnyCamera camera;
  PosedViews posed;
  Misfit misfit;
};

std::optional<Stop> stopAt(const AnyCamera& tested, CameraChange change, double amount,
                           const PosedViews& near, const PosedViews* freed) {
  auto camera = changed(tested, change, amount);
  if (!camera) return std::nullopt;
  auto posed = reposed(*camera, near, freed);
  if (!posed) return std::nullopt;
  const Misfit misfit = misfitOf(*posed);
  return Stop{*std::move(camera), *std::move(posed), misfit};
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
  const auto pixels = [&](const char* what) {
    return fmt::format("{} {} +- {} px too {}", what, figure(size), figure(std),
                       is_too_large ? "large" : "small");
  };
  // What has to be multiplied is off by a share of the right value, which is that of the file by this factor.
  const double factor = 1 + amount;
  const auto share = [&](const char* what, const char* large, const char* little) {
    constexpr double kLeastFactor = 0.1;  // less has no such share, or the other sign
    if (factor < kLeastFactor) {
      return fmt::format("{} would have to be {} +- {} times as {}", what, figure(factor), figure(std),
                         large);
    }
    return fmt::format("{} is {} +- {} % too {}", what, figure(100 * (size / factor)),
                       figure(100 * (std / (factor * factor))), is_too_large ? large : little);
  };
  switch (change) {
    case CameraChange::kFocalLength:
      return share("its focal length", "long", "short");
    case CameraChange::kCenterX:
      return pixels("its cx is");
    case CameraChange::kCenterY:
      return pixels("its cy is");
    case CameraChange::kDistortion:
      return share("its distortion", "strong", "weak");
    case CameraChange::kPixelOrigin:
      return pixels("its cx and cy are both");
  }
  return "";
}

std::optional<ChangeRefit> refitChange(const AnyCamera& tested, CameraChange change,
                                       const ChangeEvidence& evidence) {
  constexpr int kMostSteps = 50;
  constexpr int kMostHalvings = 10;
  constexpr double kRestSigmas = 0.01;  // a step so short changes no figure that is printed
  expect(evidence.held != nullptr, "views to refit");
  const Eigen::VectorXd direction = directionOf(change, tested);
  if (direction.size() == 0) return std::nullopt;
  auto now = stopAt(tested, change, 0, *evidence.held, evidence.freed);
  double amount = 0;
  for (int step = 0; now && step < kMostSteps; ++step) {
    const auto scores = HeldScores::make(now->camera, now->posed, evidence.freed, evidence.noise_variance,
                                         evidence.covariance);
    auto estimate = scores ? scores->along(direction) : std::nullopt;
    if (!estimate) return std::nullopt;
    if (std::abs(estimate->amount) <= kRestSigmas * estimate->std) {
      estimate->amount = amount;
      estimate->sigmas = normalOfStudentT(std::abs(amount) / estimate->std, estimate->freedom);
      return ChangeRefit{now->camera, *estimate, now->misfit.rms_px};
    }
    std::optional<Stop> next;
    double length = estimate->amount;
    for (int halving = 0; halving < kMostHalvings; ++halving, length *= 0.5) {
      next = stopAt(tested, change, amount + length, now->posed, evidence.freed);
      if (next && next->misfit.weighted_squares < now->misfit.weighted_squares) break;
      next.reset();
    }
    amount += length;
    now = std::move(next);
  }
  return std::nullopt;
}

}  // namespace alidade
