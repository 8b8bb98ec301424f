// SPDX-License-Identifier: MIT
#include "alidade/camera/batch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "alidade/core/lanes.h"
#include "alidade/core/random.h"
#include "alidade/core/vector_code.h"
#include "support/cameras_of_model.h"
#include "support/rays.h"

namespace alidade {
namespace {

constexpr double kSameRelative = 1e-12;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kNumPoints = 20003;  // of each set of parameters; leaves a rest behind whole groups

struct Points {
  std::vector<double> x, y, z;

  explicit Points(std::size_t n) : x(n), y(n), z(n) {}
  [[nodiscard]] std::size_t size() const { return x.size(); }
  [[nodiscard]] Eigen::Vector3d at(std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, const Eigen::Vector3d& p) {
    x[i] = p.x();
    y[i] = p.y();
    z[i] = p.z();
  }
  [[nodiscard]] PointColumns columns() const { return {x, y, z}; }
};

struct Pixels {
  std::vector<double> u, v;
  std::vector<ProjectStatus> status;

  explicit Pixels(std::size_t n) : u(n), v(n), status(n) {}
  [[nodiscard]] Eigen::Vector2d at(std::size_t i) const { return {u[i], v[i]}; }
  [[nodiscard]] PixelResults results() { return {u, v, status}; }
};

// Rays over all angles, many of them inside the domain and at its very rim, and what is no point.
Points pointsAround(const AnyCamera& camera, std::uint64_t seed) {
  Random random(seed);
  Points points(kNumPoints);
  const double max_angle = camera.cone().max_angle_rad;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double limit = i % 2 == 0 ? std::numbers::pi : max_angle;
    const double angle = i % 100 == 1 ? max_angle * (1 - 1e-6 * random.uniform()) : limit * random.uniform();
    points.set(i, random.uniform(0.1, 50.0) * rayAt(angle, random.uniform(0, 2 * std::numbers::pi)));
  }
  const std::vector<Eigen::Vector3d> special = {
      {0, 0, 1},         {0, 0, -1},     {0, 0, 0},         {1, 0, 0},         {0, -3, 0},
      {NAN, 0, 1},       {0, 0, NAN},    {0, kInfinity, 1}, {0, 0, kInfinity}, {1e-101, 0, 1e-101},
      {1e101, 0, 1e101}, {1e-9, 0, 1},   {0, 1e-13, 1},     {1e-160, 0, 1},    {1e-3, 1e-3, 1},
      {1e-90, 0, 1e-90}, {1e90, 0, 1e90}};
  for (std::size_t i = 0; i < special.size(); ++i) points.set(7 * i + 3, special[i]);
  return points;
}

// Both variants of the loops in turn, or the only one that the processor has.
class Variants {
 public:
  Variants() : has_(usesAvx2()) {}
  ~Variants() { usesAvx2() = has_; }
  Variants(const Variants&) = delete;
  Variants& operator=(const Variants&) = delete;

  template <class F>
  void forEach(F&& f) const {
    usesAvx2() = false;
    f();
    if (!has_) return;
    usesAvx2() = true;
    f();
  }

 private:
  bool has_;
};

// How far rounding of a point moves its pixel: much near 90 degrees of a perspective camera.
double roundingPx(const AnyCamera& camera, const Eigen::Vector3d& p_cam) {
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J;
  EXPECT_TRUE(camera.project(p_cam, J.data(), nullptr).ok());
  return 8 * std::numeric_limits<double>::epsilon() * J.norm() * p_cam.norm();
}

template <class A, class B>
double relativeDifference(const A& a, const B& b) {
  return (a - b).norm() / (1 + b.norm());
}

class BatchOf : public OfModel {};
INSTANTIATE_TEST_SUITE_P(, BatchOf, testing::ValuesIn(modelIds()), nameOfModel);

TEST_P(BatchOf, ProjectsLikeOneByOne) {
  const SE3 pose{.rotation = SO3::exp({0.1, -0.2, 0.3}), .translation = {0.05, -0.02, 0.1}};
  for (const AnyCamera& camera : cameras()) {
    const Points points_cam = pointsAround(camera, 1);
    Points points(kNumPoints);
    for (std::size_t i = 0; i < kNumPoints; ++i) points.set(i, pose.inverse() * points_cam.at(i));
    Variants().forEach([&] {
      Pixels plain(kNumPoints);
      projectBatch(camera, points_cam.columns(), plain.results());
      Pixels posed(kNumPoints);
      projectBatch(camera, pose, points.columns(), posed.results());
      std::size_t num_ok = 0;
      std::size_t num_at_rim = 0;
      for (std::size_t i = 0; i < kNumPoints; ++i) {
        const Projection one = camera.project(points_cam.at(i));
        ASSERT_EQ(plain.status[i], one.status) << points_cam.at(i).transpose();
        ASSERT_EQ(std::isnan(plain.u[i]) || std::isnan(plain.v[i]), !one.ok());
        if (one.ok()) {
          ASSERT_LE((plain.at(i) - one.pixel).norm(),
                    kSameRelative * one.pixel.norm() + roundingPx(camera, points_cam.at(i)))
              << points_cam.at(i).transpose();
          ++num_ok;
        }
        // Through the pose the point itself is rounded, which the rim and lengths that differ by far magnify.
        if (std::abs(std::log10(points_cam.at(i).norm())) > 3) continue;
        const Projection through = camera.project(pose * points.at(i));
        if (posed.status[i] != through.status) {
          ++num_at_rim;
          continue;
        }
        ASSERT_EQ(std::isnan(posed.u[i]), !through.ok());
        if (through.ok()) {
          ASSERT_LE((posed.at(i) - through.pixel).norm(),
                    kSameRelative * through.pixel.norm() + 8 * roundingPx(camera, pose * points.at(i)));
        }
      }
      EXPECT_GT(num_ok, kNumPoints / 2);
      EXPECT_LE(num_at_rim, 2U);
    });
  }
}

TEST_P(BatchOf, GivesTheJacobiansOfOneByOne) {
  using Rows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
  const SE3 pose{.rotation = SO3::exp({0.1, -0.2, 0.3}), .translation = {0.05, -0.02, 0.1}};
  const Eigen::Matrix3d R = pose.rotation.matrix();
  for (const AnyCamera& camera : cameras()) {
    const std::size_t num_params = camera.parameters().size();
    const Points points_cam = pointsAround(camera, 2);
    Points points(kNumPoints);
    for (std::size_t i = 0; i < kNumPoints; ++i) points.set(i, pose.inverse() * points_cam.at(i));
    Variants().forEach([&] {
      Pixels pixels(kNumPoints);
      std::vector<double> by_point(6 * kNumPoints), by_pose(12 * kNumPoints),
          by_params(2 * num_params * kNumPoints);
      projectBatch(camera, pose, points.columns(), pixels.results(),
                   {by_point.data(), by_pose.data(), by_params.data()});
      std::size_t num_ok = 0;
      for (std::size_t i = 0; i < kNumPoints; ++i) {
        const Eigen::Map<const Rows> of_point(by_point.data() + 6 * i, 2, 3);
        const Eigen::Map<const Rows> of_pose(by_pose.data() + 12 * i, 2, 6);
        const Eigen::Map<const Rows> of_params(by_params.data() + 2 * num_params * i, 2,
                                               static_cast<int>(num_params));
        if (pixels.status[i] != ProjectStatus::kOk) {
          ASSERT_TRUE(of_point.array().isNaN().all() && of_pose.array().isNaN().all() &&
                      of_params.array().isNaN().all());
          continue;
        }
        if (std::abs(std::log10(points_cam.at(i).norm())) > 3) continue;
        Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_cam;
        Rows J_params(2, static_cast<int>(num_params));
        const Projection one = camera.project(pose * points.at(i), J_cam.data(), J_params.data());
        if (!one.ok()) continue;  // on the very rim
        Rows J_pose(2, 6);
        J_pose.leftCols<3>() = J_cam * R;
        J_pose.rightCols<3>() = -J_cam * R * hat(points.at(i));
        // Near a fold or the model's end derivatives change quickly: a point rounded otherwise has others.
        ASSERT_LE(relativeDifference(of_point, J_pose.leftCols<3>()), 1e-8) << points_cam.at(i).transpose();
        ASSERT_LE(relativeDifference(of_pose, J_pose), 1e-8) << points_cam.at(i).transpose();
        ASSERT_LE(relativeDifference(of_params, J_params), 1e-8) << points_cam.at(i).transpose();
        ++num_ok;
      }
      EXPECT_GT(num_ok, kNumPoints / 2);
    });
  }
}

TEST_P(BatchOf, UnprojectsLikeOneByOne) {
  for (const AnyCamera& camera : cameras()) {
    Random random(3);
    Pixels pixels(kNumPoints);
    for (std::size_t i = 0; i < kNumPoints; ++i) {
      // Over the image and as much again on each side, some of them those of rays at the rim.
      pixels.u[i] = random.uniform(-1.0, 2.0) * kTestImage.width;
      pixels.v[i] = random.uniform(-1.0, 2.0) * kTestImage.height;
      if (i % 50 != 0) continue;
      const double angle = camera.cone().max_angle_rad * (1 - 1e-7 * random.uniform());
      const Projection rim = camera.project(rayAt(angle, random.uniform(0, 2 * std::numbers::pi)));
      if (rim.ok()) pixels.u[i] = rim.pixel.x(), pixels.v[i] = rim.pixel.y();
    }
    const std::vector<double> special = {camera.parameters()[2], NAN, kInfinity, -kInfinity, 1e200, -1e300};
    for (std::size_t i = 0; i < special.size(); ++i) {
      pixels.u[11 * i + 1] = special[i];
      pixels.v[11 * i + 1] = camera.parameters()[3];
    }
    Variants().forEach([&] {
      Points rays(kNumPoints);
      std::vector<ProjectStatus> status(kNumPoints);
      std::vector<double> J(6 * kNumPoints);
      unprojectBatch(camera, {pixels.u, pixels.v}, {rays.x, rays.y, rays.z, status}, J.data());
      std::size_t num_ok = 0;
      for (std::size_t i = 0; i < kNumPoints; ++i) {
        Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_one;
        const auto one = camera.unproject(pixels.at(i), J_one.data());
        ASSERT_EQ(status[i], one ? ProjectStatus::kOk : ProjectStatus::kOutsideDomain)
            << pixels.at(i).transpose();
        const Eigen::Map<const Eigen::Matrix<double, 3, 2, Eigen::RowMajor>> J_batch(J.data() + 6 * i);
        if (!one) {
          ASSERT_TRUE(std::isnan(rays.x[i]) && std::isnan(rays.y[i]) && std::isnan(rays.z[i]));
          ASSERT_TRUE(J_batch.array().isNaN().all());
          continue;
        }
        // How far rounding of the pixel moves the ray: much where the lens nearly folds.
        const double magnified = 1e-13 * (1 + pixels.at(i).norm()) * J_one.norm();
        ASSERT_LE((rays.at(i) - *one).norm(), kSameRelative + magnified) << pixels.at(i).transpose();
        ASSERT_LE((camera.project(rays.at(i)).pixel - pixels.at(i)).norm(),
                  1e-7 + roundingPx(camera, rays.at(i)));
        if (i % 50 != 0) {
          ASSERT_LE(relativeDifference(J_batch, J_one), 1e-6);
        }
        ++num_ok;
      }
      EXPECT_GT(num_ok, kNumPoints / 20);
    });
  }
}

// The rays of pixels a little to each side give the same derivative.
TEST_P(BatchOf, MayAnswerInTheArraysOfTheQuestion) {
  for (const AnyCamera& camera : cameras()) {
    const Points points = pointsAround(camera, 4);
    Variants().forEach([&] {
      Pixels pixels(kNumPoints);
      projectBatch(camera, points.columns(), pixels.results());
      Points in_place = points;
      std::vector<ProjectStatus> status(kNumPoints);
      projectBatch(camera, in_place.columns(), {in_place.x, in_place.y, status});
      Points rays(kNumPoints);
      unprojectBatch(camera, {pixels.u, pixels.v}, {rays.x, rays.y, rays.z, pixels.status});
      Points rays_in_place = in_place;
      unprojectBatch(camera, {rays_in_place.x, rays_in_place.y},
                     {rays_in_place.x, rays_in_place.y, rays_in_place.z, status});
      const auto is_same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
      for (std::size_t i = 0; i < kNumPoints; ++i) {
        ASSERT_TRUE(is_same(in_place.x[i], pixels.u[i]) && is_same(in_place.y[i], pixels.v[i])) << i;
        ASSERT_EQ(status[i], pixels.status[i]) << i;
        ASSERT_TRUE(is_same(rays_in_place.x[i], rays.x[i]) && is_same(rays_in_place.y[i], rays.y[i]) &&
                    is_same(rays_in_place.z[i], rays.z[i]))
            << i;
      }
    });
  }
}

TEST_P(BatchOf, RaysMoveAsTheJacobianSays) {
  constexpr double kStep = 1e-3;  // px
  for (const AnyCamera& camera : cameras()) {
    Random random(4);
    int num_checked = 0;
    for (int i = 0; i < 500; ++i) {
      const double angle = 0.9 * camera.cone().max_angle_rad * random.uniform();
      const Projection at = camera.project(rayAt(angle, random.uniform(0, 2 * std::numbers::pi)));
      ASSERT_TRUE(at.ok());
      Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J;
      const auto ray = camera.unproject(at.pixel, J.data());
      ASSERT_TRUE(ray);
      EXPECT_LE((ray->transpose() * J).norm(), 1e-12 * J.norm());
      for (int c = 0; c < 2; ++c) {
        const auto right = camera.unproject(at.pixel + kStep * Eigen::Vector2d::Unit(c));
        const auto left = camera.unproject(at.pixel - kStep * Eigen::Vector2d::Unit(c));
        ASSERT_TRUE(right && left);
        const Eigen::Vector3d expected = (*right - *left) / (2 * kStep);
        // The second difference says how much of the difference is curvature.
        const double curvature = (*right + *left - 2 * *ray).norm() / kStep;
        ASSERT_LE((J.col(c) - expected).norm(), 1e-6 * expected.norm() + curvature + 1e-11)
            << "angle " << angle;
      }
      ++num_checked;
    }
    EXPECT_EQ(num_checked, 500);
  }
}

TEST(Batch, GivesTheSameOfAPointWhereverItStands) {
  const AnyCamera camera =
      AnyCamera::make("kannala_brandt", std::vector<double>{380, 381, 640, 480, 0.04, -0.05, 0.02, -0.003});
  Random random(5);
  constexpr std::size_t kCount = 3 * kNumLanes + 1;
  Points points(kCount);
  for (std::size_t i = 0; i < kCount; ++i) points.set(i, rayAt(random.uniform(0, 1.7), random.uniform(0, 6)));
  Pixels all(kCount);
  projectBatch(camera, points.columns(), all.results());
  int num_checked = 0;
  for (std::size_t begin = 0; begin < kCount; ++begin) {
    for (std::size_t count = 0; begin + count <= kCount; ++count) {
      Points some(count);
      for (std::size_t i = 0; i < count; ++i) some.set(i, points.at(begin + i));
      Pixels pixels(count);
      projectBatch(camera, some.columns(), pixels.results());
      for (std::size_t i = 0; i < count; ++i) {
        EXPECT_EQ(pixels.at(i), all.at(begin + i));
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 455);
}

// Rows give what columns give, digit by digit; the count leaves a rest behind whole groups.
TEST_P(BatchOf, RowsAgreeWithColumns) {
  constexpr std::size_t kCount = 1003;
  const AnyCamera camera = cameras().front();
  const SE3 pose{.rotation = SO3::exp({0.1, -0.2, 0.3}), .translation = {0.05, -0.02, 0.1}};
  const Points around = pointsAround(camera, 4);
  Points points(kCount);
  std::vector<double> rows;
  for (std::size_t i = 0; i < kCount; ++i) {
    points.set(i, around.at(i));
    rows.insert(rows.end(), {points.x[i], points.y[i], points.z[i]});
  }
  const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  const std::size_t num_by_params = 2 * camera.parameters().size();
  std::size_t num_ok = 0;
  Variants().forEach([&] {
    for (const SE3* const camera_from_points : {static_cast<const SE3*>(nullptr), &pose}) {
      Pixels expected(kCount);
      std::vector<double> by_params(kCount * num_by_params);
      std::vector<double> by_params_of_rows(kCount * num_by_params);
      if (camera_from_points == nullptr) {
        projectBatch(camera, points.columns(), expected.results(), {.by_params = by_params.data()});
      } else {
        projectBatch(camera, pose, points.columns(), expected.results(), {.by_params = by_params.data()});
      }
      std::vector<double> pixels(2 * kCount);
      std::vector<ProjectStatus> status(kCount);
      projectRows(camera, camera_from_points, rows, pixels, status, {.by_params = by_params_of_rows.data()});
      EXPECT_EQ(status, expected.status);
      EXPECT_TRUE(std::ranges::equal(by_params_of_rows, by_params, same));
      for (std::size_t i = 0; i < kCount; ++i) {
        ASSERT_TRUE(same(pixels[2 * i], expected.u[i]) && same(pixels[2 * i + 1], expected.v[i])) << i;
        num_ok += status[i] == ProjectStatus::kOk ? 1 : 0;
      }
      Points rays(kCount);
      std::vector<ProjectStatus> ray_status(kCount);
      std::vector<double> J(6 * kCount);
      unprojectBatch(camera, {expected.u, expected.v}, {rays.x, rays.y, rays.z, ray_status}, J.data());
      std::vector<double> rays_in_rows(3 * kCount);
      std::vector<double> J_of_rows(6 * kCount);
      unprojectRows(camera, pixels, rays_in_rows, status, J_of_rows.data());
      EXPECT_EQ(status, ray_status);
      EXPECT_TRUE(std::ranges::equal(J_of_rows, J, same));
      for (std::size_t i = 0; i < kCount; ++i) {
        ASSERT_TRUE(same(rays_in_rows[3 * i], rays.x[i]) && same(rays_in_rows[3 * i + 1], rays.y[i]) &&
                    same(rays_in_rows[3 * i + 2], rays.z[i]))
            << i;
      }
    }
  });
  EXPECT_GT(num_ok, kCount);
}

}  // namespace
}  // namespace alidade
