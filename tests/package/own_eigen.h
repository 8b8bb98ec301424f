// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

/// What a program's own calculations instantiate of Eigen, the libraries instantiate too, perhaps for another
/// processor: the linker must not take one for the other. False where something came out wrong.
inline bool ownEigenWorks() {
  Eigen::MatrixXd A(9, 9);
  for (Eigen::Index i = 0; i < A.size(); ++i) A(i) = std::cos(1.0 + static_cast<double>(i * i));
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(9, 1, 9);
  const Eigen::VectorXd b = A * x;
  const Eigen::MatrixXd AtA = A.transpose() * A;
  const Eigen::VectorXd Atb = A.transpose() * b;
  const auto isSolved = [&x](const Eigen::VectorXd& solution) { return (solution - x).norm() < 1e-6; };
  const Eigen::Matrix3d corner = A.topLeftCorner<3, 3>();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(corner, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d again = svd.matrixU() * svd.singularValues().asDiagonal() * svd.matrixV().transpose();
  const Eigen::Vector3d up = Eigen::Quaterniond::FromTwoVectors(corner.col(0), Eigen::Vector3d::UnitZ()) *
                             corner.col(0).normalized();
  return isSolved(AtA.ldlt().solve(Atb)) && isSolved(AtA.llt().solve(Atb)) &&
         isSolved(A.householderQr().solve(b)) && isSolved(A.completeOrthogonalDecomposition().solve(b)) &&
         isSolved(A.inverse() * b) && (again - corner).norm() < 1e-9 &&
         (up - Eigen::Vector3d::UnitZ()).norm() < 1e-9;
}
