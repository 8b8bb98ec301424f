// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_scores.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/view_pose.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

// One of 400 normal variables exceeds this in absolute value.
constexpr double kOneIn400OfSize = 3.0233414397391377;

// Of the lens, with the entrance pupil as it is.
std::vector<Reduced> weightedPulls(const PosedViews& posed) {
  std::vector<Reduced> pulls = reduced(posed.fit, LossWeights::kLeaveOut);
  const auto n = static_cast<Eigen::Index>(onlyCamera(posed.fit).numLensParams());
  for (Reduced& pull : pulls) {
    pull.information.conservativeResize(n, n);
    pull.gradient.conservativeResize(n);
  }
  for (std::size_t v = 0; v < posed.weights.size(); ++v) {
    pulls[v].information *= posed.weights[v];
    pulls[v].gradient *= posed.weights[v];
  }
  return pulls;
}

// The inverse square roots of the variances; 0 for held parameters, which have no variance.
Eigen::VectorXd scaleOf(const Eigen::MatrixXd& matrix) {
  return matrix.diagonal().unaryExpr([](double x) { return x > 0 ? 1 / std::sqrt(x) : 0.0; });
}

// True if no direction has a negative variance, apart from rounding. Held parameters have none.
bool isCovariance(const Eigen::MatrixXd& matrix) {
  constexpr double kRounding = 1e-9;
  if (!matrix.allFinite() || !(matrix.diagonal().minCoeff() >= 0)) return false;
  const Eigen::VectorXd scale = scaleOf(matrix);
  const SymmetricEigen solver(scale.asDiagonal() * matrix * scale.asDiagonal());
  return solver.eigenvalues()(0) >= -kRounding * static_cast<double>(matrix.rows());
}

// One of few views may determine nearly all of a change, and only the jackknife's lift makes its disagreement
// with the others large enough. With more views this lift would leave the test without power.
PullLift liftFor(std::size_t num_views) {
  constexpr std::size_t kFew = 8;
  return num_views < kFew ? PullLift::kLeaveOneOut : PullLift::kForNoise;
}

// The views' pulls after a step of the camera, to first order.
std::vector<Reduced> pullsAfter(std::vector<Reduced> pulls, const Eigen::VectorXd& step) {
  for (Reduced& pull : pulls) pull.gradient += pull.information * step;
  return pulls;
}

// The pulls of single views, at the camera that fits all of them best.
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

// The directions that the information determines beyond rounding, one per column.
Eigen::MatrixXd determinedDirections(const Eigen::MatrixXd& information) {
  constexpr double kLeast = 1e-10;  // after scaling the parameters alike
  const Eigen::VectorXd scale = scaleOf(information);
  const SymmetricEigen solver(scale.asDiagonal() * information * scale.asDiagonal());
  Eigen::Index first = 0;
  while (first < scale.size() && !(solver.eigenvalues()(first) > kLeast)) ++first;
  return scale.asDiagonal() * solver.eigenvectors().rightCols(scale.size() - first);
}

// Sum of dx^2 + dy^2 over all corners, px^2.
double squaresOf(const PosedViews& posed) {
  double squares = 0;
  for (const FitView& view : posed.fit.views) {
    for (const Eigen::Vector2d& error : view.errors) squares += error.squaredNorm();
  }
  return squares;
}

// Two digits; no exponent for values of 100 and more.
std::string figure(double value) {
  return value < 100 ? fmt::format("{:.2g}", value) : fmt::format("{:.0f}", value);
}

}  // namespace

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
  const double as_it_is = squaresOf(held);
  const double once_freed = std::max(squaresOf(freed), squares_of_finest);
  const double f = (as_it_is - once_freed) / above / (once_freed / below);
  return f > 0 ? normalOfF(f, above, below) : 0.0;
}

std::optional<PosedViews> posedFor(const AnyCamera& camera, PosedViews views) {
  Fit& fit = views.fit;
  const std::vector<double> params = fitParams(camera);
  onlyCamera(fit).params = params;
  for (FitView& view : fit.views) {
    const auto pose =
        refitPose(camera.modelId(), params, cornersOnShape(fit, view), kNoLoss, cameraFromBoard(fit, view));
    if (!pose) return std::nullopt;
    setCameraFromBoard(fit, view, *pose);
    view.errors = viewErrors(fit, view);
  }
  return views;
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

std::optional<StepEstimate> HeldScores::along(const Eigen::VectorXd& direction) const {
  const Eigen::VectorXd all = information_ * direction;
  const double information = direction.dot(all);
  if (!(information > 0)) return std::nullopt;
  StepEstimate estimate{.amount = -direction.dot(gradient_) / information};
  const auto shares = ViewShares::make(pullsAfter(pulls_, estimate.amount * direction), direction, 1, {},
                                       liftFor(pulls_.size()));
  if (!shares) return std::nullopt;
  // The excess over noise varies between directions by about a half (on photographs and on simulated motion),
  // like a variance of eight degrees of freedom. The excess over all directions gets this many, but no more
  // than the views provide. Moderated as in Smyth 2004, Linear models and empirical Bayes methods for
  // assessing differential expression in microarray experiments, Statistical Applications in Genetics and
  // Molecular Biology 3(1), section 3.
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
  // By Satterthwaite; the camera's own variance is known exactly.
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
  // A covariance from a few views always looks uneven over directions; the expected unevenness by chance is
  // subtracted (Fujikoshi 2010, Multivariate statistics, the unbiased estimate of the trace of a covariance
  // squared).
  const auto n = static_cast<double>(pulls_.size()) - 1;
  const double trace = spread_by_images.trace();
  double squares = (spread_by_images * spread_by_images).trace();
  if (is_by_views) squares = n * n / ((n - 1) * (n + 2)) * (squares - trace * trace / n);
  squares += (spread_by_own * (spread_by_own + 2 * spread_by_images)).trace();
  const double above = squares > 0 ? std::clamp(expected * expected / squares, 1.0, num) : num;
  const double share_of_images = variance * factor.solve(one).trace() / num;
  const double num_equal_views = num / shares_->squaresOfShares();  // for equal information
  const double below = above * std::max(1.0, num_equal_views - 1) / (share_of_images * share_of_images);
  const double f = statistic / expected;
  OverallTest test{.sigmas = normalOfF(f, above, below)};
  test.sure_share = std::max(0.0, 1 - std::sqrt(fOfNormal(kNormalOneInThousand, above, below) / f));
  return test;
}

Eigen::VectorXd directionOf(CameraChangeKind change, const AnyCamera& camera) {
  if (change == CameraChangeKind::kDistortion && !modelTraits(camera.modelId()).is_polynomial) return {};
  const Eigen::VectorXd direction = directionsOf(change, camera);
  return direction.isZero(0) ? Eigen::VectorXd() : direction;
}

std::optional<AnyCamera> changed(const AnyCamera& camera, CameraChangeKind change, double amount) {
  const auto given = camera.parameters();
  std::vector<double> params(given.begin(), given.end());
  const Eigen::VectorXd direction = directionOf(change, camera);
  for (std::size_t i = 0; i < params.size() && direction.size() > 0; ++i)
    params[i] += amount * direction(static_cast<Eigen::Index>(i));
  auto result = cameraWith(camera.modelId(), params);
  if (result) result = result->withPupil(camera.pupil());
  return result;
}

std::string complaintOf(CameraChangeKind change, double amount, double std) {
  const double size = std::abs(amount);
  const bool is_too_large = amount < 0;  // the value would have to be reduced
  const auto pixels = [&](const char* what) {
    return fmt::format("{} {} +- {} px too {}", what, figure(size), figure(std),
                       is_too_large ? "large" : "small");
  };
  // For a number that needs a factor, the error is a share of the right value, which is that of the file
  // times this factor.
  const double factor = 1 + amount;
  const auto share = [&](const char* what, const char* large, const char* little) {
    constexpr double kLeastFactor = 0.1;  // below it, such a share is meaningless or negative
    if (factor < kLeastFactor) {
      return fmt::format("{} would have to be {} +- {} times as {}", what, figure(factor), figure(std),
                         large);
    }
    return fmt::format("{} is {} +- {} % too {}", what, figure(100 * (size / factor)),
                       figure(100 * (std / (factor * factor))), is_too_large ? large : little);
  };
  switch (change) {
    case CameraChangeKind::kFocalLength:
      return share("its focal length", "long", "short");
    case CameraChangeKind::kCenterX:
      return pixels("its cx is");
    case CameraChangeKind::kCenterY:
      return pixels("its cy is");
    case CameraChangeKind::kDistortion:
      return share("its distortion", "strong", "weak");
    case CameraChangeKind::kPixelOrigin:
      return pixels("its cx and cy are both");
    default:
      break;
  }
  return "";
}

Eigen::VectorXd amountsToFreed(const AnyCamera& camera, const Eigen::MatrixXd& open,
                               const PosedViews& freed) {
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  const Eigen::VectorXd way = Eigen::Map<const Eigen::VectorXd>(onlyCamera(freed.fit).params.data(), n) -
                              Eigen::Map<const Eigen::VectorXd>(camera.parameters().data(), n);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  for (const Reduced& pull : weightedPulls(freed)) information += pull.information;
  return (open.transpose() * information * open).ldlt().solve(open.transpose() * information * way);
}

std::optional<StepEstimate> refitChange(const AnyCamera& tested, CameraChangeKind change,
                                        const PosedViews& freed, double noise_variance,
                                        const std::optional<DenseMatrix>& covariance) {
  const Eigen::VectorXd direction = directionOf(change, tested);
  if (direction.size() == 0) return std::nullopt;
  const double amount = amountsToFreed(tested, direction, freed)(0);
  const auto camera = changed(tested, change, amount);
  const auto posed = camera ? posedFor(*camera, freed) : std::nullopt;
  const auto scores =
      posed ? HeldScores::make(*camera, *posed, &freed, noise_variance, covariance) : std::nullopt;
  auto estimate = scores ? scores->along(direction) : std::nullopt;
  if (!estimate) return std::nullopt;
  estimate->amount += amount;
  estimate->sigmas = normalOfStudentT(std::abs(estimate->amount) / estimate->std, estimate->freedom);
  estimate->rms_px = rms(posed->fit);
  return estimate;
}

}  // namespace alidade
