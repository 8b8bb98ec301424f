// SPDX-License-Identifier: MIT
#include "alidade/adjust/shape_information.h"

#include "alidade/adjust/covariance.h"
#include "alidade/adjust/places.h"

namespace alidade {
namespace {

// All views together.
Reduced sumOf(const std::vector<Reduced>& pulls) {
  Reduced sum = pulls.front();
  for (std::size_t v = 1; v < pulls.size(); ++v) {
    sum.information += pulls[v].information;
    sum.gradient += pulls[v].gradient;
  }
  return sum;
}

}  // namespace

Eigen::MatrixXd withBend(const Eigen::MatrixXd& directions) {
  const Eigen::Index n = directions.rows();
  const Eigen::Index m = directions.cols();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n + kNumBends, m + kNumBends);
  all.topLeftCorner(n, m) = directions;
  all.bottomRightCorner<kNumBends, kNumBends>().setIdentity();
  return all;
}

std::optional<ShapeInformation> shapeInformation(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  const LensPrior& prior = camera.weak_prior.prior;
  const BendColumns bends{onlyBoard(fit).target};
  ShapeInformation result;
  const auto robust_pulls = reducedByPlace(fit, LossWeights::kUse, bends);
  result.pulls = reducedByPlace(fit, LossWeights::kLeaveOut, bends);
  Reduced robust = sumOf(robust_pulls);
  Reduced plain = sumOf(result.pulls);
  result.prior = Eigen::MatrixXd::Zero(plain.information.rows(), plain.information.cols());
  for (std::size_t i = 0; i < prior.precision.size(); ++i)
    result.prior.diagonal()(static_cast<Eigen::Index>(i)) = prior.precision[i];
  for (Reduced* sum : {&robust, &plain}) prior.addTo(camera.params, sum->information, sum->gradient);
  const Eigen::Index num_params = robust.gradient.size() - kNumBends;

  // What may move: the free directions of the intrinsics, and the bend.
  const Eigen::MatrixXd directions =
      withBend(freeDirections(static_cast<int>(num_params), camera.constraint));
  const auto robust_inverse = scaledInverse(directions.transpose() * robust.information * directions).inverse;
  const auto plain_inverse = scaledInverse(directions.transpose() * plain.information * directions).inverse;
  if (!robust_inverse || !plain_inverse) return std::nullopt;

  const Eigen::VectorXd gradient = directions.transpose() * robust.gradient;
  const Eigen::VectorXd step = -*robust_inverse * gradient;
  result.step_m = step.tail<kNumBends>();
  const Eigen::VectorXd change = directions * step;
  result.params_step = change.head(num_params);
  for (std::size_t v = 0; v < result.pulls.size(); ++v)
    result.pulls[v].gradient += robust_pulls[v].information * change;
  result.drop = -gradient.dot(step);
  const Eigen::MatrixXd inverse = directions * *plain_inverse * directions.transpose();
  result.bend_inverse = inverse.bottomRightCorner<kNumBends, kNumBends>();
  result.params_inverse = inverse.topLeftCorner(num_params, num_params);
  return result;
}

}  // namespace alidade
