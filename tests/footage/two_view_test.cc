// SPDX-License-Identifier: MIT
#include "alidade/footage/geometry/two_view.h"

#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "footage/points_scene.h"

namespace alidade {
namespace {

using testing::angleDeg;
using testing::footageCameras;
using testing::isInFootage;
using testing::kFootageSize;
using testing::noisy;
using testing::randomDirection;
using testing::ScatteredPoints;
using testing::scatteredPoints;

constexpr double kNoisePx = 0.3;

// Matches of points that both images show, and some false ones.
std::vector<PixelMatch> matchesOf(const AnyCamera& camera, const std::vector<Eigen::Vector3d>& points,
                                  const SE3& b_from_a, double false_share, Random& random) {
  std::vector<PixelMatch> matches;
  for (const Eigen::Vector3d& p : points) {
    const Projection a = camera.project(p);
    const Projection b = camera.project(b_from_a * p);
    if (!a.ok() || !b.ok() || !isInFootage(b.pixel)) continue;
    PixelMatch match{noisy(a.pixel, kNoisePx, random), noisy(b.pixel, kNoisePx, random), kNoisePx};
    if (random.uniform() < false_share) match.b = {random.uniform(0, 639), random.uniform(0, 479)};
    matches.push_back(match);
  }
  return matches;
}

// A sideways and forward motion by which points move by some 100 px besides the rotation.
SE3 someMotion(const AnyCamera& camera, Random& random) {
  const double focal = camera.parameter("fx");
  const double step = 100.0 / focal * 3.5;
  Eigen::Vector3d direction(random.normal(), random.normal(), 0.5 * random.normal());
  return {SO3::exp(random.uniform(0, 0.1) * randomDirection(random)), step * direction.normalized()};
}

// Over many pairs of images.
struct MotionErrors {
  int num_cases = 0;
  int num_general = 0;
  double turn_square = 0;       // sum, deg^2
  double direction_square = 0;  // sum, deg^2
  int num_values = 0;
  int num_covered = 0;  // within 1.96 standard deviations

  void add(const TwoView& two, const SE3& truth) {
    ++num_cases;
    num_general += two.kind == TwoViewKind::kGeneral ? 1 : 0;
    const Eigen::Vector3d turn = (truth.rotation.inverse() * two.b_from_a.rotation).log();
    const Eigen::Vector3d shift =
        truth.rotation.inverse() * (two.b_from_a.translation - truth.translation.normalized());
    turn_square += std::pow(180 / std::numbers::pi, 2) * turn.squaredNorm();
    direction_square += std::pow(angleDeg(two.b_from_a.translation, truth.translation), 2);
    Eigen::Matrix<double, 6, 1> error;
    error << shift, turn;
    for (Eigen::Index k = 0; k < 6; ++k) {
      num_values += 1;
      num_covered += std::abs(error[k]) < 1.96 * std::sqrt(two.covariance(k, k)) ? 1 : 0;
    }
  }
};

// Through each of the cameras.
MotionErrors motionErrors(double false_share, int cases_each) {
  MotionErrors errors;
  for (const AnyCamera& camera : footageCameras()) {
    Random random(11);
    for (int i = 0; i < cases_each; ++i) {
      const SE3 truth = someMotion(camera, random);
      const auto points = scatteredPoints(camera, 300, random).points;
      errors.add(estimateTwoView(camera, matchesOf(camera, points, truth, false_share, random), kFootageSize),
                 truth);
    }
  }
  return errors;
}

void expectAccurate(const MotionErrors& errors) {
  std::printf("%d pairs: rotation %.3f deg, direction %.3f deg, %.1f %% within 1.96 standard deviations\n",
              errors.num_cases, std::sqrt(errors.turn_square / errors.num_cases),
              std::sqrt(errors.direction_square / errors.num_cases),
              100.0 * errors.num_covered / errors.num_values);
  EXPECT_EQ(errors.num_general, errors.num_cases);
  EXPECT_LT(std::sqrt(errors.turn_square / errors.num_cases), 0.05);
  EXPECT_LT(std::sqrt(errors.direction_square / errors.num_cases), 0.5);
}

TEST(TwoView, PosesAreAccurateAndTheirCovarianceIsHonest) {
  const MotionErrors errors = motionErrors(0, 60);
  EXPECT_EQ(errors.num_cases, 4 * 60);
  EXPECT_EQ(errors.num_values, 6 * errors.num_cases);
  expectAccurate(errors);
  EXPECT_GT(errors.num_covered, 0.92 * errors.num_values);
  EXPECT_LT(errors.num_covered, 0.98 * errors.num_values);
}

// Those near their epipolar lines stay, so the covariance is a little too small.
TEST(TwoView, PosesAreAccurateAmongFalseMatches) {
  const MotionErrors errors = motionErrors(0.2, 40);
  EXPECT_EQ(errors.num_cases, 4 * 40);
  expectAccurate(errors);
}

TEST(TwoView, FalseMatchesAreFound) {
  Random random(5);
  const AnyCamera camera = footageCameras()[1];
  const SE3 truth = someMotion(camera, random);
  const ScatteredPoints scattered = scatteredPoints(camera, 300, random);
  std::vector<PixelMatch> matches = matchesOf(camera, scattered.points, truth, 0, random);
  const std::size_t num_false = matches.size() / 2;
  for (std::size_t i = 0; i < num_false; ++i) matches[i].b = {random.uniform(0, 639), random.uniform(0, 479)};
  const TwoView two = estimateTwoView(camera, matches, kFootageSize);
  std::size_t num_mistaken = 0;
  for (std::size_t i = 0; i < matches.size(); ++i)
    num_mistaken += two.is_inlier[i] != (i >= num_false) ? 1 : 0;
  EXPECT_GT(num_false, 100U);
  EXPECT_LT(num_mistaken, num_false / 20);  // a false match may lie on its epipolar line
}

TEST(TwoView, RotationAndPlaneAreRecognised) {
  int num_cases = 0;
  for (const AnyCamera& camera : footageCameras()) {
    SCOPED_TRACE(camera.modelId());
    Random random(6);
    for (int i = 0; i < 10; ++i) {
      const SE3 turn{SO3::exp(0.15 * randomDirection(random)), Eigen::Vector3d::Zero()};
      const auto turned = matchesOf(camera, scatteredPoints(camera, 300, random).points, turn, 0.1, random);
      EXPECT_EQ(estimateTwoView(camera, turned, kFootageSize).kind, TwoViewKind::kRotation);

      // A plane at 3 m, a little inclined.
      const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.1, 1).normalized();
      std::vector<Eigen::Vector3d> on_plane;
      for (const Eigen::Vector3d& p : scatteredPoints(camera, 600, random).points) {
        if (normal.dot(p.normalized()) > 0.2) on_plane.push_back(3 / normal.dot(p) * p);
      }
      const SE3 moved{SO3::exp(0.05 * randomDirection(random)), Eigen::Vector3d(0.5, -0.2, 0.1)};
      EXPECT_EQ(estimateTwoView(camera, matchesOf(camera, on_plane, moved, 0.1, random), kFootageSize).kind,
                TwoViewKind::kPlane);
      num_cases += 2;
    }
  }
  EXPECT_EQ(num_cases, 80);
}

TEST(TwoView, UnrelatedMatchesHaveNoMotion) {
  Random random(7);
  const AnyCamera camera = footageCameras()[0];
  for (int i = 0; i < 10; ++i) {
    std::vector<PixelMatch> matches;
    for (int k = 0; k < 200; ++k) {
      matches.push_back({{random.uniform(0, 639), random.uniform(0, 479)},
                         {random.uniform(0, 639), random.uniform(0, 479)}});
    }
    const TwoView two = estimateTwoView(camera, matches, kFootageSize);
    EXPECT_LT(two.num_inliers, 40U);
  }
  EXPECT_EQ(estimateTwoView(camera, {}, kFootageSize).kind, TwoViewKind::kNone);
}

TEST(TwoView, PointsOnRaysMayLieAtInfinity) {
  const std::vector<SE3> poses = {SE3(), {SO3(), Eigen::Vector3d(-0.5, 0, 0)}};
  const Eigen::Vector3d far = Eigen::Vector3d(0.1, 0.2, 1).normalized();
  const Eigen::Vector4d at_infinity = pointOnRays(poses, std::vector<Eigen::Vector3d>{far, far});
  EXPECT_NEAR(at_infinity.w(), 0, 1e-12);
  EXPECT_NEAR((at_infinity.head<3>() - far).norm(), 0, 1e-12);
  const Eigen::Vector3d p(0.3, -0.4, 2);
  const Eigen::Vector4d near =
      pointOnRays(poses, std::vector<Eigen::Vector3d>{p.normalized(), (poses[1] * p).normalized()});
  EXPECT_NEAR((near.head<3>() / near.w() - p).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace alidade
