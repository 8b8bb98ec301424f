// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/shape_information.h"

#include <algorithm>
#include <utility>

#include "alidade/adjust/board/places.h"
#include "alidade/adjust/noise/covariance.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

// Sum over all views.
Reduced sumOf(const std::vector<Reduced>& pulls) {
  Reduced sum = pulls.front();
  for (std::size_t v = 1; v < pulls.size(); ++v) {
    sum.information += pulls[v].information;
    sum.gradient += pulls[v].gradient;
  }
  return sum;
}

// The equations of each place, with columns for the bends of these boards.
std::vector<Reduced> reducedWithBends(const Fit& fit, LossWeights weights,
                                      const std::vector<std::size_t>& boards) {
  std::vector<Reduced> views = mapped(fit.views, [&](const FitView& view) {
    const int num_columns = kNumBends * static_cast<int>(boards.size());
    const auto at = std::ranges::find(boards, view.board);
    const Board* board = at != boards.end() ? &boardOf(fit, view).target : nullptr;
    const int first = kNumBends * static_cast<int>(at - boards.begin());
    return reduced(fit, view, weights, bendColumns(board, first, num_columns));
  });
  return sumByPlace(std::move(views), placesOf(fit));
}

}  // namespace

Eigen::MatrixXd withBends(const Eigen::MatrixXd& directions, Eigen::Index num_columns) {
  const Eigen::Index n = directions.rows();
  const Eigen::Index m = directions.cols();
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n + num_columns, m + num_columns);
  all.topLeftCorner(n, m) = directions;
  all.bottomRightCorner(num_columns, num_columns).setIdentity();
  return all;
}

std::optional<ShapeInformation> shapeInformation(const Fit& fit, const std::vector<std::size_t>& boards) {
  const FitCamera& camera = onlyCamera(fit);
  const LensPrior& prior = camera.weak_prior.prior;
  const auto num_bends = kNumBends * static_cast<Eigen::Index>(boards.size());
  ShapeInformation result;
  result.boards = boards;
  const auto robust_pulls = reducedWithBends(fit, LossWeights::kUse, boards);
  result.pulls = reducedWithBends(fit, LossWeights::kLeaveOut, boards);
  Reduced robust = sumOf(robust_pulls);
  Reduced plain = sumOf(result.pulls);
  result.prior = Eigen::MatrixXd::Zero(plain.information.rows(), plain.information.cols());
  for (std::size_t i = 0; i < prior.precision.size(); ++i)
    result.prior.diagonal()(static_cast<Eigen::Index>(i)) = prior.precision[i];
  for (Reduced* sum : {&robust, &plain}) prior.addTo(camera.params, sum->information, sum->gradient);
  const Eigen::Index num_params = robust.gradient.size() - num_bends;

  // Free directions: those of the intrinsics, and the bends.
  const Eigen::MatrixXd directions =
      withBends(freeDirections(static_cast<int>(num_params), camera.constraint), num_bends);
  const auto robust_inverse = scaledInverse(directions.transpose() * robust.information * directions).inverse;
  const auto plain_inverse = scaledInverse(directions.transpose() * plain.information * directions).inverse;
  if (!robust_inverse || !plain_inverse) return std::nullopt;

  const Eigen::VectorXd gradient = directions.transpose() * robust.gradient;
  const Eigen::VectorXd step = -*robust_inverse * gradient;
  result.step_m = step.tail(num_bends);
  const Eigen::VectorXd change = directions * step;
  result.params_step = change.head(num_params);
  for (std::size_t v = 0; v < result.pulls.size(); ++v)
    result.pulls[v].gradient += robust_pulls[v].information * change;
  result.drop = -gradient.dot(step);
  const Eigen::MatrixXd inverse = directions * *plain_inverse * directions.transpose();
  result.bend_inverse = inverse.bottomRightCorner(num_bends, num_bends);
  result.params_inverse = inverse.topLeftCorner(num_params, num_params);
  return result;
}

}  // namespace alidade
