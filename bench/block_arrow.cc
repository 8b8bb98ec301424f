// SPDX-License-Identifier: MIT
#include "block_arrow.h"

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "alidade/adjust/board/view_kernel.h"

namespace alidade {
namespace {

constexpr int kParams = 9;

// The normal equations at one point, with poses eliminated.
struct Point {
  std::vector<double> params;
  std::vector<SE3> poses;
  std::vector<ViewFactor> factors;
  Eigen::Matrix<double, kParams, kParams> information;
  Eigen::Vector<double, kParams> gradient;
  double cost = 0;
};

class Solver {
 public:
  explicit Solver(const Fit& fit) : loss_(fit.loss) {
    for (const FitView& view : fit.views) corners_.push_back(groupsOf(view.corners));
  }

  // Returns false if a corner does not project.
  bool evaluate(Point& at) const {
    at.factors.resize(corners_.size(), ViewFactor(kParams + 7, kParams + 7));
    at.information.setZero();
    at.gradient.setZero();
    at.cost = 0;
    for (std::size_t v = 0; v < corners_.size(); ++v) {
      ViewFactor& factor = at.factors[v];
      if (!kernel_.factor(at.params.data(), at.poses[v], corners_[v], loss_, Unseen::kRefuse, factor.data()))
        return false;
      const auto rest = factor.block<kParams, kParams>(6, 6);
      at.information += rest.transpose() * rest;
      at.gradient += rest.transpose() * factor.block<kParams, 1>(6, 6 + kParams);
      at.cost += 0.5 * factor.col(6 + kParams).squaredNorm();
    }
    return true;
  }

  bool run(Fit& fit) const {
    constexpr int kMaxSteps = 100;
    constexpr int kMaxHalvings = 20;
    constexpr double kAtRest = 1e-14;  // of the cost
    Point at;
    at.params = fit.cameras.front().params;
    for (const FitView& view : fit.views) at.poses.push_back(fit.placements[view.placement].rig_from_body);
    if (!evaluate(at)) return false;
    bool is_at_rest = false;
    for (int i = 0; i < kMaxSteps && !is_at_rest; ++i) {
      const Eigen::Vector<double, kParams> step = -at.information.ldlt().solve(at.gradient);
      double drop = -0.5 * at.gradient.dot(step);
      std::vector<SE3::Vec6> pose_steps;
      for (const ViewFactor& factor : at.factors) {
        const auto error = factor.block<6, 1>(0, 6 + kParams);
        const SE3::Vec6 right = error + factor.block<6, kParams>(0, 6) * step;
        pose_steps.emplace_back(-factor.topLeftCorner<6, 6>().partialPivLu().solve(right));
        drop += 0.5 * error.squaredNorm();
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
      fit.placements[fit.views[v].placement].rig_from_body = at.poses[v];
    return is_at_rest;
  }

 private:
  const ViewKernel& kernel_ = viewKernel("radtan", kNumParams<Radtan>);
  std::vector<std::vector<CornerGroup>> corners_;
  HuberLoss loss_;
};

}  // namespace

bool solveBlockArrow(Fit& fit) {
  return Solver(fit).run(fit);
}

}  // namespace alidade
