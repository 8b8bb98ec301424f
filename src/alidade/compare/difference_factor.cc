// SPDX-License-Identifier: MIT
#include "alidade/compare/difference_factor.h"

#include <vector>

#include "alidade/camera/aligned_jacobians.h"
#include "alidade/core/error.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

// S with S S^T = covariance, which may be singular: parameters that are held have no variance.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& covariance) {
  // Scaled first: the units of the parameters span ten orders of magnitude.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const SymmetricEigen solver(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  return scale.asDiagonal() * solver.eigenvectors() *
         Eigen::MatrixXd(solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal());
}

Eigen::MatrixXd factorOf(const ComparedCamera& camera, std::span<const Eigen::Vector2d> pixels,
                         const Eigen::Matrix2d& unit, std::optional<Freed> freed,
                         std::span<const double> weights) {
  const auto n = static_cast<Eigen::Index>(camera.camera->parameters().size());
  if (!camera.covariance) return Eigen::MatrixXd(2 * static_cast<Eigen::Index>(pixels.size()), 0);
  expect(camera.covariance->rows() == n && camera.covariance->cols() == n,
         "the covariance has a row and a column for each of the camera's parameters");
  Eigen::MatrixXd rows = alignedJacobians(*camera.camera, pixels, {}, freed, weights).transposed.transpose() *
                         rootOf(*camera.covariance);
  for (Eigen::Index i = 0; i < rows.rows(); i += 2)
    rows.middleRows<2>(i) = (unit * rows.middleRows<2>(i)).eval();
  return rows;
}

}  // namespace

Eigen::MatrixXd differenceFactor(const ComparedCamera& a, const ComparedCamera& b, const ImageMatch& match,
                                 std::span<const Eigen::Vector2d> pixels, std::optional<Freed> freed,
                                 std::span<const double> weights) {
  std::vector<Eigen::Vector2d> in_b;
  for (const Eigen::Vector2d& pixel : pixels) in_b.push_back(match.inB(pixel));
  const Eigen::MatrixXd by_a = factorOf(a, pixels, match.unit_from_a, freed, weights);
  const Eigen::MatrixXd by_b = factorOf(b, in_b, match.unit_from_b, freed, weights);
  Eigen::MatrixXd factor(by_a.rows(), by_a.cols() + by_b.cols());
  factor << by_a, by_b;
  return factor;
}

}  // namespace alidade
