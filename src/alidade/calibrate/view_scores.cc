// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_scores.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "alidade/calibrate/distributions.h"
#include "alidade/calibrate/reprojection.h"
#include "alidade/calibrate/scaled_inverse.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/median.h"

namespace alidade {
namespace {

template <CameraModel M>
ViewScore scoreOf(const double* params, const SE3& camera_from_board, std::span<const Observation> view,
                  HuberLoss loss) {
  constexpr int kN = kNumParams<M>;
  constexpr int kAll = 6 + kN + 2;  // pose, parameters, stretch, error
  Eigen::Matrix<double, kAll, kAll> gram = Eigen::Matrix<double, kAll, kAll>::Zero();
  const Eigen::Matrix3d R = camera_from_board.rotation.matrix();
  Reprojection<M> corner;
  Eigen::Matrix<double, 2, kAll, Eigen::RowMajor> row;
  for (const Observation& observation : view) {
    if (!reproject<M>(params, R, camera_from_board.translation, observation.p_board, corner)) continue;
    const Eigen::Vector2d error = corner.pixel - observation.pixel;
    row.template leftCols<6>() = corner.J_px_pose;
    row.template middleCols<kN>(6) = corner.J_px_params;
    // The stretch moves the corner along the board's x, as a translation by x does.
    row.col(6 + kN) = corner.J_px_pose.col(0) * observation.p_board.x();
    row.col(6 + kN + 1) = error;
    const double weight = observation.weight * loss.weight(observation.weight * error.squaredNorm());
    gram.noalias() += weight * row.transpose() * row;
  }
  const Eigen::Matrix<double, 6, 6> pose = gram.template topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 6, kN + 2> coupling = gram.template topRightCorner<6, kN + 2>();
  const Eigen::Matrix<double, kN + 2, kN + 2> reduced =
      gram.template bottomRightCorner<kN + 2, kN + 2>() - coupling.transpose() * pose.ldlt().solve(coupling);
  return {.information = reduced.template topLeftCorner<kN + 1, kN + 1>(),
          .gradient = reduced.template topRightCorner<kN + 1, 1>()};
}

// Scores come from corners weighted by the loss; they are coarser than what the covariance is made of.
std::optional<Eigen::MatrixXd> inverseOf(const Eigen::MatrixXd& matrix) {
  constexpr double kSingular = 1e-12;
  return scaledInverse(matrix, kSingular).inverse;
}

}  // namespace

std::vector<ViewScore> viewScores(std::string_view model_id, std::span<const std::vector<Observation>> views,
                                  const BundleState& state, HuberLoss loss) {
  std::vector<ViewScore> scores;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId != model_id) return;
    for (std::size_t v = 0; v < views.size(); ++v)
      scores.push_back(scoreOf<M>(state.params.data(), state.camera_from_board[v], views[v], loss));
  });
  return scores;
}

std::optional<BoardStretch> boardStretch(std::span<const ViewScore> scores, const Eigen::MatrixXd& directions,
                                         double variance) {
  const Eigen::Index n = directions.rows();
  const Eigen::Index m = directions.cols();
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(n + 1, m + 1);
  basis.topLeftCorner(n, m) = directions;
  basis(n, m) = 1;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m + 1, m + 1);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(m + 1);
  for (const ViewScore& score : scores) {
    information += basis.transpose() * score.information * basis;
    gradient += basis.transpose() * score.gradient;
  }
  const auto inverse = inverseOf(information);
  if (!inverse) return std::nullopt;
  const Eigen::VectorXd step = -*inverse * gradient;
  double by_views = 0;
  for (const ViewScore& score : scores) {
    const Eigen::VectorXd left = basis.transpose() * (score.gradient + score.information * basis * step);
    const double share = inverse->row(m).dot(left);
    by_views += share * share;
  }
  // The step's own freedom makes the views' shares agree a little too well.
  const auto num_views = static_cast<double>(scores.size());
  by_views *= num_views / std::max(1.0, num_views - 1);
  return BoardStretch{.stretch = step(m),
                      .sigma = std::sqrt(std::max(by_views, variance * (*inverse)(m, m)))};
}

std::vector<ViewInfluence> viewInfluences(std::span<const ViewScore> scores,
                                          const Eigen::MatrixXd& directions, double variance) {
  const Eigen::Index n = directions.rows();
  const Eigen::Index m = directions.cols();
  if (m == 0) return {};
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (const ViewScore& score : scores)
    information += directions.transpose() * score.information.topLeftCorner(n, n) * directions;
  const auto inverse = inverseOf(information);
  if (!inverse) return {};
  const Eigen::MatrixXd root = inverse->llt().matrixL();
  std::vector<ViewInfluence> influences;
  std::vector<double> means;  // of the squares that are 1 on average where there is nothing but noise
  std::vector<double> freedoms;
  for (const ViewScore& score : scores) {
    // In coordinates in which all views together say the same in every direction, the view says a share of
    // it, and its gradient has the variance share (1 - share) because the others have pulled the fit too.
    const Eigen::MatrixXd basis = directions * root;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        basis.transpose() * score.information.topLeftCorner(n, n) * basis);
    const Eigen::VectorXd gradient =
        solver.eigenvectors().transpose() * (basis.transpose() * score.gradient.head(n));
    constexpr double kNothing =
        1e-6;  // share below which a view does not speak, above 1 less which none else does
    double move = 0;
    double sum = 0;
    double freedom = 0;
    for (Eigen::Index i = 0; i < m; ++i) {
      const double share = solver.eigenvalues()(i);
      if (share < kNothing || share > 1 - kNothing) continue;
      const double square = gradient(i) * gradient(i) / variance;
      move += square / ((1 - share) * (1 - share));
      sum += square / (share * (1 - share));
      ++freedom;
    }
    influences.push_back({.move_sigmas = std::sqrt(move)});
    freedoms.push_back(freedom);
    means.push_back(freedom > 0 ? sum / freedom : 0.0);
  }
  const double typical = std::max(1.0, medianOf(means));
  for (std::size_t v = 0; v < influences.size(); ++v) {
    if (freedoms[v] > 0) influences[v].surprise_sigmas = normalOfMeanSquare(means[v] / typical, freedoms[v]);
  }
  return influences;
}

}  // namespace alidade
