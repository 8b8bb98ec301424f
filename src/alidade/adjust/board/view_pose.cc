// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_pose.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

// Points on the board as (p - mean) / scale, with an RMS length of sqrt(2).
struct BoardFrame {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double scale = 0;

  explicit BoardFrame(std::span<const Eigen::Vector2d> points) {
    for (const auto& p : points) mean += p;
    mean /= static_cast<double>(points.size());
    double sum = 0;
    for (const auto& p : points) sum += (p - mean).squaredNorm();
    scale = std::sqrt(0.5 * sum / static_cast<double>(points.size()));
  }
  [[nodiscard]] Eigen::Vector3d operator()(const Eigen::Vector2d& p) const {
    return ((p - mean) / scale).homogeneous();
  }
};

// Rays in a frame with the mean ray as the z axis, and their spread. Rays of a narrow field are nearly equal;
// x and y in units of their spread make the unknowns similar in size, like the normalisation of pixels for a
// homography. The equations remain those of angles.
struct RayFrame {
  Eigen::Matrix3d frame_from_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d unit = Eigen::Vector3d::Ones();

  explicit RayFrame(std::span<const Eigen::Vector3d> rays) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& b : rays) sum += b;
    frame_from_camera = shortestTurn(sum, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    double sum2 = 0;
    for (const auto& b : rays) sum2 += (frame_from_camera * b).head<2>().squaredNorm();
    const double spread = std::sqrt(0.5 * sum2 / static_cast<double>(rays.size()));
    unit.head<2>().setConstant(std::min(spread, 1.0));
  }
};

// H up to scale, for points in the board frame; nothing if there is no unique solution.
std::optional<Eigen::Matrix3d> homographyOfRays(std::span<const Eigen::Vector2d> on_board,
                                                std::span<const Eigen::Vector3d> rays,
                                                const BoardFrame& board_frame) {
  const RayFrame ray_frame(rays);
  Matrix9d normal = Matrix9d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d q = board_frame(on_board[i]);
    const Eigen::Vector3d b = ray_frame.frame_from_camera * rays[i];
    // |b x p|^2 = p^T (I - b b^T) p for a unit ray b; p = diag(unit) H' q.
    const Eigen::Matrix3d across = ray_frame.unit.asDiagonal() *
                                   (Eigen::Matrix3d::Identity() - b * b.transpose()) *
                                   ray_frame.unit.asDiagonal();
    const Eigen::Matrix3d qq = q * q.transpose();
    for (int r = 0; r < 3; ++r) {
      for (int c = r; c < 3; ++c) normal.block<3, 3>(3 * r, 3 * c) += across(r, c) * qq;
    }
  }
  normal = Matrix9d(normal.selfadjointView<Eigen::Upper>());
  const SymmetricEigen solver(normal);
  // A second (near-)zero eigenvalue means a family of solutions: the points lie on a line.
  constexpr double kSecondSmallest = 1e-10;
  if (!solver.isFound() || !(solver.eigenvalues()(1) > kSecondSmallest * solver.eigenvalues()(8))) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  const Eigen::Matrix3d H =
      ray_frame.unit.asDiagonal() * Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.data());
  return ray_frame.frame_from_camera.transpose() * H;
}

// The rotation nearest to one whose first two columns are a and b, up to a common scale; nothing if they are
// (nearly) parallel.
std::optional<Eigen::Matrix3d> nearestRotation(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double scale = 2.0 / (a.norm() + b.norm());
  Eigen::Matrix3d axes;
  axes << scale * a, scale * b, scale * scale * a.cross(b);
  const Svd3 svd = svdOf(axes);
  const Eigen::Matrix3d R = svd.U * svd.V.transpose();
  if (!R.allFinite() || R.determinant() < 0) return std::nullopt;
  return R;
}

}  // namespace

std::optional<SE3> poseFromRays(std::span<const Eigen::Vector2d> on_board,
                                std::span<const Eigen::Vector3d> rays) {
  expect(on_board.size() == rays.size(), "a ray for each point");
  if (on_board.size() < 4) return std::nullopt;
  const BoardFrame board_frame(on_board);
  if (!(board_frame.scale > 0)) return std::nullopt;
  auto H = homographyOfRays(on_board, rays, board_frame);
  if (!H) return std::nullopt;
  double along = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) along += rays[i].dot(*H * board_frame(on_board[i]));
  if (along < 0) *H = -*H;
  const auto R = nearestRotation(H->col(0), H->col(1));
  if (!R) return std::nullopt;

  // The translation that brings the rotated points closest to their rays.
  Eigen::Matrix3d sum_across = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum_points = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - rays[i] * rays[i].transpose();
    sum_across += across;
    sum_points += across * (R->leftCols<2>() * on_board[i]);
  }
  const Eigen::Vector3d t = -solveSpd3(sum_across, sum_points);
  if (!t.allFinite()) return std::nullopt;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!(rays[i].dot(R->leftCols<2>() * on_board[i] + t) > 0)) return std::nullopt;
  }
  SE3 camera_from_board;
  camera_from_board.rotation = SO3::fromQuaternion(Eigen::Quaterniond(*R));
  camera_from_board.translation = t;
  return camera_from_board;
}

SE3 mirroredTilt(const SE3& camera_from_board, const Eigen::Vector3d& middle) {
  const Eigen::Vector3d seen = camera_from_board * middle;
  const Eigen::Vector3d sight = seen.normalized();
  const Eigen::Vector3d normal = camera_from_board.rotation.matrix().col(2);
  const Eigen::Vector3d mirrored = 2 * normal.dot(sight) * sight - normal;
  SE3 other;
  other.rotation = SO3::fromQuaternion(shortestTurn(normal, mirrored)) * camera_from_board.rotation;
  other.translation = seen - other.rotation * middle;
  return other;
}

std::optional<SE3> poseFromCorners(const AnyCamera& camera, std::span<const Observation> corners) {
  std::vector<Eigen::Vector2d> on_board;
  std::vector<Eigen::Vector3d> rays;
  for (const Observation& corner : corners) {
    const auto ray = camera.unproject(corner.pixel);
    if (!ray) continue;
    on_board.emplace_back(corner.p_board.head<2>());
    rays.push_back(*ray);
  }
  return poseFromRays(on_board, rays);
}

std::optional<SE3> refitPose(const ViewKernel& kernel, std::span<const double> params,
                             std::span<const CornerGroup> corners, HuberLoss loss,
                             const SE3& camera_from_board) {
  constexpr int kMaxSteps = 30;
  constexpr int kMaxHalvings = 12;
  constexpr double kAtRest = 1e-10;  // share of the cost
  SE3 pose = camera_from_board;
  ViewFactor factor(kernel.numParams() + 7, kernel.numParams() + 7);
  ViewFactor trial = factor;
  // Sum of rho; nothing if a corner does not project.
  const auto costAt = [&](const SE3& at, ViewFactor& to) -> std::optional<double> {
    if (!kernel.factor(params.data(), at, corners, loss, Unseen::kRefuse, to.data())) return std::nullopt;
    return to.rightCols<1>().squaredNorm();
  };
  auto cost = costAt(pose, factor);
  if (!cost) return std::nullopt;
  // A pose that has not converged by then is merely less accurate.
  for (int i = 0; i < kMaxSteps; ++i) {
    const Vector6d y = factor.topRightCorner<6, 1>();
    // The quadratic model predicts this drop of the cost.
    if (!(y.squaredNorm() > kAtRest * *cost)) break;
    // Not triangular, because its rows are in the order of the pivots.
    const Matrix6d R = factor.topLeftCorner<6, 6>();
    Vector6d step = -solveAny6(R, y);
    bool is_lower = false;
    for (int k = 0; k < kMaxHalvings && !is_lower; ++k, step *= 0.5) {
      const SE3 moved = pose * SE3::exp(step);
      const auto there = costAt(moved, trial);
      if (!there || !(*there < *cost)) continue;
      pose = moved;
      cost = there;
      factor.swap(trial);
      is_lower = true;
    }
    if (!is_lower) break;
  }
  return pose;
}

std::optional<SE3> refitPose(std::string_view model_id, std::span<const double> params,
                             std::span<const Observation> corners, HuberLoss loss,
                             const SE3& camera_from_board) {
  return refitPose(viewKernel(model_id, params.size()), params, groupsOf(corners), loss, camera_from_board);
}

}  // namespace alidade
