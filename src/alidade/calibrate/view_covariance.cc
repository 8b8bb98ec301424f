// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "alidade/calibrate/distributions.h"
#include "alidade/calibrate/scaled_inverse.h"

namespace alidade {
namespace {

// A view in coordinates in which all views together say the same in every direction: it says the share S of
// it, between 0 and 1.
struct Share {
  Eigen::MatrixXd S;
  Eigen::MatrixXd lift;  // what makes up for the fit's having been drawn towards the view
  Eigen::VectorXd pull;  // lifted
};

Share shareOf(const ViewPull& view, const Eigen::MatrixXd& basis) {
  // What a view determines all by itself, no other disagrees with, and its pull there is rounding.
  constexpr double kAlone = 1e-4;
  Share share;
  share.S = basis.transpose() * view.information * basis;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(share.S);
  // Under independent noise the pull has the covariance S - S^2, and would have S without the fit.
  const Eigen::VectorXd rest = (1 - solver.eigenvalues().array()).max(kAlone).rsqrt();
  share.lift = solver.eigenvectors() * rest.asDiagonal() * solver.eigenvectors().transpose();
  share.pull = share.lift * (basis.transpose() * view.gradient);
  return share;
}

// The variance of `contrast` by views is the sum over the views of the squares of p_v = a_v . pull_v. Under
// independent noise these have the covariance G_vw = a_v . (S_v [v = w] - S_v S_w) a_w, and the sum is that
// of (trace G)^2 / trace G^2 squares of equal variance (Satterthwaite).
double freedomOf(std::span<const Share> shares, const Eigen::VectorXd& contrast) {
  const Eigen::Index m = contrast.size();
  Eigen::MatrixXd QQ = Eigen::MatrixXd::Zero(m, m);
  double trace = 0;
  double trace_of_square = 0;
  for (const Share& share : shares) {
    const Eigen::VectorXd a = share.lift * contrast;
    const Eigen::VectorXd q = share.S * a;
    const double own = a.dot(q);
    const double less = q.squaredNorm();
    trace += own - less;
    trace_of_square += own * own - 2 * own * less;
    QQ.noalias() += q * q.transpose();
  }
  trace_of_square += QQ.squaredNorm();
  return trace > 0 && trace_of_square > 0 ? trace * trace / trace_of_square : 0.0;
}

double inflation(double freedom) {
  return studentT95(freedom) / kNormal95;
}

// In every direction the larger of two covariances, of which the first is `variance` times the identity.
Eigen::MatrixXd larger(double variance, const Eigen::MatrixXd& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  const Eigen::VectorXd values = solver.eigenvalues().cwiseMax(variance);
  return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace

double ViewCovariance::effectiveStd(int i) const {
  const double variance = covariance(i, i);
  return variance > 0 ? inflation(freedom(i)) * std::sqrt(variance) : 0.0;
}

std::optional<ViewCovariance> viewCovariance(std::span<const ViewPull> pulls,
                                             const Eigen::MatrixXd& directions, int num_params,
                                             double variance, double mean_slope) {
  const Eigen::Index m = directions.cols();
  if (m == 0 || static_cast<Eigen::Index>(pulls.size()) <= m) return std::nullopt;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (const ViewPull& view : pulls) information += directions.transpose() * view.information * directions;
  const auto inverse = scaledInverse(information).inverse;
  if (!inverse) return std::nullopt;
  const Eigen::MatrixXd basis = directions * Eigen::MatrixXd(inverse->llt().matrixL());

  std::vector<Share> shares;
  shares.reserve(pulls.size());
  Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(m, m);
  double squares_of_shares = 0;
  for (const ViewPull& view : pulls) {
    shares.push_back(shareOf(view, basis));
    meat.noalias() += shares.back().pull * shares.back().pull.transpose();
    squares_of_shares += shares.back().S.squaredNorm();
  }
  meat /= mean_slope * mean_slope;

  ViewCovariance result;
  const Eigen::MatrixXd root = basis.topRows(num_params);
  result.covariance = root * meat * root.transpose();
  result.freedom.resize(num_params);
  double most = 1;
  for (int i = 0; i < num_params; ++i) {
    result.freedom(i) = freedomOf(shares, root.row(i).transpose());
    if (result.covariance(i, i) > 0) most = std::max(most, inflation(result.freedom(i)));
  }
  result.larger = root * larger(variance, most * most * meat) * root.transpose();
  const auto num_free = static_cast<double>(m);
  result.excess = meat.trace() / (num_free * variance);
  result.excess_sigmas = normalOfMeanSquare(result.excess, num_free * num_free / squares_of_shares);
  return result;
}

}  // namespace alidade
