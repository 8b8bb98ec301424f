// SPDX-License-Identifier: MIT
#include "block_arrow.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "alidade/calibrate/pose_elimination.h"
#include "alidade/calibrate/view_kernel.h"
#include "alidade/camera/radtan.h"

namespace alidade {
namespace {

constexpr int kParams = kNumParams<Radtan>;

struct Point {
  BundleState state;
  std::vector<double> pose_rows;
  Eigen::MatrixXd shared = Eigen::MatrixXd(kParams + 1, kParams + 1);  // lower triangle

  [[nodiscard]] double cost() const { return 0.5 * shared(kParams, kParams); }
};

class Solver {
 public:
  Solver(std::span<const std::vector<Observation>> views, const BundleState& start, HuberLoss loss)
      : corners_(views), loss_(loss) {
    at_.state = start;
    at_.pose_rows.resize(views.size() * PoseRowLayout::size(kParams));
    factors_.resize(at_.pose_rows.size());
    trial_ = at_;
  }

  BundleSummary run(BundleState& state) {
    constexpr double kTolerance = 1e-14;  // where solveBundle() stops too
    BundleSummary summary;
    if (!sum(at_)) return summary;
    double radius = 1e4;
    double shrink = 2;
    for (int i = 0; i < BundleOptions().max_iterations; ++i) {
      const double predicted = step(1 / radius);
      summary.cost = at_.cost();
      summary.num_iterations = i;
      if (predicted <= kTolerance * at_.cost()) {
        summary.termination = Termination::kConverged;
        break;
      }
      const double drop = sum(trial_) ? at_.cost() - trial_.cost() : -1;
      if (drop > 0) {
        radius /= std::max(1.0 / 3, 1 - std::pow(2 * drop / predicted - 1, 3));
        shrink = 2;
        std::swap(at_, trial_);
      } else {
        radius /= shrink;
        shrink *= 2;
      }
    }
    state = std::move(at_.state);
    return summary;
  }

 private:
  bool sum(Point& point) const {
    point.shared.setZero();
    for (std::size_t v = 0; v < point.state.camera_from_board.size(); ++v) {
      double* rows = point.pose_rows.data() + v * PoseRowLayout::size(kParams);
      if (!kernel_.sum(point.state.params.data(), point.state.camera_from_board[v], corners_.view(v), loss_,
                       rows, point.shared))
        return false;
    }
    return true;
  }

  // Writes the trial's parameters and poses; by how much the damped model falls.
  double step(double damping) {
    Eigen::MatrixXd schur = at_.shared;
    elimination_.eliminate(at_.pose_rows, damping, factors_, schur);
    Eigen::Matrix<double, kParams, kParams> H = schur.topLeftCorner<kParams, kParams>();
    H.diagonal() += damping * at_.shared.diagonal().head<kParams>();
    const Eigen::Matrix<double, kParams, 1> g = schur.row(kParams).head<kParams>();
    const Eigen::Matrix<double, kParams, 1> dp = -H.selfadjointView<Eigen::Lower>().llt().solve(g);
    for (int i = 0; i < kParams; ++i) {
      const auto k = static_cast<std::size_t>(i);
      trial_.state.params[k] = at_.state.params[k] + dp(i);
    }
    elimination_.step(factors_, 1, {dp.data(), kParams}, at_.state.camera_from_board,
                      trial_.state.camera_from_board);
    return 0.5 * (at_.shared(kParams, kParams) - schur(kParams, kParams) - g.dot(dp));
  }

  const ViewKernel& kernel_ = viewKernel(Radtan::kId);
  const PoseElimination& elimination_ = poseElimination(kParams);
  CornerGroups corners_;
  HuberLoss loss_;
  Point at_;
  Point trial_;
  std::vector<double> factors_;
};

}  // namespace

BundleSummary solveBlockArrow(std::span<const std::vector<Observation>> views, BundleState& state,
                              HuberLoss loss) {
  return Solver(views, state, loss).run(state);
}

}  // namespace alidade
