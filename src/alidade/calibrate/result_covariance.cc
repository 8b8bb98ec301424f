// SPDX-License-Identifier: MIT
#include "alidade/calibrate/result_covariance.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/LU>

#include "alidade/calibrate/covariance.h"
#include "alidade/calibrate/shape_information.h"
#include "alidade/calibrate/weak_prior.h"

namespace alidade {
namespace {

// The information whose inverse along the directions is given; it is zero across them.
Eigen::MatrixXd informationOf(const Eigen::MatrixXd& inverse, const Eigen::MatrixXd& directions) {
  if (directions.cols() == 0) return Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  const Eigen::VectorXd squares = directions.colwise().squaredNorm();  // they are orthogonal
  const Eigen::MatrixXd onto = squares.cwiseInverse().asDiagonal() * directions.transpose();
  const Eigen::MatrixXd along = onto * inverse * onto.transpose();
  return onto.transpose() * along.inverse() * onto;
}

// What the prior says of what is free.
Eigen::MatrixXd precisionOn(const Eigen::MatrixXd& directions, const LensPrior& prior) {
  if (prior.isNone()) return Eigen::MatrixXd::Zero(directions.rows(), directions.rows());
  const Eigen::VectorXd squares = directions.colwise().squaredNorm();  // they are orthogonal
  const Eigen::MatrixXd onto = directions * squares.cwiseInverse().asDiagonal() * directions.transpose();
  return onto * prior.precision.asDiagonal() * onto;
}

// What is known of the parameters, by the corners and by the views.
struct Known {
  double variance = 0;               // of the coordinate of a corner of weight 1
  Eigen::MatrixXd information = {};  // by the corners, what else is unknown being free
  std::optional<Eigen::MatrixXd> covariance = {};
  std::optional<ViewCovariance> by_views = {};
};

// The same under the prior.
void hold(const Estimation& e, Known& known) {
  if (e.weak_prior.isNone()) return;
  const auto held =
      HeldCovariance::make(known.information, e.state.params, e.weak_prior, known.variance, e.constraint);
  known.covariance.reset();
  if (!held) known.by_views.reset();
  if (!held) return;
  known.covariance = held->byNoise();
  if (!known.by_views) return;
  known.by_views->covariance = held->byViews(known.by_views->covariance);
  known.by_views->larger = held->byViews(known.by_views->larger);
}

// With the board's shape as it is.
Known withShapeGiven(const Estimation& e, const Eigen::MatrixXd& directions, double variance, double slope,
                     const IntrinsicsInformation& information) {
  Known known{.variance = variance, .information = information.information};
  if (information.inverse) {
    known.covariance = variance * *information.inverse;
    known.by_views =
        viewCovariance(reduced(e.options.model, e.observations, e.state, e.loss, LossWeights::kLeaveOut),
                       directions, static_cast<int>(directions.rows()), variance, slope);
  }
  hold(e, known);
  return known;
}

// With the bend among the unknowns.
Known withShapeFree(const Estimation& e, const Eigen::MatrixXd& directions, double variance, double slope,
                    const ShapeInformation& bent) {
  Known known{.variance = variance,
              .information = informationOf(bent.params_inverse, directions) -
                             precisionOn(directions, e.weak_prior.prior),
              .covariance = variance * bent.params_inverse};
  known.by_views =
      viewCovariance(bent.pulls, withBend(directions), static_cast<int>(directions.rows()), variance, slope);
  hold(e, known);
  return known;
}

// The sigmas of a bend that was estimated: where the views disagree, theirs if larger.
void setBendStd(double variance, const ShapeInformation& bent, CalibrationResult& result) {
  ShapeReport& shape = result.shape;
  shape.std_m = (variance * bent.bend_inverse.diagonal()).cwiseSqrt();
  if (shape.by_views && result.isNoiseExceeded()) shape.std_m = shape.std_m.cwiseMax(shape.by_views->std_m);
}

// Where the views show a bend that the user wants ignored, what is missing is known: the camera with the bend
// has the uncertainty that it states, and the one without lies so far from it.
void allowForIgnoredBend(const Estimation& e, const Eigen::MatrixXd& directions, double variance,
                         double slope, const ShapeInformation& bent, CalibrationResult& result) {
  IgnoredBend& ignored = *result.shape.ignored;
  const Known known = withShapeFree(e, directions, variance * ignored.cost_share, slope, bent);
  ignored.covariance = known.covariance;
  result.by_views = known.by_views;
  if (result.by_views) result.by_views->common_error = ignored.params_step;
}

}  // namespace

void setCovariances(const Estimation& e, const Eigen::MatrixXd& directions, double variance,
                    std::span<const Eigen::Vector2d> weighted_errors, CalibrationResult& result) {
  const IntrinsicsInformation information =
      intrinsicsInformation(e.options.model, e.observations, e.state, e.constraint);
  result.scaled_condition = information.scaled_condition;
  result.free_directions = directions;
  result.information = information.information;
  result.weak_prior = e.weak_prior;
  // Without a corner more than are needed there is no telling how good they are.
  if (!std::isfinite(variance)) return;
  const double slope = meanSlope(weighted_errors, e.loss);
  const bool is_bent = e.shape.is_estimated || e.shape.ignored;
  const auto bent = is_bent ? shapeInformation(e.options.model, e.board, e.observations, e.state, e.loss,
                                               e.constraint, e.weak_prior.prior)
                            : std::nullopt;
  // Without the bend's share the covariance would be too small, so there is none then.
  if (e.shape.is_estimated && !bent) return;
  Known known = e.shape.is_estimated ? withShapeFree(e, directions, variance, slope, *bent)
                                     : withShapeGiven(e, directions, variance, slope, information);
  result.information = known.information;
  result.covariance = std::move(known.covariance);
  result.by_views = std::move(known.by_views);
  if (e.shape.is_estimated) setBendStd(variance, *bent, result);
  if (e.shape.ignored && bent && result.covariance)
    allowForIgnoredBend(e, directions, variance, slope, *bent, result);
}

}  // namespace alidade
