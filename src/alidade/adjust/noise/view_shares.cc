// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/view_shares.h"

#include <algorithm>

#include "alidade/adjust/noise/covariance.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {

double serialFactor(const Eigen::MatrixXd& pulls) {
  constexpr double kBeyondChance = 3;  // standard deviations if views are independent
  constexpr double kMostAlike = 0.95;  // correlation of neighbours; more would be a trend
  const Eigen::Index n = pulls.cols();
  if (n < 2) return 1;
  const Eigen::RowVectorXd products =
      pulls.leftCols(n - 1).cwiseProduct(pulls.rightCols(n - 1)).colwise().sum();
  if (!(products.sum() > kBeyondChance * products.norm())) return 1;
  const double measured = products.sum() / pulls.squaredNorm();
  // Pulls add up to zero, so they look less alike than they are (Kendall 1954, Note on bias in the estimation
  // of autocorrelation, Biometrika 41(3/4)).
  const double alike = std::min(kMostAlike, measured + (1 + 3 * measured) / static_cast<double>(n));
  return (1 + alike) / (1 - alike);
}

std::optional<ViewShares> ViewShares::make(std::span<const Reduced> pulls, const Eigen::MatrixXd& directions,
                                           double mean_slope, const Eigen::MatrixXd& prior, PullLift lift) {
  const Eigen::Index m = directions.cols();
  if (m == 0) return std::nullopt;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (const Reduced& view : pulls) information += directions.transpose() * view.information * directions;
  if (prior.size() > 0) information += directions.transpose() * prior * directions;
  const auto inverse = scaledInverse(information).inverse;
  if (!inverse) return std::nullopt;

  ViewShares result;
  result.basis_ = directions * choleskyOf(*inverse);
  result.shares_.reserve(pulls.size());
  result.covariance_ = Eigen::MatrixXd::Zero(m, m);
  for (const Reduced& view : pulls) {
    result.shares_.push_back(shareOf(view, result.basis_, lift));
    result.covariance_.noalias() += result.shares_.back().pull * result.shares_.back().pull.transpose();
  }
  result.covariance_ /= mean_slope * mean_slope;
  return result;
}

ViewShares::Share ViewShares::shareOf(const Reduced& view, const Eigen::MatrixXd& basis, PullLift lift) {
  // No other view can disagree in a direction that one view alone determines, so its pull there is only
  // rounding.
  constexpr double kAlone = 1e-4;
  constexpr double kAloneLeftOut = 1e-2;  // larger, because this lift grows faster
  Share share;
  share.S = basis.transpose() * view.information * basis;
  const SymmetricEigen solver(share.S);
  // Under independent noise the pull has the covariance S - S^2; without the fit it would be S.
  const Eigen::ArrayXd rest = 1 - solver.eigenvalues().array();
  Eigen::VectorXd lifts = rest.max(kAlone).rsqrt();
  if (lift == PullLift::kLeaveOneOut) lifts = rest.max(kAloneLeftOut).inverse();
  share.lift = solver.eigenvectors() * lifts.asDiagonal() * solver.eigenvectors().transpose();
  share.pull = share.lift * (basis.transpose() * view.gradient);
  return share;
}

// The variance of `contrast` by views is the sum over the views of the squares of p_v = a_v . pull_v. Under
// independent noise, these have the covariance G_vw = a_v . (S_v [v = w] - S_v S_w) a_w, and the sum has the
// distribution of (trace G)^2 / trace G^2 squares of equal variance (Satterthwaite).
double ViewShares::freedomOf(const Eigen::VectorXd& contrast) const {
  const Eigen::Index m = contrast.size();
  Eigen::MatrixXd QQ = Eigen::MatrixXd::Zero(m, m);
  double trace = 0;
  double trace_of_square = 0;
  for (const Share& share : shares_) {
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

Eigen::MatrixXd ViewShares::pulls() const {
  Eigen::MatrixXd all(basis_.cols(), std::ssize(shares_));
  for (Eigen::Index v = 0; v < all.cols(); ++v) all.col(v) = shares_[static_cast<std::size_t>(v)].pull;
  return all;
}

double ViewShares::squaresOfShares() const {
  double sum = 0;
  for (const Share& share : shares_) sum += share.S.squaredNorm();
  return sum;
}

}  // namespace alidade
