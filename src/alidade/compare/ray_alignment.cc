// SPDX-License-Identifier: MIT
#include "alidade/compare/ray_alignment.h"

#include <cmath>
#include <utility>

#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade {
namespace {

using Row2x3 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;

constexpr int kMaxSteps = 200;
constexpr int kMaxHalvings = 40;
constexpr int kMaxRounds = 10;

// Four rows per pair in use: errors and their derivatives by the tangent of b_from_a.
class LeastSquares {
 public:
  LeastSquares(const CameraPair& cameras, std::span<const PixelPair> pairs, const std::vector<bool>& is_used,
               Freed freed)
      : cameras_(cameras), num_freed_(freed == Freed::kRotation ? 3 : 6) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (is_used[i]) pairs_.emplace_back(&pairs[i], std::sqrt(pairs[i].weight));
    }
    const auto num_rows = static_cast<Eigen::Index>(4 * pairs_.size());
    errors_.resize(num_rows);
    J_.resize(num_rows, 6);
  }

  // Weighted sum of squares, px^2; nothing if a camera no longer sees a pair.
  [[nodiscard]] std::optional<double> costAt(const SE3& b_from_a) const {
    double cost = 0;
    for (const auto& [pair, root_weight] : pairs_) {
      const auto differences = differencesAt(cameras_, *pair, b_from_a);
      if (!differences) return std::nullopt;
      cost +=
          root_weight * root_weight * (differences->a_to_b.squaredNorm() + differences->b_to_a.squaredNorm());
    }
    return cost;
  }

  struct Step {
    SE3::Vec6 xi = SE3::Vec6::Zero();
    double drop = 0;  // of the cost, as predicted by the quadratic model
  };
  // @pre there is a cost at b_from_a
  Step stepAt(const SE3& b_from_a) {
    const SE3 a_from_b = b_from_a.inverse();
    const Eigen::Matrix3d R = b_from_a.rotation.matrix();
    Eigen::Index row = 0;
    for (const auto& [pair, root_weight] : pairs_) {
      set(row, *cameras_.b, root_weight * cameras_.match.unit_from_b, b_from_a * pair->ray_a, pair->pixel_b,
          R, pair->ray_a);
      const Eigen::Vector3d in_a = a_from_b * pair->ray_b;
      set(row + 2, *cameras_.a, root_weight * cameras_.match.unit_from_a, in_a, pair->pixel_a,
          -Eigen::Matrix3d::Identity(), in_a);
      row += 4;
    }
    const Eigen::MatrixXd J = J_.rightCols(num_freed_);
    const Eigen::VectorXd step = leastSquares(J, Eigen::VectorXd(-errors_));
    Step result{.drop = (J * step).squaredNorm()};
    result.xi.tail(num_freed_) = step;
    return result;
  }

  [[nodiscard]] double numErrors() const { return static_cast<double>(errors_.size()); }

 private:
  // Derivatives of the projection of `point`, which moves by `outer` (translation - hat(lever) rotation).
  void set(Eigen::Index row, const AnyCamera& camera, const Eigen::Matrix2d& unit,
           const Eigen::Vector3d& point, const Eigen::Vector2d& pixel, const Eigen::Matrix3d& outer,
           const Eigen::Vector3d& lever) {
    Row2x3 J_point;
    const Projection projection = camera.project(point, J_point.data(), nullptr);
    errors_.segment<2>(row) = unit * (projection.pixel - pixel);
    const Eigen::Matrix<double, 2, 3> J = unit * J_point * outer;
    J_.block<2, 6>(row, 0) << J, -J * hat(lever);
  }

  const CameraPair& cameras_;
  std::vector<std::pair<const PixelPair*, double>> pairs_;  // with the square root of its weight
  Eigen::Index num_freed_;
  Eigen::VectorXd errors_;
  Eigen::Matrix<double, Eigen::Dynamic, 6> J_;  // by the translation, then by the rotation
};

// Descends to the minimum and returns nothing, or returns the full step that would be needed if no fraction
// of it lowers the sum.
std::optional<SE3> descend(LeastSquares& problem, SE3& b_from_a) {
  constexpr double kAtRest = 1e-14;     // share of the cost
  constexpr double kAtRestPx = 1e-11;   // per error, if the cost is nearly zero
  constexpr double kRounding = 1e-9;    // relative rounding of cost differences
  constexpr double kRoundingPx = 1e-9;  // rounding of unprojecting and projecting
  auto cost = problem.costAt(b_from_a);
  SE3 wanted = b_from_a;
  for (int i = 0; i < kMaxSteps; ++i) {
    const LeastSquares::Step step = problem.stepAt(b_from_a);
    wanted = b_from_a * SE3::exp(step.xi);
    const double n = problem.numErrors();
    if (step.drop <= kAtRest * *cost + n * kAtRestPx * kAtRestPx) return std::nullopt;
    bool is_lower = false;
    SE3::Vec6 xi = step.xi;
    for (int k = 0; k < kMaxHalvings && !is_lower; ++k, xi *= 0.5) {
      const SE3 moved = b_from_a * SE3::exp(xi);
      const auto there = problem.costAt(moved);
      if (!there || !(*there < *cost)) continue;
      b_from_a = moved;
      cost = there;
      is_lower = true;
    }
    if (is_lower) continue;
    if (step.drop <= kRounding * *cost + n * kRoundingPx * kRoundingPx) return std::nullopt;
    break;
  }
  return wanted;
}

// Marks the pairs with `is_wanted` that both cameras see.
std::vector<bool> seenFrom(const CameraPair& cameras, std::span<const PixelPair> pairs, const SE3& b_from_a,
                           std::vector<bool> is_wanted) {
  for (std::size_t i = 0; i < pairs.size(); ++i)
    is_wanted[i] = is_wanted[i] && differencesAt(cameras, pairs[i], b_from_a).has_value();
  return is_wanted;
}

}  // namespace

std::optional<TwoDifferences> differencesAt(const CameraPair& cameras, const PixelPair& pair,
                                            const SE3& b_from_a) {
  const Projection in_b = cameras.b->project(b_from_a * pair.ray_a);
  const Projection in_a = cameras.a->project(b_from_a.inverse() * pair.ray_b);
  if (!in_a.ok() || !in_b.ok()) return std::nullopt;
  return TwoDifferences{.a_to_b = cameras.match.unit_from_b * (in_b.pixel - pair.pixel_b),
                        .b_to_a = cameras.match.unit_from_a * (in_a.pixel - pair.pixel_a)};
}

SE3 kabschRotation(std::span<const PixelPair> pairs) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PixelPair& pair : pairs) sum += pair.weight * pair.ray_b * pair.ray_a.transpose();
  return {bestRotation(sum), Eigen::Vector3d::Zero()};
}

RayAlignment alignRays(const CameraPair& cameras, std::span<const PixelPair> pairs,
                       std::optional<Freed> freed) {
  RayAlignment result;
  std::vector<bool> is_allowed(pairs.size(), true);
  result.b_from_a.rotation = SO3::fromQuaternion(Eigen::Quaterniond(cameras.match.frameTurn()));
  result.is_used = seenFrom(cameras, pairs, result.b_from_a, is_allowed);
  result.is_converged = true;
  if (!freed) return result;

  result.b_from_a = kabschRotation(pairs);
  result.is_used = seenFrom(cameras, pairs, result.b_from_a, is_allowed);
  // At the rim of a lens's domain, some pairs are seen at the start but not at the end, or vice versa. Pairs
  // that block the descent are dropped for good.
  for (int round = 0; round < kMaxRounds; ++round) {
    LeastSquares problem(cameras, pairs, result.is_used, *freed);
    constexpr double kErrorsAPair = 4;
    if (problem.numErrors() < kErrorsAPair * fewestPairs(*freed)) {
      result.is_converged = false;
      return result;
    }
    const auto wanted = descend(problem, result.b_from_a);
    result.is_converged = !wanted;
    if (wanted) is_allowed = seenFrom(cameras, pairs, *wanted, is_allowed);
    const std::vector<bool> is_usable = seenFrom(cameras, pairs, result.b_from_a, is_allowed);
    if (is_usable == result.is_used) break;
    result.is_used = is_usable;
  }
  return result;
}

}  // namespace alidade
