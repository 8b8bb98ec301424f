// SPDX-License-Identifier: MIT
#include "alidade/rig/given_lens.h"

#include <algorithm>

#include "alidade/compare/projection_difference.h"

namespace alidade {
namespace {

// Spread evenly over all.
std::vector<Eigen::Vector2d> someCorners(const Fit& fit, std::size_t camera) {
  constexpr std::size_t kMost = 2000;
  std::vector<Eigen::Vector2d> all;
  for (const FitView& view : fit.views) {
    if (view.camera != camera) continue;
    for (const Observation& corner : view.corners) all.push_back(corner.pixel);
  }
  const std::size_t step = (all.size() + kMost - 1) / kMost;
  std::vector<Eigen::Vector2d> some;
  for (std::size_t i = 0; i < all.size(); i += step) some.push_back(all[i]);
  return some;
}

}  // namespace

std::optional<LensMisfit> givenLensMisfit(const CameraRecord& given, const RigCalibration& rig,
                                          std::size_t camera) {
  const Calibration& freed = rig.cameras[camera].calibration;
  if (!freed.uncertainty.covariance) return std::nullopt;
  const AnyCamera freed_camera = freed.camera();
  const ComparedCamera a{
      .camera = &given.camera, .size = given.image_size, .covariance = statedCovariance(given)};
  const ComparedCamera b{
      .camera = &freed_camera, .size = freed.imageSize(), .covariance = freed.uncertainty.statedCovariance()};
  const ProjectionDifference difference =
      projectionDifference(a, b, {.quarter_turns = 0, .pixels = someCorners(rig.fit, camera)});
  if (!difference.is_converged || difference.num_compared == 0) return std::nullopt;
  const auto significance = significanceOf(difference, a, b, Freed::kRotation);
  if (!significance || !significance->isSignificant()) return std::nullopt;
  return LensMisfit{.effect_px = difference.p95_px, .freed_rms_px = rig.cameras[camera].rms_px};
}

}  // namespace alidade
