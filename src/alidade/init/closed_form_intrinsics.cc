// SPDX-License-Identifier: MIT
#include "alidade/init/closed_form_intrinsics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace alidade {
namespace {

Eigen::Vector2d centre(ImageSize size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

double longSide(ImageSize size) {
  return std::max(size.width, size.height);
}

bool isPlausible(const AffineStart& s, ImageSize size) {
  // From a tele lens of 0.6 degrees to a field of view of 169 degrees on a perspective plane.
  const double long_side = longSide(size);
  const auto focal_ok = [&](double f) { return f > 0.05 * long_side && f < 100 * long_side; };
  return focal_ok(s.fx) && focal_ok(s.fy) && std::max(s.fx / s.fy, s.fy / s.fx) < 2 && s.cx > 0 &&
         s.cx < size.width && s.cy > 0 && s.cy < size.height;
}

// H after a change of pixel coordinates to (pixel - centre) / long side, scaled so that views weigh alike.
Eigen::Matrix3d normalised(const Eigen::Matrix3d& H, ImageSize size) {
  Eigen::Matrix3d t = Eigen::Matrix3d::Identity();
  t.topRightCorner<2, 1>() = -centre(size);
  t.topRows<2>() /= longSide(size);
  Eigen::Matrix3d out = t * H;
  out /= std::sqrt(out.col(0).norm() * out.col(1).norm());
  return out;
}

using Row5 = Eigen::Matrix<double, 1, 5>;

// Coefficients of h_i^T B h_j in B11, B22, B13, B23, B33 (B12 = 0: no skew).
Row5 constraint(const Eigen::Matrix3d& H, int i, int j) {
  const Eigen::Vector3d a = H.col(i);
  const Eigen::Vector3d b = H.col(j);
  Row5 row;
  row << a.x() * b.x(), a.y() * b.y(), a.z() * b.x() + a.x() * b.z(), a.z() * b.y() + a.y() * b.z(),
      a.z() * b.z();
  return row;
}

}  // namespace

std::optional<AffineStart> zhangIntrinsics(std::span<const Eigen::Matrix3d> pixel_from_board,
                                           ImageSize size) {
  if (pixel_from_board.size() < 3) return std::nullopt;
  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  for (const Eigen::Matrix3d& raw : pixel_from_board) {
    const Eigen::Matrix3d H = normalised(raw, size);
    const Row5 orthogonal = constraint(H, 0, 1);
    const Row5 equal_length = constraint(H, 0, 0) - constraint(H, 1, 1);
    normal += orthogonal.transpose() * orthogonal + equal_length.transpose() * equal_length;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 5, 5>> solver(normal);
  if (solver.info() != Eigen::Success) return std::nullopt;
  Eigen::Matrix<double, 5, 1> b = solver.eigenvectors().col(0);
  if (b(0) < 0) b = -b;
  const double cx = -b(2) / b(0);
  const double cy = -b(3) / b(1);
  const double lambda = b(4) + cx * b(2) + cy * b(3);
  const double scale = longSide(size);
  AffineStart start;
  start.fx = scale * std::sqrt(lambda / b(0));
  start.fy = scale * std::sqrt(lambda / b(1));
  start.cx = scale * cx + centre(size).x();
  start.cy = scale * cy + centre(size).y();
  if (!isPlausible(start, size)) return std::nullopt;
  return start;
}

std::optional<AffineStart> centredFocal(std::span<const Eigen::Matrix3d> pixel_from_board, ImageSize size) {
  // Each constraint reads p + f^2 q = 0; least squares over f^2.
  double sum_pq = 0;
  double sum_qq = 0;
  const auto add = [&](double p, double q) {
    sum_pq += p * q;
    sum_qq += q * q;
  };
  for (const Eigen::Matrix3d& raw : pixel_from_board) {
    const Eigen::Matrix3d H = normalised(raw, size);
    const Eigen::Vector3d a = H.col(0);
    const Eigen::Vector3d b = H.col(1);
    add(a.head<2>().dot(b.head<2>()), a.z() * b.z());
    add(a.head<2>().squaredNorm() - b.head<2>().squaredNorm(), a.z() * a.z() - b.z() * b.z());
  }
  const double focal = longSide(size) * std::sqrt(-sum_pq / sum_qq);
  const AffineStart start{.fx = focal, .fy = focal, .cx = centre(size).x(), .cy = centre(size).y()};
  if (!isPlausible(start, size)) return std::nullopt;
  return start;
}

std::vector<AffineStart> affineStarts(std::span<const Eigen::Matrix3d> pixel_from_board, ImageSize size) {
  std::vector<AffineStart> starts;
  if (const auto s = zhangIntrinsics(pixel_from_board, size)) starts.push_back(*s);
  if (const auto s = centredFocal(pixel_from_board, size)) starts.push_back(*s);
  for (const double fov_deg : {15.0, 25.0, 40.0, 60.0, 90.0, 120.0}) {
    const double focal = 0.5 * longSide(size) / std::tan(0.5 * fov_deg * std::numbers::pi / 180);
    starts.push_back({.fx = focal, .fy = focal, .cx = centre(size).x(), .cy = centre(size).y()});
  }
  return starts;
}

}  // namespace alidade
