// SPDX-License-Identifier: MIT
#include "alidade/calibrate/shape_information.h"

#include <Eigen/Eigenvalues>

#include "alidade/calibrate/reprojection.h"
#include "alidade/camera/model_list.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

constexpr int kBend = 2;

// J^T W J and J^T W psi of intrinsics and bend with the poses eliminated.
struct Reduced {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};

// `loss`, if any, weights the corners as iteratively reweighted least squares does; the gradient always has
// it.
template <CameraModel M>
Reduced reduce(const Checkerboard& board, std::span<const std::vector<Observation>> views,
               const BundleState& state, HuberLoss loss, bool has_robust_weights) {
  constexpr int kParams = kNumParams<M>;
  constexpr int kGlobal = kParams + kBend;
  using Matrix2G = Eigen::Matrix<double, 2, kGlobal, Eigen::RowMajor>;
  Eigen::Matrix<double, kGlobal, kGlobal> information = Eigen::Matrix<double, kGlobal, kGlobal>::Zero();
  Eigen::Matrix<double, kGlobal, 1> gradient = Eigen::Matrix<double, kGlobal, 1>::Zero();
  Reprojection<M> corner;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const SE3& pose = state.camera_from_board[v];
    const Eigen::Matrix3d R = pose.rotation.matrix();
    Eigen::Matrix<double, 6, 6> pose_pose = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, kGlobal> pose_global = Eigen::Matrix<double, 6, kGlobal>::Zero();
    Eigen::Matrix<double, 6, 1> pose_gradient = Eigen::Matrix<double, 6, 1>::Zero();
    for (const Observation& observation : views[v]) {
      const Eigen::Vector3d& p = observation.p_board;
      if (!reproject<M>(state.params.data(), R, pose.translation, p, corner)) continue;
      Matrix2G J;
      J.template leftCols<kParams>() = corner.J_px_params;
      // A shift of the board along its own z is a shift of the point.
      J.template rightCols<kBend>() = corner.J_px_pose.col(2) * bendProfile(board, p.x(), p.y()).transpose();
      const Eigen::Vector2d error = corner.pixel - observation.pixel;
      const double robust = loss.weight(observation.weight * error.squaredNorm());
      const double weight = observation.weight * (has_robust_weights ? robust : 1.0);
      const Eigen::Vector2d psi = observation.weight * robust * error;
      pose_pose.noalias() += weight * corner.J_px_pose.transpose() * corner.J_px_pose;
      pose_global.noalias() += weight * corner.J_px_pose.transpose() * J;
      pose_gradient.noalias() += corner.J_px_pose.transpose() * psi;
      information.noalias() += weight * J.transpose() * J;
      gradient.noalias() += J.transpose() * psi;
    }
    const auto factor = pose_pose.ldlt();
    information -= pose_global.transpose() * factor.solve(pose_global);
    gradient -= pose_global.transpose() * factor.solve(pose_gradient);
  }
  return {0.5 * (information + information.transpose()), gradient};
}

// The inverse of a symmetric matrix, scaled to a unit diagonal first; nothing if it is singular to working
// precision.
std::optional<Eigen::MatrixXd> inverseOf(const Eigen::MatrixXd& information) {
  constexpr double kSingular = 1e-13;
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * information *
                                                              scale.asDiagonal());
  const Eigen::VectorXd& values = solver.eigenvalues();
  if (solver.info() != Eigen::Success || !(values(0) > kSingular * values(values.size() - 1)))
    return std::nullopt;
  const Eigen::MatrixXd& vectors = solver.eigenvectors();
  return scale.asDiagonal() * vectors * values.cwiseInverse().asDiagonal() * vectors.transpose() *
         scale.asDiagonal();
}

}  // namespace

std::optional<ShapeInformation> shapeInformation(std::string_view model_id, const Checkerboard& board,
                                                 std::span<const std::vector<Observation>> views,
                                                 const BundleState& state, HuberLoss loss,
                                                 const ParamConstraint& constraint, const LensPrior& prior) {
  Reduced robust;
  Reduced plain;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId != model_id) return;
    robust = reduce<M>(board, views, state, loss, true);
    plain = reduce<M>(board, views, state, loss, false);
  });
  const Eigen::Index num_params = robust.gradient.size() - kBend;
  expect(num_params > 0, "the model's id is known");
  if (!prior.isNone()) {
    for (Reduced* reduced : {&robust, &plain})
      prior.addTo(state.params, reduced->information, reduced->gradient);
  }

  // What may move: the free directions of the intrinsics, and the bend.
  const Eigen::MatrixXd free = freeDirections(static_cast<int>(num_params), constraint);
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(num_params + kBend, free.cols() + kBend);
  directions.topLeftCorner(num_params, free.cols()) = free;
  directions.bottomRightCorner<kBend, kBend>().setIdentity();
  const auto robust_inverse = inverseOf(directions.transpose() * robust.information * directions);
  const auto plain_inverse = inverseOf(directions.transpose() * plain.information * directions);
  if (!robust_inverse || !plain_inverse) return std::nullopt;

  ShapeInformation result;
  const Eigen::VectorXd gradient = directions.transpose() * robust.gradient;
  const Eigen::VectorXd step = -*robust_inverse * gradient;
  result.step_m = step.tail<kBend>();
  result.drop = -gradient.dot(step);
  const Eigen::MatrixXd inverse = directions * *plain_inverse * directions.transpose();
  result.bend_inverse = inverse.bottomRightCorner<kBend, kBend>();
  result.params_inverse = inverse.topLeftCorner(num_params, num_params);
  return result;
}

}  // namespace alidade
