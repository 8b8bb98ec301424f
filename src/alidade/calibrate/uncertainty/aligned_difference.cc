// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/aligned_difference.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "alidade/geometry/rotation_conversions.h"
#include "alidade/geometry/se3.h"

namespace alidade {
namespace {

// The pose that aligns b with a: the points that a sees at `pixels`, on a sphere around it, project nearest
// to these pixels. Needs a good guess. Only its rotation is free if the points are distant.
SE3 alignedPose(const AnyCamera& b, const std::vector<Eigen::Vector3d>& points,
                const std::vector<Eigen::Vector2d>& pixels, bool are_far, SE3 b_from_a) {
  constexpr int kRounds = 5;  // of Gauss-Newton, for nearly equal cameras
  const Eigen::Index num_free = are_far ? 3 : 6;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
    SE3::Vec6 g = SE3::Vec6::Zero();
    const Eigen::Matrix3d R = b_from_a.rotation.matrix();
    for (std::size_t i = 0; i < points.size(); ++i) {
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
      const Projection projection = b.project(b_from_a * points[i], J_px_cam.data());
      if (!projection.ok()) continue;
      Eigen::Matrix<double, 2, 6> J;
      J << J_px_cam * R, -J_px_cam * R * hat(points[i]);
      H += J.transpose() * J;
      g += J.transpose() * (projection.pixel - pixels[i]);
    }
    SE3::Vec6 step = SE3::Vec6::Zero();
    step.tail(num_free) = -H.bottomRightCorner(num_free, num_free).ldlt().solve(g.tail(num_free));
    if (!step.allFinite()) break;
    b_from_a = b_from_a * SE3::exp(step);
  }
  return b_from_a;
}

}  // namespace

std::vector<double> alignedDifferences(const AnyCamera& a, const AnyCamera& b,
                                       std::span<const Eigen::Vector2d> pixels,
                                       std::span<const Eigen::Vector2d> anchors, double distance_m) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> seen;
  for (const Eigen::Vector2d& pixel : anchors) {
    const auto ray_a = a.unproject(pixel);
    const auto ray_b = b.unproject(pixel);
    if (!ray_a || !ray_b) continue;
    correlation += ray_b->normalized() * ray_a->normalized().transpose();
    points.push_back(ray_a->normalized());
    seen.push_back(pixel);
  }
  SE3 b_from_a;
  b_from_a.rotation = bestRotation(correlation);
  b_from_a = alignedPose(b, points, seen, std::isinf(distance_m), b_from_a);
  std::vector<double> differences;
  differences.reserve(pixels.size());
  for (const Eigen::Vector2d& pixel : pixels) {
    double& difference = differences.emplace_back(std::numeric_limits<double>::quiet_NaN());
    const auto ray = a.unproject(pixel);
    if (!ray) continue;
    const Projection projection = b.project(b_from_a * ray->normalized());
    if (projection.ok()) difference = (projection.pixel - pixel).norm();
  }
  return differences;
}

double largestDifference(const AnyCamera& a, const AnyCamera& b, std::span<const Eigen::Vector2d> pixels,
                         double distance_m) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const double difference : alignedDifferences(a, b, pixels, pixels, distance_m))
    largest = std::fmax(largest, difference);
  return largest;
}

}  // namespace alidade
