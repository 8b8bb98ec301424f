// SPDX-License-Identifier: MIT
#include "alidade/rig/joint_camera.h"

#include <algorithm>
#include <vector>

#include "alidade/adjust/noise/joint_information.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

// The camera's views and boards in the rig's fit, in units of its own fit, whose weights are relative.
void setFit(const RigCalibration& rig, std::size_t camera, double variance, Fit& fit) {
  onlyCamera(fit).params = rig.fit.cameras[camera].params;
  fit.boards = rig.fit.boards;
  for (FitBoard& board : fit.boards) {
    if (board.isUneven()) *board.offset_precision *= variance;
  }
  auto own = fit.views.begin();
  for (const FitView& view : rig.fit.views) {
    if (view.camera != camera) continue;
    own->corners = view.corners;
    own->errors = view.errors;
    for (Observation& corner : own->corners) corner.weight *= variance;
    setCameraFromBoard(fit, *own, cameraFromBoard(rig.fit, view));
    ++own;
  }
}

}  // namespace

Calibration jointCamera(const RigCalibration& rig, std::size_t camera, double tolerance_px,
                        double distance_m) {
  Calibration joint = rig.cameras[camera].alone;
  const double sigma_px = std::max(joint.uncertainty.coordinate_sigma_px, kMinSigmaPx);
  setFit(rig, camera, sigma_px * sigma_px, joint.fit);
  joint.domain = certifyDomain(joint.camera(), joint.imageSize());
  Uncertainty& known = joint.uncertainty;
  if (rig.covariance.rows() > 0) {
    const Eigen::Index at = jointColumns(rig.fit).params[camera];
    const auto size = static_cast<Eigen::Index>(onlyCamera(joint.fit).params.size());
    known.covariance = rig.covariance.view().block(at, at, size, size);
    known.coordinate_sigma_px = sigma_px;  // that the joint covariance is for
    known.by_views.reset();
    known.ignored_bend.reset();
    const std::vector<AnyCamera> others = mapped(known.other_optima, [&](const OtherOptimum& other) {
      return AnyCamera::make(onlyCamera(joint.fit).model, other.params);
    });
    // A lens that its own views leave open has no grid of pixels yet.
    if (known.accuracy) known.accuracy = accuracyOf(joint.fit, known, others, distance_m);
  }
  joint.diagnoses = judge(joint, tolerance_px);
  return joint;
}

}  // namespace alidade
