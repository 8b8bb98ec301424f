// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/fold_guard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include <ceres/cost_function.h>

#include "alidade/adjust/board/fit.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/image_domain.h"
#include "alidade/camera/model_traits.h"

namespace alidade {
namespace {

// Least growth of the image of a real lens, relative to the axis. At 60 degrees, where that of an
// orthographic lens falls to 0.5, few lenses fall below it.
constexpr double kLeastGrowth = 0.3;
constexpr double kGrowthStd = 0.03;

using Gradient = Eigen::RowVectorXd;

// The unit ray at an angle from the axis.
Eigen::Vector3d rayAt(double angle, const Eigen::Vector2d& outwards) {
  const Eigen::Vector2d side = std::sin(angle) * outwards;
  return {side.x(), side.y(), std::cos(angle)};
}

// Distance of a ray's image outwards from the centre for fx = fy = 1; nothing where the formula has no value.
// @param J_params  adds `weight` times its derivative by the parameters; may be null
std::optional<double> distanceAt(const ModelTraits& model, const double* params, double angle,
                                 const Eigen::Vector2d& outwards, double weight, Gradient* J_params) {
  const auto n = static_cast<Eigen::Index>(model.parameter_names.size());
  const auto num_lens = n - static_cast<Eigen::Index>(kNumAffine);
  std::vector<double> normalised(params, params + n);
  std::ranges::copy(std::array{1.0, 1.0, 0.0, 0.0}, normalised.begin());
  const Eigen::Vector3d ray = rayAt(angle, outwards);
  Eigen::Vector2d m;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_m_ray;
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_m_params(2, n);
  if (!model.project(normalised.data(), ray.data(), m.data(), J_m_ray.data(), J_m_params.data()))
    return std::nullopt;
  if (J_params != nullptr)
    J_params->tail(num_lens) += weight * outwards.transpose() * J_m_params.rightCols(num_lens);
  return outwards.dot(m);
}

// Growth of the image outwards along a ray, per radian.
std::optional<double> growthAt(const ModelTraits& model, const double* params, const Eigen::Vector3d& ray,
                               Gradient* J_params) {
  constexpr double kStepRad = 1e-3;
  const double angle = std::atan2(ray.head<2>().norm(), ray.z());
  const Eigen::Vector2d outwards = ray.head<2>().normalized();
  const double weight = 1 / (2 * kStepRad);
  if (J_params != nullptr) J_params->setZero();
  const auto further = distanceAt(model, params, angle + kStepRad, outwards, weight, J_params);
  const auto nearer = distanceAt(model, params, angle - kStepRad, outwards, -weight, J_params);
  if (!further || !nearer) return std::nullopt;
  return weight * (*further - *nearer);
}

Eigen::Vector3d nearAxis() {
  return rayAt(0.01, Eigen::Vector2d::UnitX());
}

class FoldGuardBlock final : public ceres::CostFunction {
 public:
  FoldGuardBlock(std::string_view model_id, const FoldGuard& guard)
      : model_(modelTraits(model_id)), guard_(guard) {
    set_num_residuals(static_cast<int>(guard.rays.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(model_.parameter_names.size()));
  }

  bool Evaluate(const double* const* params, double* residuals, double** jacobians) const override {
    const Eigen::Index n = parameter_block_sizes()[0];
    Gradient J_axis(n);
    const auto at_axis = growthAt(model_, params[0], nearAxis(), &J_axis);
    if (!at_axis) return false;
    for (std::size_t i = 0; i < guard_.rays.size(); ++i) {
      Gradient J(n);
      const auto growth = growthAt(model_, params[0], guard_.rays[i], &J);
      if (!growth) return false;
      const double relative = *growth / *at_axis;
      const double lacking = (kLeastGrowth - relative) / kGrowthStd;
      // Smooth, because with a kink the solver would not come to rest.
      residuals[i] = guard_.sigma_px * (std::max(0.0, lacking) + std::log1p(std::exp(-std::abs(lacking))));
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      const double slope = guard_.sigma_px / (1 + std::exp(-lacking));
      Eigen::Map<Gradient>(jacobians[0] + static_cast<Eigen::Index>(i) * n, n) =
          slope / (*at_axis * kGrowthStd) * (relative * J_axis - J);
    }
    return true;
  }

 private:
  const ModelTraits& model_;
  const FoldGuard& guard_;
};

}  // namespace

bool guardFold(double sigma_px, FitCamera& camera) {
  constexpr double kBefore = 0.9;       // share of the fold's angle from which the lens is guarded
  constexpr double kUsualGrowth = 0.7;  // between the fold and the corner
  constexpr double kMostRad = 1.5;
  constexpr int kNumSteps = 8;
  if (camera.hasPupil()) return false;  // FoldGuardBlock is of the lens alone
  const AnyCamera lens = cameraOf(camera);
  if (!foldsInsideImage(lens, camera.size)) return false;
  const ModelTraits& model = modelTraits(camera.model);
  const double* params = camera.params.data();
  FoldGuard& guard = camera.weak_prior.guard;
  const std::size_t num_before = guard.rays.size();
  const auto at_axis = growthAt(model, params, nearAxis(), nullptr);
  if (!at_axis) return false;
  guard.sigma_px = sigma_px;
  const double fold_rad = lens.cone().max_angle_rad;
  for (const double u : {-0.5, camera.size.width - 0.5}) {
    for (const double v : {-0.5, camera.size.height - 0.5}) {
      if (lens.unproject({u, v})) continue;
      const Eigen::Vector2d corner((u - params[2]) / params[0], (v - params[3]) / params[1]);
      const Eigen::Vector2d outwards = corner.normalized();
      const auto reached = distanceAt(model, params, kBefore * fold_rad, outwards, 0, nullptr);
      if (!reached) continue;
      const double last_rad =
          std::min(kMostRad, fold_rad + std::max(0.0, corner.norm() - *reached) / (kUsualGrowth * *at_axis));
      for (int i = 0; i <= kNumSteps; ++i) {
        const Eigen::Vector3d ray =
            rayAt(std::lerp(kBefore * fold_rad, last_rad, i / double{kNumSteps}), outwards);
        if (growthAt(model, params, ray, nullptr)) guard.rays.push_back(ray);
      }
    }
  }
  return guard.rays.size() > num_before;
}

double foldGuardCost(const FitCamera& camera) {
  const FoldGuard& guard = camera.weak_prior.guard;
  if (guard.isNone()) return 0;
  Eigen::VectorXd residuals(guard.rays.size());
  const double* params = camera.params.data();
  if (!FoldGuardBlock(camera.model, guard).Evaluate(&params, residuals.data(), nullptr))
    return std::numeric_limits<double>::quiet_NaN();
  return residuals.squaredNorm() / 2;
}

ceres::CostFunction* foldGuardBlock(std::string_view model_id, const FoldGuard& guard) {
  return new FoldGuardBlock(model_id, guard);
}

}  // namespace alidade
