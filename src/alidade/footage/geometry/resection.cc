// SPDX-License-Identifier: MIT
#include "alidade/footage/geometry/resection.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "alidade/core/random.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/rotation_conversions.h"

namespace alidade {
namespace {

constexpr std::size_t kFewestPoints = 8;

std::vector<double> realRoots(const std::array<double, 5>& falling) {
  if (std::abs(falling[0]) < 1e-12) return {};
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  for (Eigen::Index i = 0; i < 4; ++i)
    companion(0, i) = -falling[static_cast<std::size_t>(i) + 1] / falling[0];
  companion.bottomLeftCorner<3, 3>().setIdentity();
  if (!companion.allFinite()) return {};
  std::vector<double> roots;
  for (const std::complex<double>& root : eigenvaluesOf(companion)) {
    if (std::abs(root.imag()) < 1e-6 * (1 + std::abs(root.real()))) roots.push_back(root.real());
  }
  return roots;
}

// The motion that maps three points to three others.
SE3 motionBetween(const std::array<Eigen::Vector3d, 3>& from, const std::array<Eigen::Vector3d, 3>& to) {
  const Eigen::Vector3d from_mean = (from[0] + from[1] + from[2]) / 3;
  const Eigen::Vector3d to_mean = (to[0] + to[1] + to[2]) / 3;
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) correlation += (to[i] - to_mean) * (from[i] - from_mean).transpose();
  SE3 motion;
  motion.rotation = bestRotation(correlation);
  motion.translation = to_mean - motion.rotation * from_mean;
  return motion;
}

Eigen::Vector3d seenFrom(const SE3& camera_from_world, const Eigen::Vector4d& point) {
  return camera_from_world.rotation * Eigen::Vector3d(point.head<3>()) +
         camera_from_world.translation * point.w();
}

double squaredError(const AnyCamera& camera, const KnownPoint& known, const SE3& pose) {
  const Projection projection = camera.project(seenFrom(pose, known.point));
  return projection.ok() ? (projection.pixel - known.pixel).squaredNorm()
                         : std::numeric_limits<double>::infinity();
}

}  // namespace

double errorOf(const AnyCamera& camera, const SE3& camera_from_world, const Eigen::Vector4d& point,
               const Eigen::Vector2d& pixel) {
  return std::sqrt(squaredError(camera, {point, pixel}, camera_from_world));
}

std::vector<SE3> threePointPoses(const std::array<Eigen::Vector3d, 3>& points,
                                 const std::array<Eigen::Vector3d, 3>& rays) {
  const double aa = (points[1] - points[2]).squaredNorm();
  const double bb = (points[0] - points[2]).squaredNorm();
  const double cc = (points[0] - points[1]).squaredNorm();
  const double cos_a = rays[1].dot(rays[2]);
  const double cos_b = rays[0].dot(rays[2]);
  const double cos_c = rays[0].dot(rays[1]);
  const double q = (aa - cc) / bb;
  const double s = (aa + cc) / bb;
  const std::array<double, 5> quartic = {
      (q - 1) * (q - 1) - 4 * cc / bb * cos_a * cos_a,
      4 * (q * (1 - q) * cos_b - (1 - s) * cos_a * cos_c + 2 * cc / bb * cos_a * cos_a * cos_b),
      2 * (q * q - 1 + 2 * q * q * cos_b * cos_b + 2 * (bb - cc) / bb * cos_a * cos_a -
           4 * s * cos_a * cos_b * cos_c + 2 * (bb - aa) / bb * cos_c * cos_c),
      4 * (-q * (1 + q) * cos_b + 2 * aa / bb * cos_c * cos_c * cos_b - (1 - s) * cos_a * cos_c),
      (1 + q) * (1 + q) - 4 * aa / bb * cos_c * cos_c};
  std::vector<SE3> poses;
  for (const double v : realRoots(quartic)) {
    const double u = ((q - 1) * v * v - 2 * q * cos_b * v + 1 + q) / (2 * (cos_c - v * cos_a));
    const double first = std::sqrt(bb / (1 + v * v - 2 * v * cos_b));
    if (!(u > 0) || !(v > 0) || !std::isfinite(first) || !std::isfinite(u)) continue;
    poses.push_back(motionBetween(points, {first * rays[0], u * first * rays[1], v * first * rays[2]}));
  }
  return poses;
}

std::optional<Resection> refinedPose(const AnyCamera& camera, std::span<const KnownPoint> points,
                                     const SE3& guess, double threshold_px) {
  SE3 pose = guess;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_px_cam;
  const double scale = threshold_px * threshold_px;
  for (int step = 0; step < 15; ++step) {
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    const Eigen::Matrix3d R = pose.rotation.matrix();
    for (const KnownPoint& known : points) {
      const Eigen::Vector3d p = seenFrom(pose, known.point);
      const Projection projection = camera.project(p, J_px_cam.data());
      if (!projection.ok()) continue;
      const Eigen::Vector2d error = projection.pixel - known.pixel;
      const double shrink = scale / (scale + error.squaredNorm());
      const double weight = shrink * shrink / (known.sigma_px * known.sigma_px);
      const Eigen::Matrix<double, 2, 3> J_rotated = J_px_cam * R;
      Eigen::Matrix<double, 2, 6> J;
      J << J_rotated * known.point.w(), -J_rotated * hat(known.point.head<3>());
      H.noalias() += weight * J.transpose() * J;
      g.noalias() += weight * J.transpose() * error;
    }
    H.diagonal().array() += 1e-9 * H.trace();
    const Vector6d delta = -solveSpd6(H, g);
    if (!delta.allFinite()) return std::nullopt;
    pose = pose * SE3::exp(delta);
    if (delta.norm() < 1e-7) break;
  }
  Resection result{.camera_from_world = pose, .is_inlier = std::vector<bool>(points.size(), false)};
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(squaredError(camera, points[i], pose) < scale)) continue;
    result.is_inlier[i] = true;
    ++result.num_inliers;
  }
  if (result.num_inliers < kFewestPoints) return std::nullopt;
  return result;
}

std::optional<Resection> resect(const AnyCamera& camera, std::span<const KnownPoint> points,
                                const std::optional<SE3>& guess, double threshold_px, std::uint64_t seed) {
  if (points.size() < kFewestPoints) return std::nullopt;
  std::optional<Resection> best;
  if (guess) best = refinedPose(camera, points, *guess, threshold_px);
  if (best && 2 * best->num_inliers > points.size()) return best;

  std::vector<Eigen::Vector3d> finite;
  std::vector<Eigen::Vector3d> finite_rays;
  for (const KnownPoint& known : points) {
    constexpr double kNear = 1e-3;  // of w; points beyond 1000 steps of the camera do not place it
    const auto ray = camera.unproject(known.pixel);
    if (!ray || !(std::abs(known.point.w()) > kNear)) continue;
    finite.emplace_back(known.point.head<3>() / known.point.w());
    finite_rays.push_back(*ray);
  }
  if (finite.size() < kFewestPoints) return best;
  Random random(seed);
  double least = std::numeric_limits<double>::infinity();
  std::optional<SE3> pose;
  const double limit = threshold_px * threshold_px;
  for (int trial = 0; trial < 100; ++trial) {
    std::array<Eigen::Vector3d, 3> three;
    std::array<Eigen::Vector3d, 3> rays;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = random.index(finite.size());
      three[k] = finite[i];
      rays[k] = finite_rays[i];
    }
    for (const SE3& candidate : threePointPoses(three, rays)) {
      double sum = 0;
      for (const KnownPoint& known : points) sum += std::min(limit, squaredError(camera, known, candidate));
      if (!(sum < least)) continue;
      least = sum;
      pose = candidate;
    }
  }
  if (!pose) return best;
  const auto sampled = refinedPose(camera, points, *pose, threshold_px);
  if (!sampled || (best && best->num_inliers >= sampled->num_inliers)) return best;
  return sampled;
}

}  // namespace alidade
