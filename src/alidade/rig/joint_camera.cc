// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_stages.h"

#include <algorithm>
#include <set>
#include <vector>

#include "alidade/adjust/noise/joint_information.h"
#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/camera/image_domain.h"
#include "alidade/compare/projection_difference.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

// Sets the camera's views and boards from the rig's fit, in units of its own fit, whose weights are relative.
void setFit(const Fit& rig, std::size_t camera, double variance, Fit& fit) {
  onlyCamera(fit).params = rig.cameras[camera].params;
  fit.boards = rig.boards;
  for (FitBoard& board : fit.boards) {
    board.body_from_board = {};
    if (board.isUneven()) *board.offset_precision *= variance;
    board.flex.precision *= variance;
  }
  // The camera sees only some of the placements that have bends.
  for (std::size_t b = 0; b < fit.boards.size(); ++b) {
    std::set<std::size_t> places;
    for (const FitView& view : rig.views) {
      if (view.board == b) places.insert(view.placement);
    }
    if (!places.empty())
      fit.boards[b].flex.num_free *=
          static_cast<double>(numViews(fit, b)) / static_cast<double>(places.size());
  }
  auto own = fit.views.begin();
  for (const FitView& view : rig.views) {
    if (view.camera != camera) continue;
    own->board = view.board;
    own->corners = view.corners;
    own->errors = view.errors;
    own->flex_m = view.flex_m;
    for (Observation& corner : own->corners) corner.weight *= variance;
    setCameraFromBoard(fit, *own, cameraFromBoard(rig, view));
    ++own;
  }
}

// Some corners of a camera, evenly spread over all.
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

Calibration jointCamera(Calibration joint, const Fit& rig, const RigCovariance& covariance,
                        std::size_t camera, double tolerance_px, double distance_m) {
  const double sigma_px = std::max(joint.uncertainty.coordinate_sigma_px, kMinSigmaPx);
  setFit(rig, camera, sigma_px * sigma_px, joint.fit);
  joint.domain = certifyDomain(joint.camera(), joint.imageSize());
  Uncertainty& known = joint.uncertainty;
  if (covariance.isKnown()) {
    const Eigen::Index at = jointColumns(rig).params[camera];
    const auto size = static_cast<Eigen::Index>(onlyCamera(joint.fit).numLensParams());
    known.covariance = covariance.matrix.view().block(at, at, size, size);
    for (std::size_t i = 0; i < known.pupil_std_m.size(); ++i) {
      const Eigen::Index of_pupil = at + size + static_cast<Eigen::Index>(i);
      known.pupil_std_m[i] = std::sqrt(covariance.matrix.view()(of_pupil, of_pupil));
    }
    known.coordinate_sigma_px = sigma_px;  // noise level of the joint covariance
    known.by_views.reset();
    known.ignored_bend.reset();
    known.ignored_stretches = {};  // part of the rig's covariance
    const std::vector<AnyCamera> others = mapped(known.other_optima, [&](const OtherOptimum& other) {
      return cameraOf(onlyCamera(joint.fit).model, other.params);
    });
    // A lens that its own views do not determine has no pixel grid yet.
    if (known.accuracy) known.accuracy = accuracyOf(joint.fit, known, others, distance_m);
  }
  joint.diagnoses = judge(joint, tolerance_px);
  return joint;
}

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
  return LensMisfit{.effect_px = difference.p95_px,
                    .sure_px = significance->sure_p95_px,
                    .freed_rms_px = rig.cameras[camera].rms_px};
}

}  // namespace alidade
