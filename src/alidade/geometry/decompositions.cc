// SPDX-License-Identifier: MIT
#include "alidade/geometry/decompositions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace alidade {

Svd3 svdOf(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {.U = svd.matrixU(), .values = svd.singularValues(), .V = svd.matrixV()};
}

Eigen::Vector2d singularValuesOf(const Eigen::Matrix2d& matrix) {
  return Eigen::JacobiSVD<Eigen::Matrix2d>(matrix).singularValues();
}

Eigen::VectorXd leastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return leastSquares(A, Eigen::MatrixXd(b));  // compiles faster than a decomposition for vectors
}

Eigen::MatrixXd leastSquares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return A.completeOrthogonalDecomposition().solve(B);
}

Eigen::MatrixXd solveSpd(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, Eigen::MatrixXd* inverse) {
  const Eigen::LDLT<Eigen::MatrixXd> factor(A);
  if (inverse != nullptr) *inverse = factor.solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  return factor.solve(B);
}

Eigen::VectorXd solveSpd(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  return A.ldlt().solve(b);  // rounds differently from a matrix of one column
}

Eigen::MatrixXd inverseSpd(const Eigen::MatrixXd& A) {
  return solveSpd(A, Eigen::MatrixXd(Eigen::MatrixXd::Identity(A.rows(), A.cols())));
}

Eigen::Vector3d solveSpd3(const Eigen::Matrix3d& A, const Eigen::Vector3d& b) {
  return A.ldlt().solve(b);
}

Vector6d solveSpd6(const Matrix6d& A, const Vector6d& b) {
  return A.ldlt().solve(b);
}

Vector6d solveAny6(const Matrix6d& A, const Vector6d& b) {
  return A.partialPivLu().solve(b);
}

Eigen::MatrixXd solveAny(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return A.partialPivLu().solve(B);
}

Matrix6d inverseOfAny6(const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>& A) {
  return A.inverse();
}

std::optional<Eigen::MatrixXd> scaledInverseSpd(const Eigen::MatrixXd& A) {
  if (A.size() == 0) return A;
  if (!(A.diagonal().minCoeff() > 0)) return std::nullopt;
  const Eigen::VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> llt(scale.asDiagonal() * A * scale.asDiagonal());
  if (llt.info() != Eigen::Success) return std::nullopt;
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  if (!inverse.allFinite()) return std::nullopt;
  return Eigen::MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

std::optional<Eigen::MatrixXd> inverseRootOf(const Eigen::MatrixXd& A) {
  const Eigen::LLT<Eigen::MatrixXd> llt(A);
  if (llt.info() != Eigen::Success) return std::nullopt;
  return Eigen::MatrixXd(llt.matrixU().solve(Eigen::MatrixXd::Identity(A.rows(), A.rows())));
}

Eigen::MatrixXd semidefiniteRootOf(const Eigen::MatrixXd& A) {
  const Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower> ldlt(A);
  const Eigen::VectorXd roots = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
  const Eigen::MatrixXd permutation = ldlt.transpositionsP() * Eigen::MatrixXd::Identity(A.rows(), A.cols());
  return roots.asDiagonal() * (ldlt.matrixU() * permutation);
}

Eigen::MatrixXd choleskyOf(const Eigen::MatrixXd& A) {
  return A.llt().matrixL();
}

Eigen::MatrixXd solveLower(const Eigen::MatrixXd& L, const Eigen::MatrixXd& B) {
  return L.triangularView<Eigen::Lower>().solve(B);
}

Eigen::VectorXcd eigenvaluesOf(const Eigen::MatrixXd& A, Eigen::MatrixXd* vectors) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A, vectors != nullptr);
  if (vectors != nullptr)
    *vectors = solver.info() == Eigen::Success ? solver.pseudoEigenvectors() : Eigen::MatrixXd();
  return solver.eigenvalues();
}

Eigen::Quaterniond shortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d start = from.normalized();
  const Eigen::Vector3d halfway = start + to.normalized();
  const double length = halfway.norm();
  constexpr double kOpposite = 1e-6;  // the sum is mostly rounding; any perpendicular axis will do
  const Eigen::Vector3d end = length < kOpposite ? start.unitOrthogonal() : Eigen::Vector3d(halfway / length);
  const Eigen::Vector3d axis = start.cross(end);
  return {start.dot(end), axis.x(), axis.y(), axis.z()};
}

}  // namespace alidade
