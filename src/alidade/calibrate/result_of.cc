// SPDX-License-Identifier: MIT
#include "alidade/calibrate/result_of.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/cross_validation.h"
#include "alidade/calibrate/image_bias.h"
#include "alidade/calibrate/local_sigma.h"
#include "alidade/calibrate/other_optima.h"
#include "alidade/calibrate/result_covariance.h"
#include "alidade/core/median.h"
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

ViewResult viewResult(const Estimation& e, std::size_t v) {
  ViewResult view;
  view.image = e.views[v].image;
  view.camera_from_board = settled(e.state.camera_from_board[v]);
  view.num_corners = static_cast<int>(e.errors[v].size());
  view.num_outliers = static_cast<int>(e.views[v].corners.size() - e.errors[v].size());
  double sum = 0;
  for (const auto& error : e.errors[v]) {
    sum += error.squaredNorm();
    view.max_error_px = std::max(view.max_error_px, error.norm());
  }
  view.rms_px = std::sqrt(sum / view.num_corners);
  return view;
}

// Corners that are all stated to be equal need no weights, and tau is what their variance leaves.
double unexplainedSigma(const Estimation& e, double variance) {
  if (!e.noise.isStated()) return std::numeric_limits<double>::quiet_NaN();
  if (!e.noise.isUniform()) return e.noise.unexplainedSigma();
  return std::sqrt(std::max(0.0, variance - e.noise.statedVariance(e.observations[0][0].sigma_px)));
}

void setProjection(const Estimation& e, CalibrationResult& result) {
  std::vector<double> distances;
  const Eigen::Vector3d middle = e.board.middle();
  for (const SE3& pose : e.state.camera_from_board) distances.push_back((pose * middle).norm());
  result.board_distance_m = medianOf(distances);
  if (!result.covariance) return;
  const Eigen::MatrixXd stated = result.statedCovariance();
  const auto grid = [&](double distance_m) {
    return ProjectionUncertainty(result.camera, result.image_size, distance_m).grid(stated);
  };
  result.projection_far = grid(std::numeric_limits<double>::infinity());
  result.projection_near = grid(result.board_distance_m);
}

}  // namespace

CalibrationResult resultOf(const Estimation& e) {
  CalibrationResult result(AnyCamera::make(e.options.model, e.state.params));
  result.image_size = e.views.front().size;
  const std::vector<Eigen::Vector2d> weighted_errors = weightedErrors(e);
  result.local_sigma_px = localSigma(e.board, e.observations, e.errors);
  double sum = 0;
  for (std::size_t v = 0; v < e.views.size(); ++v) {
    result.views.push_back(viewResult(e, v));
    for (const Eigen::Vector2d& error : e.errors[v]) sum += error.squaredNorm();
  }
  result.num_corners = static_cast<int>(weighted_errors.size());
  result.rms_px = std::sqrt(sum / result.num_corners);
  result.weighted_rms_px = std::sqrt(meanWeightedSquare(e));
  result.excluded_views = e.excluded;
  std::sort(result.excluded_views.begin(), result.excluded_views.end(),
            [](const auto& a, const auto& b) { return naturalLess(a.image, b.image); });
  result.repeated_views = e.repeated;
  result.num_misfits = e.misfits.size();
  result.outliers = e.outliers;

  const Eigen::MatrixXd directions = freeDirections(static_cast<int>(e.state.params.size()), e.constraint);
  const int num_bends = e.shape.is_estimated ? kNumBends : 0;
  const int num_free =
      static_cast<int>(directions.cols() + 6 * static_cast<Eigen::Index>(e.views.size())) + num_bends;
  result.held = e.constraint.held;
  const double variance = coordinateVariance(weighted_errors, e.loss, num_free);
  result.coordinate_sigma_px = std::sqrt(variance);
  result.unexplained_sigma_px = unexplainedSigma(e, variance);
  result.shape = e.shape;
  if (e.shape.is_estimated) {
    const BoardShape& shape = e.shape.shape;
    result.shape.bend_share = std::max(std::abs(shape.bend_x_m) / (e.board.square_m * (e.board.columns - 1)),
                                       std::abs(shape.bend_y_m) / (e.board.square_m * (e.board.rows - 1)));
  }
  setCovariances(e, directions, variance, weighted_errors, result);

  const auto scores =
      reduced(e.options.model, e.observations, e.state, e.loss, LossWeights::kUse, StretchColumn{});
  result.board_stretch = boardStretch(scores, directions, variance);
  const auto influences = viewInfluences(scores, directions, variance);
  for (std::size_t v = 0; v < influences.size(); ++v) result.views[v].influence = influences[v];

  result.variations = viewVariations(e.options.model, e.observations, e.state, e.loss);

  setProjection(e, result);
  result.other_optima = otherOptima(e, result);
  result.domain = certifyDomain(result.camera, result.image_size);
  for (std::size_t v = 0; v < e.views.size(); ++v) {
    for (const Observation& observation : e.observations[v]) {
      const Projection projection = result.camera.project(e.state.camera_from_board[v] * observation.p_board);
      if (!projection.ok()) ++result.num_corners_outside;
    }
  }
  result.holdout = holdoutReport(heldOutErrors(
      e.options.model, e.board.square_m, e.observations, e.state,
      {.loss = e.loss, .constraint = e.constraint, .prior = e.weak_prior.prior, .cancel = e.options.cancel}));
  result.image_bias =
      imageBias(e.options.model, result.image_size, e.observations, e.state, e.loss, e.constraint);
  result.solver = e.summary;
  result.start = e.start_report;
  result.loss = e.loss;
  result.is_settled = e.is_settled;
  return result;
}

}  // namespace alidade
