// SPDX-License-Identifier: MIT
// Eigen's decompositions behind plain functions: each takes seconds to compile in every source that names it.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace alidade {

/// U diag(values) V^T of a 3x3 matrix, the values in falling order.
struct Svd3 {
  Eigen::Matrix3d U;
  Eigen::Vector3d values;
  Eigen::Matrix3d V;
};

[[nodiscard]] Svd3 svdOf(const Eigen::Matrix3d& matrix);

/// The singular values, the larger one first.
[[nodiscard]] Eigen::Vector2d singularValuesOf(const Eigen::Matrix2d& matrix);

/// The X of smallest norm that minimises |A X - B|.
[[nodiscard]] Eigen::VectorXd leastSquares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd leastSquares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// The X with A X = B for a symmetric A that is positive, or nearly so, by LDL^T with pivoting.
/// @param inverse  set to the inverse of A
[[nodiscard]] Eigen::MatrixXd solveSpd(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                       Eigen::MatrixXd* inverse = nullptr);
[[nodiscard]] Eigen::VectorXd solveSpd(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
[[nodiscard]] Eigen::MatrixXd inverseSpd(const Eigen::MatrixXd& A);

/// The same for the unknowns of a point or a pose, with operations in the order of fixed sizes.
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
[[nodiscard]] Eigen::Vector3d solveSpd3(const Eigen::Matrix3d& A, const Eigen::Vector3d& b);
[[nodiscard]] Vector6d solveSpd6(const Matrix6d& A, const Vector6d& b);
/// For any A that has an inverse.
[[nodiscard]] Vector6d solveAny6(const Matrix6d& A, const Vector6d& b);
[[nodiscard]] Eigen::MatrixXd solveAny(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
[[nodiscard]] Matrix6d inverseOfAny6(const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>& A);

/// The inverse of a symmetric positive definite matrix, whose diagonal is scaled to 1 first; nothing if it is
/// not positive definite.
[[nodiscard]] std::optional<Eigen::MatrixXd> scaledInverseSpd(const Eigen::MatrixXd& A);

/// U^-1 with U^T U = A for an upper triangle U; nothing if A is not positive definite.
[[nodiscard]] std::optional<Eigen::MatrixXd> inverseRootOf(const Eigen::MatrixXd& A);

/// R with R^T R = A for an A that is positive semi-definite but for rounding; its lower triangle is read.
[[nodiscard]] Eigen::MatrixXd semidefiniteRootOf(const Eigen::MatrixXd& A);

/// The lower triangle L with L L^T = A, and L^-1 B.
[[nodiscard]] Eigen::MatrixXd choleskyOf(const Eigen::MatrixXd& A);
[[nodiscard]] Eigen::MatrixXd solveLower(const Eigen::MatrixXd& L, const Eigen::MatrixXd& B);

/// Eigenvalues of a square matrix, and eigenvectors of any length for the real ones.
/// @param vectors  set, one column each, in the order of the eigenvalues; empty if there is no solution
[[nodiscard]] Eigen::VectorXcd eigenvaluesOf(const Eigen::MatrixXd& A, Eigen::MatrixXd* vectors = nullptr);

/// The smallest rotation that turns the direction of one vector into that of another.
[[nodiscard]] Eigen::Quaterniond shortestTurn(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace alidade
