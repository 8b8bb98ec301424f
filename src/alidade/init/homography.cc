// SPDX-License-Identifier: MIT
#include "alidade/init/homography.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "alidade/core/error.h"

namespace alidade {
namespace {

// Moves points to mean zero and root mean square distance sqrt(2).
std::optional<Eigen::Matrix3d> normaliser(std::span<const Eigen::Vector2d> points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  double sum = 0;
  for (const auto& p : points) sum += (p - mean).squaredNorm();
  const double scale = std::sqrt(2.0 * static_cast<double>(points.size()) / sum);
  if (!std::isfinite(scale)) return std::nullopt;
  Eigen::Matrix3d t = Eigen::Matrix3d::Identity();
  t(0, 0) = t(1, 1) = scale;
  t.topRightCorner<2, 1>() = -scale * mean;
  return t;
}

}  // namespace

std::optional<Eigen::Matrix3d> fitHomography(std::span<const Eigen::Vector2d> from,
                                             std::span<const Eigen::Vector2d> to) {
  expect(from.size() == to.size(), "as many points on both sides");
  if (from.size() < 4) return std::nullopt;
  const auto normalise_from = normaliser(from);
  const auto normalise_to = normaliser(to);
  if (!normalise_from || !normalise_to) return std::nullopt;

  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d a = *normalise_from * from[i].homogeneous();
    const Eigen::Vector3d b = *normalise_to * to[i].homogeneous();
    Eigen::Matrix<double, 2, 9> rows;
    rows << a.transpose(), Eigen::RowVector3d::Zero(), -b.x() * a.transpose(),  //
        Eigen::RowVector3d::Zero(), a.transpose(), -b.y() * a.transpose();
    normal += rows.transpose().lazyProduct(rows);  // small enough that Eigen's general product costs more
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(normal);
  // A second (near-)zero eigenvalue means a family of solutions: the points lie on a line.
  constexpr double kSecondSmallest = 1e-10;
  if (solver.info() != Eigen::Success ||
      !(solver.eigenvalues()(1) > kSecondSmallest * solver.eigenvalues()(8))) {
    return std::nullopt;
  }
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  Eigen::Matrix3d H;
  H << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  H = normalise_to->inverse() * H * *normalise_from;
  H /= H.norm();
  if (!H.allFinite() || H.determinant() == 0.0) return std::nullopt;
  return H;
}

}  // namespace alidade
