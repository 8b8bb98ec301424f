// SPDX-License-Identifier: MIT
#include "block_arrow.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "alidade/calibrate/view_equations.h"
#include "alidade/camera/batch_kernel.h"
#include "alidade/camera/radtan.h"

namespace alidade {
namespace {

constexpr int kParams = kNumParams<Radtan>;
constexpr int kShared = kParams + 1;  // and the error
constexpr int kSize = 6 + kShared;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

struct Arrow {
  Matrix6 pose;                                // of one view
  Eigen::Matrix<double, 6, kShared> coupling;  // its columns by the parameters and the error
};

// Half the sum of rho, or the normal equations of one view.
ALIDADE_ALWAYS_INLINE bool addCost(const detail::ViewCamera<Radtan>& camera,
                                   std::span<const CornerGroup> corners, HuberLoss loss, double& cost) {
  const detail::ViewCamera<Radtan> local = camera;
  Lanes sum = {};
  for (const CornerGroup& group : corners) {
    const detail::GroupProjection at = detail::projectGroup<false>(local, group, nullptr);
    if (!lane::isAll(at.is_seen)) return false;
    const detail::GroupError error(at, group, loss);
    sum += error.rho;
  }
  cost += 0.5 * detail::sumOfLanes(sum);
  return true;
}

struct Loops {
  static bool cost(const detail::ViewCamera<Radtan>& camera, std::span<const CornerGroup> corners,
                   HuberLoss loss, double& cost) {
    return addCost(camera, corners, loss, cost);
  }
  static void equations(const detail::ViewCamera<Radtan>& camera, std::span<const CornerGroup> corners,
                        HuberLoss loss, detail::ViewEquations<Radtan>& to) {
    detail::sumView<Radtan>(camera, corners, loss, Unseen::kLeaveOut, to);
  }
};

#if defined(ALIDADE_HAS_AVX2_VARIANT)
struct LoopsAvx2 {
  ALIDADE_TARGET_AVX2 static bool cost(const detail::ViewCamera<Radtan>& camera,
                                       std::span<const CornerGroup> corners, HuberLoss loss, double& cost) {
    return addCost(camera, corners, loss, cost);
  }
  ALIDADE_TARGET_AVX2 static void equations(const detail::ViewCamera<Radtan>& camera,
                                            std::span<const CornerGroup> corners, HuberLoss loss,
                                            detail::ViewEquations<Radtan>& to) {
    detail::sumView<Radtan>(camera, corners, loss, Unseen::kLeaveOut, to);
  }
};
#endif

template <class Loop>
class Solver {
 public:
  Solver(std::span<const std::vector<Observation>> views, BundleState& state, HuberLoss loss)
      : corners_(views), state_(state), loss_(loss), arrows_(views.size()), trial_(state) {}

  BundleSummary run() {
    // Where solveBundle() stops too.
    constexpr double kTolerance = 1e-14;
    constexpr double kStepTolerance = 1e-12;
    BundleSummary summary;
    double cost = 0;
    if (!totalCost(state_, cost)) return summary;
    double radius = 1e4;
    double shrink = 2;
    bool is_linearized = false;
    for (int i = 0; i < BundleOptions().max_iterations; ++i) {
      if (!is_linearized) linearize();
      is_linearized = true;
      const double predicted = step(1 / radius);
      double trial_cost = 0;
      const bool is_seen = totalCost(trial_, trial_cost);
      summary.num_iterations = i + 1;
      summary.cost = cost;
      const double drop = cost - trial_cost;
      if (step_length_ <= kStepTolerance * length_ || (is_seen && std::abs(drop) <= kTolerance * cost)) {
        if (is_seen && drop > 0) state_ = trial_;
        summary.termination = Termination::kConverged;
        return summary;
      }
      if (is_seen && drop > 0) {
        const double quality = drop / predicted;
        radius /= std::max(1.0 / 3, 1 - std::pow(2 * quality - 1, 3));
        shrink = 2;
        std::swap(state_, trial_);
        cost = trial_cost;
        is_linearized = false;
      } else {
        radius /= shrink;
        shrink *= 2;
      }
    }
    summary.termination = Termination::kIterationLimit;
    return summary;
  }

 private:
  bool totalCost(const BundleState& state, double& cost) const {
    cost = 0;
    for (std::size_t v = 0; v < arrows_.size(); ++v) {
      const detail::ViewCamera<Radtan> camera(state.params.data(), state.camera_from_board[v]);
      if (!Loop::cost(camera, corners_.view(v), loss_, cost)) return false;
    }
    return true;
  }

  void linearize() {
    shared_.setZero();
    for (std::size_t v = 0; v < arrows_.size(); ++v) {
      detail::ViewEquations<Radtan> equations;
      const detail::ViewCamera<Radtan> camera(state_.params.data(), state_.camera_from_board[v]);
      Loop::equations(camera, corners_.view(v), loss_, equations);
      constexpr auto kStride = static_cast<int>(detail::ViewEquations<Radtan>::kStride);
      const Eigen::Map<const Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>, 0,
                       Eigen::OuterStride<kStride>>
          gram(&equations.at(0, 0));
      arrows_[v].pose = gram.topLeftCorner<6, 6>();
      arrows_[v].coupling = gram.topRightCorner<6, kShared>();
      shared_ += gram.bottomRightCorner<kShared, kShared>();
    }
  }

  // Writes the trial state; the drop of the cost that the linear model predicts.
  double step(double damping) {
    constexpr double kMin = 1e-6;  // of a diagonal, as Ceres bounds it
    Eigen::Matrix<double, kShared, kShared> rest = shared_;
    solved_.resize(arrows_.size());
    for (int i = 0; i < kParams; ++i) rest(i, i) += damping * std::max(shared_(i, i), kMin);
    for (std::size_t v = 0; v < arrows_.size(); ++v) {
      Matrix6 damped = arrows_[v].pose;
      damped.diagonal() += damping * damped.diagonal().cwiseMax(kMin);
      const Eigen::LLT<Matrix6> factor(damped);
      solved_[v] = factor.solve(arrows_[v].coupling);
      rest.triangularView<Eigen::Upper>() -= arrows_[v].coupling.transpose().lazyProduct(solved_[v]);
    }
    const Eigen::Matrix<double, kParams, kParams> schur =
        rest.topLeftCorner<kParams, kParams>().selfadjointView<Eigen::Upper>();
    const Eigen::Matrix<double, kParams, 1> dp = -schur.llt().solve(rest.topRightCorner<kParams, 1>());
    // Half of [2 J^T r + damping D d]^T d with its sign turned, as the step solves the damped equations.
    double predicted = -0.5 * shared_.topRightCorner<kParams, 1>().dot(dp);
    for (int i = 0; i < kParams; ++i) {
      predicted += 0.5 * damping * std::max(shared_(i, i), kMin) * dp(i) * dp(i);
      trial_.params[static_cast<std::size_t>(i)] = state_.params[static_cast<std::size_t>(i)] + dp(i);
    }
    double step2 = dp.squaredNorm();
    double length2 = Eigen::Map<const Eigen::VectorXd>(state_.params.data(), kParams).squaredNorm();
    for (std::size_t v = 0; v < arrows_.size(); ++v) {
      const Vector6 dx = -solved_[v].rightCols<1>() - solved_[v].leftCols<kParams>() * dp;
      predicted +=
          -0.5 * arrows_[v].coupling.rightCols<1>().dot(dx) +
          0.5 * damping * (arrows_[v].pose.diagonal().cwiseMax(kMin).array() * dx.array().square()).sum();
      step2 += dx.squaredNorm();
      length2 += 1 + state_.camera_from_board[v].translation.squaredNorm();
      trial_.camera_from_board[v] = state_.camera_from_board[v] * SE3::exp(dx);
    }
    step_length_ = std::sqrt(step2);
    length_ = std::sqrt(length2);
    return predicted;
  }

  CornerGroups corners_;
  BundleState& state_;
  HuberLoss loss_;
  std::vector<Arrow> arrows_;
  std::vector<Eigen::Matrix<double, 6, kShared>> solved_;
  Eigen::Matrix<double, kShared, kShared> shared_;  // upper triangle
  BundleState trial_;
  double step_length_ = 0;  // of the last step, poses by their tangent
  double length_ = 0;       // of all that it changes, a rotation counting 1
};

}  // namespace

BundleSummary solveBlockArrow(std::span<const std::vector<Observation>> views, BundleState& state,
                              HuberLoss loss) {
#if defined(ALIDADE_HAS_AVX2_VARIANT)
  if (batch::usesAvx2()) return Solver<LoopsAvx2>(views, state, loss).run();
#endif
  return Solver<Loops>(views, state, loss).run();
}

}  // namespace alidade
