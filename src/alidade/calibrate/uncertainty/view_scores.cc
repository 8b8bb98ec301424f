// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_scores.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "alidade/adjust/covariance.h"
#include "alidade/calibrate/uncertainty/view_covariance.h"
#include "alidade/core/median.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

// A view beside the others, in coordinates in which noise gives the result the covariance 1.
struct OneView {
  Eigen::MatrixXd S;             // the share that it says of what all say, between 0 and 1
  Eigen::VectorXd move;          // of the result without it
  Eigen::VectorXd disagreement;  // its pull as it would be if the fit had not been drawn towards it
  Eigen::VectorXd pull;          // each element with variance 1 where there is nothing but noise
  double freedom = 0;            // number of directions in which it speaks and others do too
};

OneView oneView(const Eigen::MatrixXd& share, const Eigen::VectorXd& gradient) {
  constexpr double kNothing =
      1e-6;  // share below which a view does not speak, above 1 less which none else does
  const SymmetricEigen solver(share);
  Eigen::VectorXd move = Eigen::VectorXd::Zero(gradient.size());
  Eigen::VectorXd disagreement = move;
  OneView view{.S = share, .move = {}, .disagreement = {}, .pull = move};
  const Eigen::VectorXd g = solver.eigenvectors().transpose() * gradient;
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    const double s = solver.eigenvalues()(i);
    if (s < kNothing || s > 1 - kNothing) continue;
    // The gradient has the variance s (1 - s) because the others have pulled the fit too.
    move(i) = g(i) / (1 - s);
    disagreement(i) = g(i) / std::sqrt(1 - s);
    view.pull(i) = g(i) / std::sqrt(s * (1 - s));
    ++view.freedom;
  }
  view.move = solver.eigenvectors() * move;
  view.disagreement = solver.eigenvectors() * disagreement;
  return view;
}

// How far views disagree by more than noise, in the same coordinates.
class Disagreement {
 public:
  explicit Disagreement(Eigen::Index num_free) : squares_(Eigen::MatrixXd::Zero(num_free, num_free)) {}

  void add(const OneView& view, int sign) {
    squares_ += sign * view.disagreement * view.disagreement.transpose();
    squares_of_shares_ += sign * view.S.squaredNorm();
    num_views_ += sign;
  }

  // The size of a change in the sigmas that the views state: those by noise, or by their disagreement where
  // that is larger beyond chance.
  [[nodiscard]] double sigmas(const Eigen::VectorXd& change) const {
    const Eigen::Index m = squares_.rows();
    const auto num_free = static_cast<double>(m);
    const double excess = squares_.trace() / num_free;
    const bool is_exceeded =
        num_views_ > m &&
        normalOfMeanSquare(excess, num_free * num_free / squares_of_shares_) > kBeyondChance;
    if (!is_exceeded) return change.norm();
    const SymmetricEigen solver(squares_);
    const Eigen::VectorXd along = solver.eigenvectors().transpose() * change;
    return std::sqrt(along.cwiseAbs2().cwiseQuotient(solver.eigenvalues().cwiseMax(1)).sum());
  }

 private:
  Eigen::MatrixXd squares_;
  double squares_of_shares_ = 0;
  Eigen::Index num_views_ = 0;
};

// Scores come from corners weighted by the loss; they are coarser than what the covariance is made of.
std::optional<Eigen::MatrixXd> inverseOf(const Eigen::MatrixXd& matrix) {
  constexpr double kSingular = 1e-12;
  return scaledInverse(matrix, kSingular).inverse;
}

}  // namespace

std::vector<CommonError> commonErrors(std::span<const Reduced> scores, const Eigen::MatrixXd& directions,
                                      double variance) {
  const Eigen::Index n = directions.rows();
  const Eigen::Index m = directions.cols();
  std::vector<CommonError> errors;
  for (std::size_t cause = 0; cause < kCommonCauses.size(); ++cause) {
    Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(n + CommonColumns::size(), m + 1);
    basis.topLeftCorner(n, m) = directions;
    basis(n + static_cast<Eigen::Index>(cause), m) = 1;
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m + 1, m + 1);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(m + 1);
    for (const Reduced& score : scores) {
      information += basis.transpose() * score.information * basis;
      gradient += basis.transpose() * score.gradient;
    }
    const auto inverse = inverseOf(information);
    if (!inverse) continue;
    const Eigen::VectorXd step = -*inverse * gradient;
    double by_views = 0;
    for (const Reduced& score : scores) {
      const Eigen::VectorXd left = basis.transpose() * (score.gradient + score.information * basis * step);
      const double share = inverse->row(m).dot(left);
      by_views += share * share;
    }
    // The step's own freedom makes the views' shares agree a little too well.
    const auto num_views = static_cast<double>(scores.size());
    by_views *= num_views / std::max(1.0, num_views - 1);
    const Eigen::VectorXd params_step = directions * step.head(m);
    errors.push_back({.cause = static_cast<CommonCause>(cause),
                      .value = step(m),
                      .sigma = std::sqrt(std::max(by_views, variance * (*inverse)(m, m))),
                      .params_step = {params_step.begin(), params_step.end()}});
  }
  return errors;
}

std::vector<ViewInfluence> viewInfluences(std::span<const Reduced> scores, const Eigen::MatrixXd& directions,
                                          double variance) {
  const Eigen::Index n = directions.rows();
  const Eigen::Index m = directions.cols();
  if (m == 0) return {};
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(m, m);
  for (const Reduced& score : scores)
    information += directions.transpose() * score.information.topLeftCorner(n, n) * directions;
  const auto inverse = inverseOf(information);
  if (!inverse) return {};
  const Eigen::MatrixXd root = inverse->llt().matrixL();
  // In coordinates in which all views together say the same in every direction, noise has the covariance 1.
  const Eigen::MatrixXd basis = directions * root / std::sqrt(variance);
  std::vector<OneView> views;
  Disagreement all(m);
  std::vector<double> means;  // of the squares that are 1 on average where there is nothing but noise
  for (const Reduced& score : scores) {
    const Eigen::MatrixXd share =
        variance * basis.transpose() * score.information.topLeftCorner(n, n) * basis;
    views.push_back(oneView(share, basis.transpose() * score.gradient.head(n)));
    all.add(views.back(), 1);
    means.push_back(views.back().freedom > 0 ? views.back().pull.squaredNorm() / views.back().freedom : 0.0);
  }
  const double typical = std::max(1.0, medianOf(means));
  std::vector<ViewInfluence> influences;
  for (std::size_t v = 0; v < views.size(); ++v) {
    Disagreement others = all;
    others.add(views[v], -1);
    influences.push_back({.move_sigmas = others.sigmas(views[v].move)});
    if (views[v].freedom > 0)
      influences[v].surprise_sigmas = normalOfMeanSquare(means[v] / typical, views[v].freedom);
  }
  return influences;
}

}  // namespace alidade
