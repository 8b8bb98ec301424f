// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "alidade/adjust/errors.h"
#include "alidade/adjust/view_pose.h"
#include "alidade/core/error.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

// Of 400 normal variables one exceeds this in size.
constexpr double kOneIn400OfSize = 3.0233414397391377;

std::vector<Reduced> weightedPulls(const PosedViews& posed) {
  std::vector<Reduced> pulls = reduced(posed.fit, LossWeights::kLeaveOut);
  for (std::size_t v = 0; v < posed.weights.size(); ++v) {
    pulls[v].information *= posed.weights[v];
    pulls[v].gradient *= posed.weights[v];
  }
  return pulls;
}

// Whether no direction has a negative variance, rounding aside. Held parameters have none.
bool isCovariance(const Eigen::MatrixXd& matrix) {
  constexpr double kRounding = 1e-9;
  if (!matrix.allFinite() || !(matrix.diagonal().minCoeff() >= 0)) return false;
  const Eigen::VectorXd scale =
      matrix.diagonal().unaryExpr([](double x) { return x > 0 ? 1 / std::sqrt(x) : 0.0; });
  const SymmetricEigen solver(scale.asDiagonal() * matrix * scale.asDiagonal());
  return solver.eigenvalues()(0) >= -kRounding * static_cast<double>(matrix.rows());
}

// Of few views one may know nearly all of a change: only the jackknife's lift makes its disagreement with the
// others large enough then. Of more views it would accuse hardly any camera, right or wrong.
PullLift liftFor(std::size_t num_views) {
  constexpr std::size_t kFew = 8;
  return num_views < kFew ? PullLift::kLeaveOneOut : PullLift::kForNoise;
}

// The views' pulls once the camera has made a step, to first order.
std::vector<Reduced> pullsAfter(std::vector<Reduced> pulls, const Eigen::VectorXd& step) {
  for (Reduced& pull : pulls) pull.gradient += pull.information * step;
  return pulls;
}

// What the views say beside what all say together, once the camera suits them all best.
std::optional<ViewShares> sharesOf(const std::vector<Reduced>& pulls, const Eigen::MatrixXd& directions) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(directions.cols(), directions.cols());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(directions.cols());
  for (const Reduced& pull : pulls) {
    information += directions.transpose() * pull.information * directions;
    gradient += directions.transpose() * pull.gradient;
  }
  return ViewShares::make(pullsAfter(pulls, -directions * information.ldlt().solve(gradient)), directions, 1,
                          {}, liftFor(pulls.size()));
}

// The directions of which the information says more than rounding does, one a column.
Eigen::MatrixXd determinedDirections(const Eigen::MatrixXd& information) {
  constexpr double kLeast = 1e-10;  // once the parameters are scaled alike
  const Eigen::VectorXd scale =
      information.diagonal().unaryExpr([](double x) { return x > 0 ? 1 / std::sqrt(x) : 0.0; });
  const SymmetricEigen solver(scale.asDiagonal() * information * scale.asDiagonal());
  Eigen::Index first = 0;
  while (first < scale.size() && !(solver.eigenvalues()(first) > kLeast)) ++first;
  return scale.asDiagonal() * solver.eigenvectors().rightCols(scale.size() - first);
}

}  // namespace

Misfit misfitOf(const PosedViews& posed) {
  Misfit misfit;
  std::size_t count = 0;
  for (std::size_t v = 0; v < posed.fit.views.size(); ++v) {
    double squares = 0;
    const auto errors = viewErrors(posed.fit, posed.fit.views[v]);
    for (const Eigen::Vector2d& error : errors) squares += error.squaredNorm();
    misfit.squares += squares;
    count += errors.size();
    misfit.weighted_squares += (posed.weights.empty() ? 1.0 : posed.weights[v]) * squares;
  }
  if (count > 0) misfit.rms_px = std::sqrt(misfit.squares / static_cast<double>(count));
  return misfit;
}

double misfitSigmas(const PosedViews& held, const PosedViews& freed) {
  constexpr double kNumbersPerView = 2;
  constexpr double kNumbersOfAPose = 6;
  double freedom = 0;
  double squares_of_finest = 0;
  for (const FitView& view : held.fit.views) {
    const auto coordinates = 2 * static_cast<double>(view.corners.size());
    freedom += std::clamp(coordinates - kNumbersOfAPose, 0.0, kNumbersPerView);
    squares_of_finest += coordinates * kFinestPx * kFinestPx;
  }
  const auto above = static_cast<double>(onlyCamera(held.fit).params.size());
  const double below = freedom - above;
  if (!(below > 0)) return 0;
  const double as_it_is = misfitOf(held).squares;
  const double once_freed = std::max(misfitOf(freed).squares, squares_of_finest);
  const double f = (as_it_is - once_freed) / above / (once_freed / below);
  return f > 0 ? normalOfF(f, above, below) : 0.0;
}

std::optional<SE3> bestPose(const AnyCamera& camera, std::span<const Observation> corners, HuberLoss loss,
                            std::span<const SE3> starts) {
  std::optional<SE3> best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const SE3& start : starts) {
    const auto pose = refitPose(camera.modelId(), camera.parameters(), corners, loss, start);
    if (!pose) continue;
    const double cost = viewCost(camera.modelId(), camera.parameters(), *pose, corners, loss);
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best = pose;
  }
  return best;
}

double StepEstimate::effectiveStd() const {
  return std * studentT95(freedom) / kNormal95;
}

bool StepEstimate::isSignificant() const {
  return sigmas > kOneIn400OfSize;
}

bool OverallTest::isSignificant() const {
  return sigmas > kNormalOneInThousand;
}

std::optional<HeldScores> HeldScores::make(const AnyCamera& camera, const PosedViews& held,
                                           const PosedViews* freed, double noise_variance,
                                           std::optional<DenseMatrix> covariance) {
  constexpr std::size_t kFewestViews = 3;
  if (held.fit.views.size() < kFewestViews || !(noise_variance > 0)) return std::nullopt;
  HeldScores scores;
  if (covariance && isCovariance(*covariance)) scores.covariance_ = std::move(covariance);
  scores.pulls_ = weightedPulls(held);
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  scores.information_ = scores.noise_ = Eigen::MatrixXd::Zero(n, n);
  scores.gradient_ = Eigen::VectorXd::Zero(n);
  for (std::size_t v = 0; v < scores.pulls_.size(); ++v) {
    const Reduced& pull = scores.pulls_[v];
    scores.information_ += pull.information;
    scores.noise_ += (held.weights.empty() ? 1.0 : held.weights[v]) * noise_variance * pull.information;
    scores.gradient_ += pull.gradient;
  }
  const Eigen::MatrixXd directions = determinedDirections(scores.information_);
  if (directions.cols() == 0) return std::nullopt;
  scores.shares_ = sharesOf(freed != nullptr ? weightedPulls(*freed) : scores.pulls_, directions);
  if (!scores.shares_) return std::nullopt;
  const Eigen::MatrixXd& basis = scores.shares_->basis();
  const double by_noise = (basis.transpose() * scores.noise_ * basis).trace();
  if (by_noise > 0) scores.excess_ = scores.shares_->covariance().trace() / by_noise;
  return scores;
}

double HeldScores::numEqualViews() const {
  return static_cast<double>(shares_->basis().cols()) / shares_->squaresOfShares();
}

std::optional<StepEstimate> HeldScores::along(const Eigen::VectorXd& direction) const {
  const Eigen::VectorXd all = information_ * direction;
  const double information = direction.dot(all);
  if (!(information > 0)) return std::nullopt;
  StepEstimate estimate{.amount = -direction.dot(gradient_) / information};
  const auto shares = ViewShares::make(pullsAfter(pulls_, estimate.amount * direction), direction, 1, {},
                                       liftFor(pulls_.size()));
  if (!shares) return std::nullopt;
  // From direction to direction the excess over noise varies by about a half (on photographs and on simulated
  // motion), as does a variance of eight degrees of freedom: so much the excess of all directions counts, and
  // no more than there are views to disagree. Moderated as by Smyth 2004, Linear models and empirical Bayes
  // methods for assessing differential expression in microarray experiments, Statistical Applications in
  // Genetics and Molecular Biology 3(1), section 3.
  constexpr double kMostFreedomOfAll = 8;
  const double by_noise = direction.dot(noise_ * direction) / (information * information);
  const double by_views = shares->covariance()(0, 0) / information;
  const double freedom_by_views = shares->freedomOf(Eigen::VectorXd::Ones(1));
  const double freedom_of_all =
      excess_ ? std::min(static_cast<double>(pulls_.size()) - 1, kMostFreedomOfAll) : 0.0;
  const double freedom = freedom_by_views + freedom_of_all;
  if (!(freedom > 0)) return std::nullopt;
  const double moderated =
      (freedom_by_views * by_views + freedom_of_all * excess_.value_or(0) * by_noise) / freedom;
  const double of_images = std::max(moderated, by_noise);
  const double own = covariance_ ? all.dot(covariance_->view() * all) / (information * information) : 0.0;
  const double variance = of_images + own;
  if (!(variance > 0)) return std::nullopt;
  estimate.std = std::sqrt(variance);
  // Satterthwaite's, the camera's own variance being known.
  estimate.freedom = freedom * (variance / of_images) * (variance / of_images);
  estimate.sigmas = normalOfStudentT(std::abs(estimate.amount) / estimate.std, estimate.freedom);
  return estimate;
}

OverallTest HeldScores::overall() const {
  // In the basis in which the information is 1.
  const Eigen::MatrixXd& basis = shares_->basis();
  const Eigen::Index m = basis.cols();
  const Eigen::VectorXd x = -basis.transpose() * gradient_;
  const Eigen::MatrixXd by_noise = basis.transpose() * noise_ * basis;
  const Eigen::MatrixXd& by_views = shares_->covariance();
  const bool is_by_views = by_views.trace() > by_noise.trace();
  const Eigen::MatrixXd& of_images = is_by_views ? by_views : by_noise;
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(m, m);
  if (covariance_) own = basis.transpose() * information_ * covariance_->view() * information_ * basis;
  const auto num = static_cast<double>(m);
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(m, m);
  const double variance = of_images.trace() / num;
  const Eigen::MatrixXd assumed = own + variance * one;
  const auto factor = assumed.llt();
  expect(factor.info() == Eigen::Success, "what images leave to chance is a covariance");
  const double statistic = x.dot(factor.solve(x));
  const Eigen::MatrixXd spread_by_own = factor.solve(own);
  const Eigen::MatrixXd spread_by_images = factor.solve(of_images);
  const double expected = (spread_by_own + spread_by_images).trace();
  // Directions always look uneven in a covariance from a few views: what they would do so by chance is taken
  // off (Fujikoshi 2010, Multivariate statistics, the unbiased estimate of the trace of a covariance
  // squared).
  const auto n = static_cast<double>(pulls_.size()) - 1;
  const double trace = spread_by_images.trace();
  double squares = (spread_by_images * spread_by_images).trace();
  if (is_by_views) squares = n * n / ((n - 1) * (n + 2)) * (squares - trace * trace / n);
  squares += (spread_by_own * (spread_by_own + 2 * spread_by_images)).trace();
  const double above = squares > 0 ? std::clamp(expected * expected / squares, 1.0, num) : num;
  const double share_of_images = variance * factor.solve(one).trace() / num;
  const double below = above * std::max(1.0, numEqualViews() - 1) / (share_of_images * share_of_images);
  const double f = statistic / expected;
  OverallTest test{.sigmas = normalOfF(f, above, below)};
  test.sure_share = std::max(0.0, 1 - std::sqrt(fOfNormal(kNormalOneInThousand, above, below) / f));
  return test;
}

}  // namespace alidade
