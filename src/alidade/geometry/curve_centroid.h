// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>

namespace alidade {

/// The centroid of the area within a closed smooth curve, and its derivatives by the points of the curve.
template <int kPoints>
struct CurveCentroid {
  using Points = Eigen::Matrix<double, 2, kPoints>;

  Eigen::Vector2d at;
  Points J_x_points;  ///< derivative of at.x() by the coordinates of each point
  Points J_y_points;  ///< derivative of at.y()
};

/// Points on a unit circle, at equal steps.
template <int kPoints>
[[nodiscard]] inline Eigen::Matrix<double, 2, kPoints> unitCircle() {
  Eigen::Matrix<double, 2, kPoints> circle;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    circle.col(i) << std::cos(angle), std::sin(angle);
  }
  return circle;
}

/// By Green's theorem: the area is the integral of x dy, its moments those of x^2 dy / 2 and -y^2 dx / 2. The
/// points are taken at equal steps of a periodic parameter; the trapezoidal rule and the derivative of the
/// interpolating trigonometric polynomial (Trefethen 2000, Spectral Methods in MATLAB, equation 3.10) leave
/// an error that falls exponentially with their number. For the image of a disc of radius r at distance d, it
/// is of the order of the radius in pixels times (r / d)^(3 kPoints / 4).
/// @param points  in either sense of rotation, not all on a line
template <int kPoints>
[[nodiscard]] CurveCentroid<kPoints> centroidWithin(const Eigen::Matrix<double, 2, kPoints>& points) {
  static_assert(kPoints % 2 == 0 && kPoints >= 8);
  using Row = Eigen::Matrix<double, 1, kPoints>;
  static const Eigen::Matrix<double, kPoints, kPoints> derivative = [] {
    Eigen::Matrix<double, kPoints, kPoints> D = Eigen::Matrix<double, kPoints, kPoints>::Zero();
    for (int i = 0; i < kPoints; ++i) {
      for (int j = 0; j < kPoints; ++j) {
        if (i != j)
          D(j, i) = ((i - j) % 2 == 0 ? 0.5 : -0.5) / std::tan((i - j) * std::numbers::pi / kPoints);
      }
    }
    return D;
  }();
  // About the mean of the points: elsewhere, moments are differences of large numbers.
  const Eigen::Vector2d mean = points.rowwise().mean();
  const Row x = points.row(0).array() - mean.x();
  const Row y = points.row(1).array() - mean.y();
  const Row dx = x * derivative;
  const Row dy = y * derivative;
  const double area = x.dot(dy);
  const Row xx = x.cwiseProduct(x);
  const Row yy = y.cwiseProduct(y);
  const Eigen::Vector2d centroid(0.5 * xx.dot(dy) / area, -0.5 * yy.dot(dx) / area);
  CurveCentroid<kPoints> result;
  result.at = mean + centroid;
  // The derivative's matrix is antisymmetric.
  result.J_x_points.row(0) = (x.cwiseProduct(dy) - centroid.x() * dy) / area;
  result.J_x_points.row(1) = (-0.5 * (xx * derivative) + centroid.x() * dx) / area;
  result.J_y_points.row(0) = (0.5 * (yy * derivative) - centroid.y() * dy) / area;
  result.J_y_points.row(1) = (-y.cwiseProduct(dx) + centroid.y() * dx) / area;
  return result;
}

}  // namespace alidade
