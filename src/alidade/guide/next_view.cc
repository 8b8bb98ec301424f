// SPDX-License-Identifier: MIT
#include "alidade/guide/next_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "alidade/adjust/corner_groups.h"
#include "alidade/adjust/view_kernel.h"

namespace alidade {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kPartPenalty = 1.1;  // on the standard deviation that a board seen in part leaves
constexpr double kLeastGain = 1e-6;   // relative, below which a view tells nothing

// Larger eigenvalue of the covariance of one pixel with corners of variance 1.
double largerVariance(const Eigen::Ref<const Eigen::MatrixXd>& jacobian, const Eigen::MatrixXd& inverse) {
  double a = 0;
  double b = 0;
  double c = 0;
  for (Eigen::Index i = 0; i < inverse.cols(); ++i) {
    const double u = inverse.col(i).dot(jacobian.col(0));
    const double v = inverse.col(i).dot(jacobian.col(1));
    a += u * jacobian(i, 0);
    b += u * jacobian(i, 1);
    c += v * jacobian(i, 1);
  }
  const double half = 0.5 * (a - c);
  return 0.5 * (a + c) + std::sqrt(half * half + b * b);
}

// The largest variance over the image, pixel by pixel in the order of how often one has decided before.
class WorstPixel {
 public:
  explicit WorstPixel(const Eigen::MatrixXd& jacobians) : jacobians_(jacobians) {
    for (Eigen::Index i = 0; i < jacobians.cols() / 2; ++i) order_.push_back(i);
  }

  // Exact below `limit`, and otherwise some number that is not below it; infinite for a singular information.
  [[nodiscard]] double variance(const Eigen::MatrixXd& information, double limit) {
    cholesky_.compute(information);
    if (cholesky_.info() != Eigen::Success) return kInfinity;
    inverse_.setIdentity(information.rows(), information.cols());
    cholesky_.solveInPlace(inverse_);
    double largest = 0;
    for (std::size_t i = 0; i < order_.size(); ++i) {
      const double variance = largerVariance(jacobians_.middleCols<2>(2 * order_[i]), inverse_);
      if (!(variance < kInfinity)) return kInfinity;
      largest = std::max(largest, variance);
      if (largest < limit) continue;
      // What refuses one candidate is likely to refuse the next.
      std::rotate(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(i),
                  order_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
      return largest;
    }
    return largest;
  }

 private:
  const Eigen::MatrixXd& jacobians_;
  std::vector<Eigen::Index> order_;
  Eigen::LLT<Eigen::MatrixXd> cholesky_;
  Eigen::MatrixXd inverse_;
};

double fillOf(const std::vector<Observation>& corners, ImageSize size) {
  Eigen::AlignedBox2d box;
  for (const Observation& corner : corners) box.extend(corner.pixel);
  const Eigen::Vector2d span = box.sizes();
  return std::max(span.x() / size.width, span.y() / size.height);
}

}  // namespace

Eigen::MatrixXd viewInformation(const AnyCamera& camera, const SE3& camera_from_board,
                                const std::vector<Observation>& corners) {
  const CornerGroups groups{std::span<const Observation>(corners)};
  return paramsInformation(*viewFactor(viewKernel(camera.modelId()), camera.parameters(), camera_from_board,
                                       groups.view(0), kNoLoss, Unseen::kLeaveOut));
}

NextViewSearch::NextViewSearch(const CameraKnowledge& knowledge, const Checkerboard& board,
                               const CandidateLimits& limits)
    : camera_(knowledge.camera),
      size_(knowledge.size),
      board_(board),
      limits_(limits),
      directions_(knowledge.directions),
      sigma_px_(std::sqrt(knowledge.variance)),
      information_(knowledge.directions.transpose() * knowledge.information * knowledge.directions),
      candidates_(viewCandidates(knowledge.camera, knowledge.size, board, limits)) {
  const ProjectionUncertainty uncertainty(camera_, size_, kInfinity);
  const int num_pixels = uncertainty.columns() * uncertainty.rows();
  jacobians_.resize(directions_.cols(), 2 * static_cast<Eigen::Index>(num_pixels));
  Eigen::Index used = 0;
  for (int i = 0; i < num_pixels; ++i) {
    if (!uncertainty.hasRay(i)) continue;
    jacobians_.middleCols<2>(2 * used++) =
        (Eigen::MatrixXd(uncertainty.jacobian(i)) * directions_).transpose();
  }
  jacobians_.conservativeResize(Eigen::NoChange, 2 * used);
  addPriorIfUndetermined();
  for (const ViewCandidate& candidate : candidates_) {
    gains_.emplace_back(directions_.transpose() *
                        viewInformation(camera_, candidate.camera_from_board, candidate.corners) *
                        directions_);
  }
}

void NextViewSearch::addPriorIfUndetermined() {
  // To first order a standard deviation beyond the image says no more than that nothing is known.
  const double diagonal = std::hypot(size_.width, size_.height);
  is_determined_ = worst() < diagonal;
  if (is_determined_ || jacobians_.cols() == 0) return;
  for (Eigen::Index i = 0; i < jacobians_.rows(); ++i) {
    const double px_per_unit = jacobians_.row(i).cwiseAbs().maxCoeff();
    information_(i, i) += px_per_unit * px_per_unit / (diagonal * diagonal);
  }
}

double NextViewSearch::worst() const {
  if (jacobians_.cols() == 0) return std::numeric_limits<double>::quiet_NaN();
  return sigma_px_ * std::sqrt(WorstPixel(jacobians_).variance(information_, kInfinity));
}

std::optional<NextView> NextViewSearch::best() const {
  if (information_.size() == 0 || jacobians_.size() == 0) return std::nullopt;
  WorstPixel worst(jacobians_);
  const double now = worst.variance(information_, kInfinity);
  double best = now * (1 - kLeastGain);  // what is left, with the penalty
  std::optional<std::size_t> chosen;
  Eigen::MatrixXd sum;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const double penalty = candidates_[i].is_whole ? 1 : kPartPenalty * kPartPenalty;
    sum = information_ + gains_[i];
    const double left = penalty * worst.variance(sum, best / penalty);
    if (!(left < best)) continue;
    best = left;
    chosen = i;
  }
  if (!chosen) return std::nullopt;
  const ViewCandidate& candidate = candidates_[*chosen];
  const double penalty = candidate.is_whole ? 1 : kPartPenalty * kPartPenalty;
  return NextView{.camera_from_board = candidate.camera_from_board,
                  .sighting = sightBoard(camera_, board_, candidate.camera_from_board),
                  .fill = fillOf(candidate.corners, size_),
                  .is_whole = candidate.is_whole,
                  .is_on_end = (board_.columns > board_.rows && limits_.is_upright) ||
                               (board_.columns < board_.rows && !limits_.is_upright),
                  .worst_px = sigma_px_ * std::sqrt(best / penalty),
                  .candidate = *chosen};
}

}  // namespace alidade
