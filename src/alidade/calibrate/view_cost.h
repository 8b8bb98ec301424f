// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <ceres/cost_function.h>
#include <Eigen/Core>

#include "alidade/calibrate/reprojection.h"
#include "alidade/calibrate/se3_manifold.h"

namespace alidade {

/// A board point and where it was seen.
struct Observation {
  Eigen::Vector3d p_board;
  Eigen::Vector2d pixel;
  double sigma_px = std::numeric_limits<double>::quiet_NaN();  ///< as Corner::sigma_px
  double weight = 1.0;  ///< relative inverse variance, see CornerNoise; weighted error = error * sqrt(weight)
};

/// Huber's loss on a corner's squared weighted error s = weight (dx^2 + dy^2): rho(s) = s up to threshold^2,
/// then linear in the error.
struct HuberLoss {
  double threshold_px;  ///< for a corner of weight 1

  [[nodiscard]] double rho(double s) const {
    if (s <= threshold_px * threshold_px) return s;
    return 2 * threshold_px * std::sqrt(s) - threshold_px * threshold_px;
  }
  /// d rho / d s: the factor on the corner's weight.
  [[nodiscard]] double weight(double s) const {
    return s <= threshold_px * threshold_px ? 1.0 : threshold_px / std::sqrt(s);
  }
};

namespace detail {

/// R with R^T R = G, in place of `gram`, of which only the upper triangle is read: Cholesky's factor with its
/// rows in order of falling pivots (relative to the diagonal), the last column's at the end. So pivots that
/// have sunk into rounding, because other columns determine theirs, come where nothing but rounding is left
/// to divide by them, and many of them do no harm. Each is replaced by a tiny positive one, which keeps R^T
/// times the last column exact where dropping the row would not.
template <int kSize>
void factorize(Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>& gram) {
  constexpr double kMinPivot = 1e-14;  // of the diagonal; several roundings of a sum over many corners
  constexpr int kLast = kSize - 1;
  using Square = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
  Square rest = gram.template selfadjointView<Eigen::Upper>();
  const Eigen::Matrix<double, kSize, 1> diagonal = rest.diagonal();
  gram.setZero();
  Eigen::Matrix<bool, kSize, 1> is_done = Eigen::Matrix<bool, kSize, 1>::Constant(false);
  for (int row = 0; row < kLast; ++row) {
    int k = -1;
    double largest = 0;
    for (int j = 0; j < kLast; ++j) {
      const double share = diagonal(j) > 0 ? rest(j, j) / diagonal(j) : 0.0;
      if (is_done(j) || (k >= 0 && share <= largest)) continue;
      k = j;
      largest = share;
    }
    is_done(k) = true;
    if (largest > kMinPivot) {
      gram.row(row) = rest.row(k) / std::sqrt(rest(k, k));
      for (int j = 0; j < kLast; ++j) {
        if (is_done(j) && j != k) gram(row, j) = 0;
      }
      for (int i = 0; i < kSize; ++i) {
        const double factor = gram(row, i);
        for (int j = 0; j < kSize; ++j) rest(i, j) -= factor * gram(row, j);
      }
    } else {
      const double root = std::sqrt(kMinPivot * diagonal(k));
      gram(row, k) = root;
      gram(row, kLast) = root > 0 ? rest(k, kLast) / root : 0.0;
      rest(kLast, kLast) -= gram(row, kLast) * gram(row, kLast);
    }
  }
  gram(kLast, kLast) = std::sqrt(std::max(rest(kLast, kLast), 0.0));
}

}  // namespace detail

/// All corners of one view as one residual block, with the robust loss on each corner inside it. Parameter
/// blocks: intrinsics (kNumParams<M>), pose (7, SE3Manifold).
///
/// Each corner gives two rows [J r], scaled by the root of its weight times that of the loss, so that J^T r
/// and J^T J are those of iteratively reweighted least squares. The solver's time goes with the number of
/// rows, so it is given the triangular factor of [J r]^T [J r] instead: few rows with the same gradient and
/// the same Gauss-Newton matrix. The last row, whose Jacobian is zero, brings the sum of squares to the
/// robust cost, the sum of rho. Without Jacobians only that sum is wanted, and the last row carries all of
/// it.
template <CameraModel M>
class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(std::vector<Observation> observations, HuberLoss loss)
      : observations_(std::move(observations)), loss_(loss) {
    mutable_parameter_block_sizes()->push_back(kNumParams<M>);
    mutable_parameter_block_sizes()->push_back(7);
    set_num_residuals(kNumRows);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const SE3 camera_from_board = fromBlock(parameters[1]);
    const Eigen::Matrix3d R = camera_from_board.rotation.matrix();
    Gram gram = Gram::Zero();
    double sum_rho = 0;
    Reprojection<M> corner;
    for (const Observation& observation : observations_) {
      if (!reproject<M>(parameters[0], R, camera_from_board.translation, observation.p_board, corner))
        return false;
      const Eigen::Vector2d error = corner.pixel - observation.pixel;
      const double s = observation.weight * error.squaredNorm();
      sum_rho += loss_.rho(s);
      if (jacobians != nullptr) accumulate(corner, error, observation.weight * loss_.weight(s), gram);
    }
    // With the sum of rho in place of r^T r, the last pivot is what the other rows leave missing.
    gram(kNumRows - 1, kNumRows - 1) = sum_rho;
    detail::factorize(gram);
    Eigen::Map<Eigen::Matrix<double, kNumRows, 1>>{residuals} = gram.col(kNumRows - 1);
    if (jacobians != nullptr) writeJacobians(gram, parameters[1], jacobians);
    return true;
  }

 private:
  static constexpr int kPose = 6;
  static constexpr int kNumRows = kPose + kNumParams<M> + 1;
  using Gram = Eigen::Matrix<double, kNumRows, kNumRows, Eigen::RowMajor>;

  // Adds weight [J r]^T [J r] of one corner to the upper triangle; columns: pose, intrinsics, error. Plain
  // loops, which the compiler vectorises: Eigen's product of these shapes takes three times as long.
  static void accumulate(const Reprojection<M>& corner, const Eigen::Vector2d& error, double weight,
                         Gram& gram) {
    Eigen::Matrix<double, 2, kNumRows, Eigen::RowMajor> rows;
    rows << corner.J_px_pose, corner.J_px_params, error;
    for (int i = 0; i < kNumRows; ++i) {
      const double u = weight * rows(0, i);
      const double v = weight * rows(1, i);
      for (int j = i; j < kNumRows; ++j) gram(i, j) += u * rows(0, j) + v * rows(1, j);
    }
  }

  static void writeJacobians(const Gram& factor, const double* pose, double** jacobians) {
    if (jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, kNumRows, kNumParams<M>, Eigen::RowMajor>> J_params(jacobians[0]);
      J_params = factor.template middleCols<kNumParams<M>>(kPose);
    }
    if (jacobians[1] != nullptr) {
      // Ceres multiplies by the manifold's PlusJacobian, which takes this back to the tangent.
      Eigen::Matrix<double, 6, 7, Eigen::RowMajor> tangent_from_ambient;
      SE3Manifold().MinusJacobian(pose, tangent_from_ambient.data());
      Eigen::Map<Eigen::Matrix<double, kNumRows, 7, Eigen::RowMajor>> J_pose(jacobians[1]);
      J_pose.noalias() = factor.template leftCols<kPose>() * tangent_from_ambient;
    }
  }

  std::vector<Observation> observations_;
  HuberLoss loss_;
};

}  // namespace alidade
