// SPDX-License-Identifier: MIT
#include "alidade/footage/geometry/essential.h"

#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/LU>
#include <Eigen/QR>

#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

// Polynomials in x, y and z by their coefficients. Monomials of the third degree come first, because the
// elimination expresses them by the others.
//   cubic:     xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz, then the quadratic ones
//   quadratic: xx xy xz yy yz zz x y z 1
//   linear:    x y z 1
using Linear = Eigen::Matrix<double, 4, 1>;
using Quadratic = Eigen::Matrix<double, 10, 1>;
using Cubic = Eigen::Matrix<double, 20, 1>;

constexpr std::array<std::array<int, 4>, 4> kQuadraticAt = {
    {{0, 1, 2, 6}, {1, 3, 4, 7}, {2, 4, 5, 8}, {6, 7, 8, 9}}};
// The product of a quadratic monomial with x, y, z and 1.
constexpr std::array<std::array<int, 4>, 10> kCubicAt = {{{0, 1, 2, 10},
                                                          {1, 3, 4, 11},
                                                          {2, 4, 5, 12},
                                                          {3, 6, 7, 13},
                                                          {4, 7, 8, 14},
                                                          {5, 8, 9, 15},
                                                          {10, 11, 12, 16},
                                                          {11, 13, 14, 17},
                                                          {12, 14, 15, 18},
                                                          {16, 17, 18, 19}}};

Quadratic product(const Linear& a, const Linear& b) {
  Quadratic result = Quadratic::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j)
      result[kQuadraticAt[i][j]] += a[static_cast<Eigen::Index>(i)] * b[static_cast<Eigen::Index>(j)];
  }
  return result;
}

Cubic product(const Quadratic& a, const Linear& b) {
  Cubic result = Cubic::Zero();
  for (std::size_t i = 0; i < 10; ++i) {
    for (std::size_t j = 0; j < 4; ++j)
      result[kCubicAt[i][j]] += a[static_cast<Eigen::Index>(i)] * b[static_cast<Eigen::Index>(j)];
  }
  return result;
}

// The coefficients of det E = 0 and 2 E E^T E - tr(E E^T) E = 0.
Eigen::Matrix<double, 10, 20> constraints(const std::array<std::array<Linear, 3>, 3>& E) {
  std::array<std::array<Quadratic, 3>, 3> EEt;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      EEt[i][j] = product(E[i][0], E[j][0]) + product(E[i][1], E[j][1]) + product(E[i][2], E[j][2]);
  }
  const Quadratic half_trace = 0.5 * (EEt[0][0] + EEt[1][1] + EEt[2][2]);
  for (std::size_t i = 0; i < 3; ++i) EEt[i][i] -= half_trace;
  Eigen::Matrix<double, 10, 20> rows;
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      rows.row(row++) =
          (product(EEt[i][0], E[0][j]) + product(EEt[i][1], E[1][j]) + product(EEt[i][2], E[2][j]))
              .transpose();
    }
  }
  const auto minor = [&](std::size_t a, std::size_t b) -> Quadratic {
    return product(E[1][a], E[2][b]) - product(E[1][b], E[2][a]);
  };
  rows.row(row) =
      (product(minor(1, 2), E[0][0]) + product(minor(2, 0), E[0][1]) + product(minor(0, 1), E[0][2]))
          .transpose();
  return rows;
}

}  // namespace

std::vector<Eigen::Matrix3d> essentialMatrices(const std::array<RayPair, 5>& pairs) {
  Eigen::Matrix<double, 9, 5> equations;
  for (std::size_t k = 0; k < 5; ++k) {
    const Eigen::Matrix3d outer = pairs[k].b * pairs[k].a.transpose();
    equations.col(static_cast<Eigen::Index>(k)) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(outer.data());
  }
  // The last four columns of Q are orthogonal to all equations.
  const Eigen::Matrix<double, 9, 9> Q = equations.householderQr().householderQ();
  std::array<std::array<Linear, 3>, 3> E;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      E[i][j] = Q.block<1, 4>(static_cast<Eigen::Index>(i + 3 * j), 5).transpose();
  }
  const Eigen::Matrix<double, 10, 20> rows = constraints(E);
  const Eigen::MatrixXd rest = solveAny(rows.leftCols<10>(), rows.rightCols<10>());
  if (!rest.allFinite()) return {};
  // The matrix that multiplies xx xy xz yy yz zz x y z 1 by x.
  Eigen::Matrix<double, 10, 10> action = Eigen::Matrix<double, 10, 10>::Zero();
  action.topRows<6>() = -rest.topRows<6>();
  action(6, 0) = action(7, 1) = action(8, 2) = action(9, 6) = 1;
  Eigen::MatrixXd vectors;
  const Eigen::VectorXcd values = eigenvaluesOf(action, &vectors);
  std::vector<Eigen::Matrix3d> solutions;
  for (Eigen::Index k = 0; k < vectors.cols(); ++k) {
    if (values[k].imag() != 0) continue;
    // Normalised as complex numbers, whose squares are rounded differently.
    Eigen::Matrix<std::complex<double>, 10, 1> unit = vectors.col(k).cast<std::complex<double>>();
    unit.normalize();
    const Eigen::Matrix<double, 10, 1> v = unit.real();
    const Eigen::Vector4d factors(v[6], v[7], v[8], v[9]);
    Eigen::Matrix3d solution;
    Eigen::Map<Eigen::Matrix<double, 9, 1>>{solution.data()} = Q.rightCols<4>() * factors;
    const double norm = solution.norm();
    if (!(norm > 0) || !std::isfinite(norm)) continue;
    solutions.push_back(std::numbers::sqrt2 / norm * solution);
  }
  return solutions;
}

Eigen::Matrix3d essentialMatrix(const SE3& b_from_a) {
  return hat(b_from_a.translation) * b_from_a.rotation.matrix();
}

std::array<SE3, 4> motionsOf(const Eigen::Matrix3d& essential) {
  const Svd3 svd = svdOf(essential);
  Eigen::Matrix3d W;
  W << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector3d t = svd.U.col(2);
  std::array<SE3, 4> motions;
  for (std::size_t i = 0; i < 4; ++i) {
    Eigen::Matrix3d R = svd.U * (i < 2 ? W : Eigen::Matrix3d(W.transpose())) * svd.V.transpose();
    if (R.determinant() < 0) R = -R;
    motions[i].rotation = SO3::fromQuaternion(Eigen::Quaterniond(R));
    motions[i].translation = i % 2 == 0 ? t : Eigen::Vector3d(-t);
  }
  return motions;
}

Eigen::Array2d depthsOf(const RayPair& pair, const SE3& b_from_a) {
  const Eigen::Vector3d a = b_from_a.rotation * pair.a;
  const Eigen::Vector3d& t = b_from_a.translation;
  // Least squares of depth_b b = depth_a a + t.
  const double cosine = a.dot(pair.b);
  const double determinant = 1 - cosine * cosine;
  const double at = a.dot(t);
  const double bt = pair.b.dot(t);
  return {(cosine * bt - at) / determinant, (bt - cosine * at) / determinant};
}

}  // namespace alidade
