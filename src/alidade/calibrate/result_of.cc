// SPDX-License-Identifier: MIT
#include "alidade/calibrate/result_of.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "alidade/adjust/errors.h"
#include "alidade/adjust/model_soundness.h"
#include "alidade/calibrate/clean/view_reason.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// At rest under normalisation, which reading a file does: what was written is then read back the same.
SE3 settled(SE3 pose) {
  constexpr int kEnough = 16;  // each round has about an even chance
  for (int i = 0; i < kEnough; ++i) {
    const SO3 next = SO3::fromQuaternion(pose.rotation.quaternion());
    if (next.quaternion().coeffs() == pose.rotation.quaternion().coeffs()) break;
    pose.rotation = next;
  }
  return pose;
}

ViewResult viewResult(const Fit& fit, const FitView& of, const View& given) {
  ViewResult view;
  view.image = given.image;
  view.camera_from_board = settled(cameraFromBoard(fit, of));
  view.num_corners = static_cast<int>(of.errors.size());
  view.num_outliers = static_cast<int>(given.corners.size() - of.errors.size());
  double sum = 0;
  for (const auto& error : of.errors) {
    sum += error.squaredNorm();
    view.max_error_px = std::max(view.max_error_px, error.norm());
  }
  view.rms_px = std::sqrt(sum / view.num_corners);
  return view;
}

EstimatedShape shapeOf(const ModelSolution& solution, const Uncertainty& known) {
  const FitBoard& board = onlyBoard(solution.fit);
  EstimatedShape shape;
  static_cast<ShapeReport&>(shape) = solution.shape;
  shape.is_estimated = isShapeEstimated(solution.fit);
  if (!shape.is_estimated) return shape;
  shape.shape = board.shape;
  if (known.bend_std_m.allFinite()) shape.std_m = known.bend_std_m;
  const Checkerboard& target = board.target;
  shape.bend_share = std::max(std::abs(shape.shape.bend_x_m) / (target.square_m * (target.columns - 1)),
                              std::abs(shape.shape.bend_y_m) / (target.square_m * (target.rows - 1)));
  return shape;
}

}  // namespace

CalibrationResult resultOf(const ModelSolution& solution, const PreparedViews& given,
                           const CalibratorOptions& options) {
  const Fit& fit = solution.fit;
  const FitCamera& camera = onlyCamera(fit);
  CalibrationResult result(AnyCamera::make(camera.model, camera.params));
  static_cast<Uncertainty&>(result) =
      uncertaintyOf(fit, options.board_shape == BoardShapeMode::kFlat ? ignoredBend(fit) : std::nullopt,
                    solution.close_params, options.cancel);
  result.image_size = camera.size;
  for (std::size_t v = 0; v < fit.views.size(); ++v) {
    result.views.push_back(viewResult(fit, fit.views[v], given.views[fit.views[v].source]));
    if (!result.influences.empty()) result.views.back().influence = result.influences[v];
  }
  result.num_corners = static_cast<int>(numCorners(fit));
  result.rms_px = rms(fit);
  result.weighted_rms_px = weightedRms(fit);
  result.excluded_views = given.excluded;
  std::vector<ExcludedView> misfits = misfitsOf(fit, given, options.cancel);
  result.num_misfits = misfits.size();
  std::move(misfits.begin(), misfits.end(), std::back_inserter(result.excluded_views));
  std::sort(result.excluded_views.begin(), result.excluded_views.end(),
            [](const auto& a, const auto& b) { return naturalLess(a.image, b.image); });
  result.repeated_views = given.repeated;
  result.outliers = outliersOf(fit, given);
  result.held = camera.constraint.held;
  result.shape = shapeOf(solution, result);
  result.weak_prior = camera.weak_prior;
  result.domain = certifyDomain(result.camera, result.image_size);
  result.num_corners_outside = static_cast<int>(numCornersOutside(fit, result.camera));
  result.solver = fit.summary;
  result.start = solution.start;
  result.loss = fit.loss;
  result.is_settled = solution.is_settled;
  return result;
}

}  // namespace alidade
