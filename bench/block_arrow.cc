// SPDX-License-Identifier: MIT
#include "block_arrow.h"

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "alidade/adjust/corner_groups.h"
#include "alidade/adjust/view_kernel.h"

namespace alidade {
namespace {

constexpr int kParams = 9;

// The normal equations at some point, poses eliminated.
struct Point {
  std::vector<double> params;
  std::vector<SE3> poses;
  std::vector<PoseRows> rows;
  SharedSums sums{kParams};
  double cost = 0;
};

class Solver {
 public:
  explicit Solver(const Fit& fit) : loss_(fit.loss) {
    for (const FitView& view : fit.views) corners_.emplace_back(view.corners);
  }

  // False where a corner does not project.
  bool evaluate(Point& at) const {
    at.sums = SharedSums(kParams);
    at.rows.resize(corners_.size(), PoseRows(6, kParams + 7));
    double squares = 0;
    for (std::size_t v = 0; v < corners_.size(); ++v) {
      if (!kernel_.reduce(at.params.data(), at.poses[v], corners_[v].view(0), loss_, Unseen::kRefuse,
                          at.rows[v], at.sums))
        return false;
      squares += at.rows[v].col(6 + kParams).squaredNorm();
    }
    at.cost = 0.5 * (at.sums.gram(kParams, kParams) + squares);
    return true;
  }

  bool run(Fit& fit) const {
    constexpr int kMaxSteps = 100;
    constexpr int kMaxHalvings = 20;
    constexpr double kAtRest = 1e-14;  // of the cost
    Point at;
    at.params = fit.cameras.front().params;
    for (const FitView& view : fit.views) at.poses.push_back(fit.placements[view.placement].rig_from_board);
    if (!evaluate(at)) return false;
    bool is_at_rest = false;
    for (int i = 0; i < kMaxSteps && !is_at_rest; ++i) {
      const Eigen::MatrixXd information =
          at.sums.gram.topLeftCorner<kParams, kParams>().selfadjointView<Eigen::Lower>();
      const Eigen::VectorXd gradient = at.sums.gram.row(kParams).head<kParams>().transpose();
      const Eigen::VectorXd step = -information.ldlt().solve(gradient);
      double drop = -0.5 * gradient.dot(step);
      std::vector<SE3::Vec6> pose_steps;
      for (const PoseRows& rows : at.rows) {
        const Eigen::Matrix<double, 6, 1> right = rows.col(6 + kParams) + rows.middleCols<kParams>(6) * step;
        pose_steps.emplace_back(-rows.leftCols<6>().partialPivLu().solve(right));
        drop += 0.5 * rows.col(6 + kParams).squaredNorm();
      }
      is_at_rest = drop <= kAtRest * at.cost;
      double share = 1;
      for (int k = 0; k < kMaxHalvings; ++k, share *= 0.5) {
        Point there;
        for (int p = 0; p < kParams; ++p)
          there.params.push_back(at.params[static_cast<std::size_t>(p)] + share * step(p));
        for (std::size_t v = 0; v < at.poses.size(); ++v)
          there.poses.push_back(at.poses[v] * SE3::exp(share * pose_steps[v]));
        if (!evaluate(there) || !(there.cost < at.cost)) continue;
        at = std::move(there);
        break;
      }
    }
    fit.cameras.front().params = at.params;
    for (std::size_t v = 0; v < at.poses.size(); ++v)
      fit.placements[fit.views[v].placement].rig_from_board = at.poses[v];
    return is_at_rest;
  }

 private:
  const ViewKernel& kernel_ = viewKernel("radtan");
  std::vector<CornerGroups> corners_;
  HuberLoss loss_;
};

}  // namespace

bool solveBlockArrow(Fit& fit) {
  return Solver(fit).run(fit);
}

}  // namespace alidade
