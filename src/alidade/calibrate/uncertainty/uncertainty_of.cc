// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/uncertainty_of.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/LU>

#include "alidade/adjust/board/corner_noise.h"
#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/places.h"
#include "alidade/adjust/noise/board_offsets.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/shape_information.h"
#include "alidade/adjust/noise/weak_prior.h"
#include "alidade/calibrate/bend/shape_fit.h"
#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/calibrate/uncertainty/other_optima.h"
#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/calibrate/uncertainty/view_evidence.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/mapped.h"
#include "alidade/core/median.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// The information whose inverse in the given directions is known; zero perpendicular to them.
Eigen::MatrixXd informationOf(const Eigen::MatrixXd& inverse, const Eigen::MatrixXd& directions) {
  if (directions.cols() == 0) return Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  const Eigen::VectorXd squares = directions.colwise().squaredNorm();  // they are orthogonal
  const Eigen::MatrixXd onto = squares.cwiseInverse().asDiagonal() * directions.transpose();
  const Eigen::MatrixXd along = onto * inverse * onto.transpose();
  return onto.transpose() * along.inverse() * onto;
}

// The prior's information in the free directions.
Eigen::MatrixXd precisionOn(const Eigen::MatrixXd& directions, const LensPrior& prior) {
  if (prior.isNone()) return Eigen::MatrixXd::Zero(directions.rows(), directions.rows());
  const Eigen::VectorXd squares = directions.colwise().squaredNorm();  // they are orthogonal
  const Eigen::MatrixXd onto = directions * squares.cwiseInverse().asDiagonal() * directions.transpose();
  return onto * Eigen::Map<const Eigen::VectorXd>(prior.precision.data(), onto.rows()).asDiagonal() * onto;
}

// Replaces the covariances by those under the camera's prior.
void applyPrior(const FitCamera& camera, double variance, ParameterUncertainty& known) {
  if (camera.weak_prior.isNone()) return;
  known.covariance = heldCovariance(known.information, camera, variance);
  if (!known.covariance) known.by_views.reset();
  if (!known.by_views) return;
  for (DenseMatrix* by_views : {&known.by_views->covariance, &known.by_views->larger})
    *by_views = *heldCovariance(known.information, camera, variance, *by_views);
}

// Values of a fit that several stages use.
struct Residuals {
  explicit Residuals(const Fit& fit)
      : directions(
            freeDirections(static_cast<int>(onlyCamera(fit).params.size()), onlyCamera(fit).constraint)),
        weighted(weightedErrors(fit)),
        slope(meanSlope(weighted, fit.loss)) {
    const int num_bends = kNumBends * static_cast<int>(estimatedShapes(fit).size());
    const int num_free =
        static_cast<int>(directions.cols() + 6 * static_cast<Eigen::Index>(fit.views.size())) + num_bends +
        static_cast<int>(std::lround(numFreeOffsets(fit)));
    variance = coordinateVariance(weighted, fit.loss, num_free);
  }
  Eigen::MatrixXd directions;
  std::vector<Eigen::Vector2d> weighted;
  double slope;
  double variance = 0;  // of the coordinate of a corner of weight 1, px^2; infinite if unknown
};

// Adds the effect of the uncertainty of the boards' offsets, see offsetShare().
// @param prior  information in the covariance besides that of the corners
void addOffsets(const Eigen::MatrixXd& share, double variance, const Eigen::MatrixXd& directions,
                const Eigen::MatrixXd& prior, ParameterUncertainty& known) {
  if (share.isZero(0) || !known.covariance) return;
  known.covariance = known.covariance->view() + variance * share;
  known.information = informationOf(known.covariance->view() / variance, directions) - prior;
  if (!known.by_views) return;
  // If views disagree, they know the offsets equally poorly.
  const Eigen::MatrixXd by_views = variance * std::max(1.0, known.by_views->excess) * share;
  known.by_views->covariance = known.by_views->covariance.view() + by_views;
  known.by_views->larger = known.by_views->larger.view() + by_views;
}

// Covariances with the boards' shapes held.
void setShapeGiven(const Fit& fit, const Residuals& residuals, const IntrinsicsInformation& information,
                   const Eigen::MatrixXd& share, ParameterUncertainty& known) {
  const Eigen::MatrixXd& directions = residuals.directions;
  if (information.inverse) {
    known.covariance = residuals.variance * *information.inverse;
    known.by_views = viewCovariance(reducedByPlace(fit, LossWeights::kLeaveOut), directions,
                                    static_cast<int>(directions.rows()), residuals.variance, residuals.slope,
                                    fit.boards.size() == 1);
  }
  addOffsets(share, residuals.variance, directions, Eigen::MatrixXd::Zero(share.rows(), share.cols()), known);
  applyPrior(onlyCamera(fit), residuals.variance, known);
}

// Covariances with the bends free.
void setShapeFree(const Fit& fit, const Residuals& residuals, double variance, const ShapeInformation& bent,
                  const Eigen::MatrixXd& share, ParameterUncertainty& known) {
  const FitCamera& camera = onlyCamera(fit);
  const Eigen::MatrixXd& directions = residuals.directions;
  const Eigen::MatrixXd prior = precisionOn(directions, camera.weak_prior.prior);
  known.information = informationOf(bent.params_inverse, directions) - prior;
  known.covariance = variance * bent.params_inverse;
  known.by_views =
      viewCovariance(bent.pulls, withBends(directions, bent.step_m.size()),
                     static_cast<int>(directions.rows()), variance, residuals.slope, fit.boards.size() == 1);
  addOffsets(share, variance, directions, prior, known);
  applyPrior(camera, variance, known);
}

// The sigmas of estimated bends: by the disagreement of the views if that is larger.
void setBendStd(const Fit& fit, const Residuals& residuals, const ShapeInformation& bent,
                ParameterUncertainty& result) {
  const Eigen::VectorXd all_by_noise = (residuals.variance * bent.bend_inverse.diagonal()).cwiseSqrt();
  for (std::size_t i = 0; i < bent.boards.size(); ++i) {
    const Eigen::Index column = kNumBends * static_cast<Eigen::Index>(i);
    const Eigen::Vector2d by_noise = all_by_noise.segment<kNumBends>(column);
    if (!by_noise.allFinite()) continue;
    Eigen::Vector2d& std_m = result.bend_std_m[bent.boards[i]];
    std_m = by_noise;
    const BoardShape& shape = fit.boards[bent.boards[i]].shape;
    const Eigen::Vector2d step_m = bent.step_m.segment<kNumBends>(column);
    const auto by_views = bendByViews(bent, Eigen::Vector2d(shape.bend_x_m, shape.bend_y_m) + step_m,
                                      residuals.directions, residuals.slope, i);
    if (by_views && result.isNoiseExceeded()) std_m = std_m.cwiseMax(by_views->std_m);
  }
}

ParameterUncertainty parameterUncertainty(const Fit& fit, const Residuals& residuals,
                                          std::optional<IgnoredBend> ignored_bend,
                                          std::vector<Eigen::Vector2d> bend_std_m) {
  const IntrinsicsInformation information = intrinsicsInformation(fit);
  ParameterUncertainty result{.coordinate_sigma_px = std::sqrt(residuals.variance),
                              .ignored_bend = std::move(ignored_bend),
                              .bend_std_m = std::move(bend_std_m),
                              .information = information.information,
                              .free_directions = residuals.directions,
                              .scaled_condition = information.condition};
  // Without redundant corners their accuracy is unknown.
  if (!std::isfinite(residuals.variance)) return result;
  const bool is_estimated = isShapeEstimated(fit);
  const auto bent = is_estimated          ? shapeInformation(fit, estimatedShapes(fit))
                    : result.ignored_bend ? shapeInformation(fit, result.ignored_bend->boards)
                                          : std::nullopt;
  // Without the bends' share the covariance would be too small, so it is omitted.
  if (is_estimated && !bent) return result;
  const auto of_all = offsetShare(fit);
  if (!of_all) return result;
  const Eigen::Index num_params = residuals.directions.rows();
  const Eigen::MatrixXd share = of_all->topLeftCorner(num_params, num_params);
  if (is_estimated) {
    setShapeFree(fit, residuals, residuals.variance, *bent, share, result);
    setBendStd(fit, residuals, *bent, result);
  } else {
    setShapeGiven(fit, residuals, information, share, result);
  }
  if (!result.ignored_bend || !bent || !result.covariance) return result;
  // If the views show bends that the user wants ignored, the error is known: the camera with the bends has
  // its stated uncertainty, and the one without differs from it by a known step.
  IgnoredBend& ignored = *result.ignored_bend;
  ParameterUncertainty with_bend;
  setShapeFree(fit, residuals, residuals.variance * ignored.cost_share, *bent, share, with_bend);
  ignored.covariance = with_bend.covariance;
  result.by_views = with_bend.by_views;
  if (result.by_views) result.by_views->common_error = ignored.params_step;
  return result;
}

// The uncertainty of the lens alone, from that of a lens and its entrance pupil.
ParameterUncertainty withoutPupil(const FitCamera& camera, ParameterUncertainty known) {
  const auto n = static_cast<Eigen::Index>(camera.numLensParams());
  const Eigen::Index num_pupil = known.information.rows() - n;
  if (num_pupil == 0) return known;
  const auto keep = [n](DenseMatrix& matrix) {
    matrix = Eigen::MatrixXd(matrix.view().topLeftCorner(n, std::min<Eigen::Index>(n, matrix.cols())));
  };
  if (known.covariance) {
    for (Eigen::Index i = n; i < n + num_pupil; ++i)
      known.pupil_std_m.push_back(known.parameterStd(static_cast<int>(i)));
    keep(*known.covariance);
  }
  const Eigen::Index num_held = std::ranges::count_if(camera.constraint.held, [n](int i) { return i >= n; });
  const Eigen::Index num_free = num_pupil - num_held;
  Eigen::MatrixXd information = known.information.view().topLeftCorner(n, n);
  if (num_free > 0) {
    const Eigen::MatrixXd own = known.information.view().bottomRightCorner(num_pupil, num_pupil);
    const Eigen::MatrixXd coupling = known.information.view().bottomLeftCorner(num_pupil, n);
    information -= coupling.transpose() * solveSpd(own, coupling);
  }
  known.information = information;
  known.free_directions =
      Eigen::MatrixXd(known.free_directions.view().topLeftCorner(n, known.free_directions.cols() - num_free));
  if (known.by_views) {
    known.by_views->freedom.resize(camera.numLensParams());
    keep(known.by_views->covariance);
    keep(known.by_views->larger);
    if (known.by_views->common_error.rows() > 0) keep(known.by_views->common_error);
  }
  if (known.ignored_bend) {
    keep(known.ignored_bend->params_step);
    if (known.ignored_bend->covariance) keep(*known.ignored_bend->covariance);
  }
  return known;
}

// Corners with equal stated sigmas need no weights; tau is the rest of their variance.
double unexplainedSigma(const Fit& fit, double variance) {
  const CornerNoise& noise = onlyCamera(fit).noise;
  if (!noise.isStated()) return std::numeric_limits<double>::quiet_NaN();
  if (!noise.isUniform()) return noise.unexplainedSigma();
  const double stated = noise.statedVariance(fit.views.front().corners.front().sigma_px);
  return std::sqrt(std::max(0.0, variance - stated));
}

ViewEvidence viewEvidence(const Fit& fit, const Residuals& residuals, double smoothness) {
  const auto scores = viewScores(fit);
  const auto flexible = modelTraits(onlyCamera(fit).model).is_stiff ? flexibleFit(fit) : std::nullopt;
  const double sigma_px = std::sqrt(residuals.variance);
  return {.influences = viewInfluences(scores, residuals.directions, residuals.variance),
          .common_errors = commonErrors(scores, residuals.directions, onlyCamera(fit),
                                        flexible ? viewScores(*flexible) : std::vector<Reduced>(),
                                        residuals.variance, smoothness),
          .variations = viewVariations(fit),
          // Views of several boards in one image are not in succession.
          .focal_step = fit.boards.size() == 1
                            ? focalStep(scores, residuals.directions, onlyCamera(fit), residuals.variance)
                            : std::nullopt,
          .two_cameras = twoCameras(fit, sigma_px * sigma_px)};
}

}  // namespace

void setProjected(const Fit& fit, Uncertainty& known) {
  const AnyCamera camera = cameraOf(fit);
  const Eigen::MatrixXd stated = known.statedCovariance();
  const auto grid = [&](double distance_m) {
    return ProjectionUncertainty(camera, onlyCamera(fit).size, distance_m).grid(stated);
  };
  known.projection_far = grid(std::numeric_limits<double>::infinity());
  known.projection_near = grid(known.board_distance_m);
}

Uncertainty uncertaintyOf(const ModelSolution& solution, const CalibratorOptions& options) {
  const Fit& fit = solution.fit;
  const Residuals residuals(fit);
  const bool is_flat = options.board_shape == BoardShapeMode::kFlat;
  const double local_sigma_px = localSigma(fit);
  const double smoothness = std::fmax(1.0, weightedRms(fit) / std::sqrt(2.0) / local_sigma_px);
  Uncertainty result{
      withoutPupil(onlyCamera(fit),
                   parameterUncertainty(fit, residuals, is_flat ? ignoredBend(fit) : std::nullopt,
                                        mapped(solution.choice.shapes, &ShapeReport::std_m))),
      viewEvidence(fit, residuals, smoothness)};
  result.ignored_stretches = ignoredStretches(fit.boards, result.common_errors);
  includeOffsets(fit, result.common_errors);
  result.unexplained_sigma_px = unexplainedSigma(fit, residuals.variance);
  result.local_sigma_px = local_sigma_px;
  result.smoothness = smoothness;
  result.num_places = numPlaces(fit);
  result.board_distance_m = medianOf(mapped(fit.views, [&](const FitView& view) {
    return (cameraFromBoard(fit, view) * boardOf(fit, view).target.middle()).norm();
  }));
  if (result.covariance) setProjected(fit, result);
  result.other_optima = otherOptima(fit, solution.close_params, result, options.cancel);
  result.holdout =
      solution.holdout ? *solution.holdout : holdoutReport(heldOutErrors(fit, options.jobs, options.cancel));
  result.image_bias = imageBias(fit);
  if (!result.covariance) return result;
  std::vector<AnyCamera> rivals = solution.rivals;
  for (const OtherOptimum& other : result.other_optima)
    rivals.push_back(cameraOf(onlyCamera(fit).model, other.params));
  result.accuracy = accuracyOf(fit, result, rivals, options.distance_m);
  return result;
}

}  // namespace alidade
