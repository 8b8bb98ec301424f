// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>
#include <vector>

#include "alidade/adjust/noise/view_shares.h"
#include "alidade/calibrate/uncertainty/view_evidence.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr std::size_t kFewestViews = 10;
constexpr std::size_t kFewestBeside = 3;  // on each side
constexpr std::size_t kMostPlaces = 32;   // where a step is looked for

// Estimates steps of the focal length with the intrinsics free.
class StepEstimate {
 public:
  StepEstimate(std::span<const Reduced> scores, const Eigen::MatrixXd& directions, const FitCamera& camera,
               double variance)
      : variance_(variance) {
    const Eigen::Index n = directions.rows();
    Eigen::VectorXd focal = Eigen::VectorXd::Zero(n);
    focal.head<2>() << camera.params[0], camera.params[1];
    basis_.resize(n, directions.cols() + 1);
    basis_ << directions, focal;
    information_ = Eigen::MatrixXd::Zero(directions.cols(), directions.cols());
    for (const Reduced& score : scores) {
      views_.push_back({.information = basis_.transpose() * score.information.topLeftCorner(n, n) * basis_,
                        .gradient = basis_.transpose() * score.gradient.head(n)});
      information_ += views_.back().information.topLeftCorner(information_.rows(), information_.cols());
    }
    inverse_ = scaledInverseSpd(information_);
  }

  [[nodiscard]] std::optional<FocalStep> at(std::size_t first) const {
    if (!inverse_) return std::nullopt;
    const Eigen::Index m = inverse_->cols();
    Reduced after{.information = Eigen::MatrixXd::Zero(m + 1, m + 1),
                  .gradient = Eigen::VectorXd::Zero(m + 1)};
    for (std::size_t v = first; v < views_.size(); ++v) {
      after.information += views_[v].information;
      after.gradient += views_[v].gradient;
    }
    // The intrinsics follow the step.
    const Eigen::VectorXd follows = -(*inverse_ * after.information.col(m).head(m));
    const double information = after.information(m, m) + follows.dot(after.information.col(m).head(m));
    constexpr double kSingular = 1e-9;
    if (!(information > kSingular * after.information(m, m))) return std::nullopt;
    const double share = -after.gradient(m) / information;  // the gradient of the intrinsics is zero
    Eigen::RowVectorXd pulls(std::ssize(views_));
    double own = 0;  // information of the views, and its squares
    double squares_of_own = 0;
    for (Eigen::Index v = 0; v < pulls.size(); ++v) {
      Eigen::VectorXd along(m + 1);
      along << follows, (v >= static_cast<Eigen::Index>(first) ? 1.0 : 0.0);
      const Reduced& view = views_[static_cast<std::size_t>(v)];
      const Eigen::VectorXd pull = view.information * along;
      pulls(v) = along.dot(view.gradient) + along.dot(pull) * share;
      own += along.dot(pull);
      squares_of_own += along.dot(pull) * along.dot(pull);
    }
    const double serial_factor = serialFactor(pulls);
    const double freedom = own * own / squares_of_own / serial_factor - 1;
    const double size = std::abs(share) * information;
    const double by_views = size / std::sqrt(serial_factor * pulls.squaredNorm());
    return FocalStep{.first_view = first,
                     .share = share,
                     .sigmas = std::min(freedom > 0 ? normalOfStudentT(by_views, freedom) : 0.0,
                                        size / std::sqrt(variance_ * information))};
  }

 private:
  double variance_;
  Eigen::MatrixXd basis_;  // the free directions, and both focal lengths in proportion
  std::vector<Reduced> views_;
  Eigen::MatrixXd information_;
  std::optional<Eigen::MatrixXd> inverse_;
};

}  // namespace

std::optional<FocalStep> focalStep(std::span<const Reduced> scores, const Eigen::MatrixXd& directions,
                                   const FitCamera& camera, double variance) {
  std::optional<FocalStep> surest;
  const ParamConstraint& constraint = camera.constraint;
  const bool is_focal_free = directions.cols() > 0 && !constraint.holds(0) && !constraint.holds(1);
  if (!is_focal_free || !camera.weak_prior.isNone() || scores.size() < kFewestViews) return surest;
  const StepEstimate estimate(scores, directions, camera, variance);
  const std::size_t stride = (scores.size() + kMostPlaces - 1) / kMostPlaces;
  for (std::size_t first = kFewestBeside; first + kFewestBeside <= scores.size(); first += stride) {
    const auto step = estimate.at(first);
    if (step && (!surest || step->sigmas > surest->sigmas)) surest = step;
  }
  return surest;
}

}  // namespace alidade
