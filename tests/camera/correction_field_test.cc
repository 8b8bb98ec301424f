// SPDX-License-Identifier: MIT
#include "alidade/camera/correction_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "alidade/camera/batch.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/camera/image_domain.h"
#include "alidade/camera/model_fit.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "support/cameras_of_model.h"
#include "support/loop_variants.h"
#include "support/rays.h"

namespace alidade {
namespace {

constexpr ImageSize kImage{.width = 640, .height = 480};

// Control points scattered by this many pixels.
CorrectionField scattered(const CorrectionGrid& grid, double px, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> points;
  for (int i = 0; i < 2 * grid.numPoints(); ++i) points.push_back(px * random.normal());
  return {grid, std::move(points)};
}

AnyCamera corrected(const AnyCamera& camera, double px = 2) {
  return camera.withCorrection(
      std::make_shared<const CorrectionField>(scattered(CorrectionGrid::over(kImage, 8, 6), px, 5)));
}

// The cubic B-spline about 0, by its definition: the fourfold convolution of a unit step.
double basis(double t) {
  const double a = std::abs(t);
  if (a >= 2) return 0;
  return a >= 1 ? std::pow(2 - a, 3) / 6 : (4 - 6 * a * a + 3 * a * a * a) / 6;
}

TEST(CorrectionField, IsTheSumOfItsSplines) {
  const CorrectionGrid grid = CorrectionGrid::over(kImage, 5, 4);
  const CorrectionField field = scattered(grid, 1, 3);
  Random random(4);
  for (int k = 0; k < 500; ++k) {
    const Eigen::Vector2d pixel(random.uniform(-0.5, 639.5), random.uniform(-0.5, 479.5));
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int j = 0; j < 7; ++j) {
      for (int i = 0; i < 8; ++i) {
        const double weight =
            basis((pixel.x() + 0.5) / 128 - (i - 1)) * basis((pixel.y() + 0.5) / 120 - (j - 1));
        const auto at = static_cast<std::size_t>(2 * (8 * j + i));
        sum += weight * Eigen::Vector2d(field.points()[at], field.points()[at + 1]);
      }
    }
    Eigen::Matrix2d gradient;
    ASSERT_NEAR((field.at(pixel, &gradient) - sum).norm(), 0, 1e-13);
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = 1e-4 * Eigen::Vector2d::Unit(axis);
      const Eigen::Vector2d slope = (field.at(pixel + step) - field.at(pixel - step)) / 2e-4;
      ASSERT_NEAR((gradient.col(axis) - slope).norm(), 0, 1e-8);
    }
    ASSERT_LE(field.at(pixel).norm(), field.largest());
  }
}

// Beyond the grid it stays as it is at the border.
TEST(CorrectionField, IsConstantBeyondItsGrid) {
  const CorrectionField field = scattered(CorrectionGrid::over(kImage, 5, 4), 1, 3);
  EXPECT_EQ(field.at({-500, 100}), field.at({-0.5, 100}));
  EXPECT_EQ(field.at({900, 9000}), field.at({639.5, 479.5}));
  Eigen::Matrix2d gradient;
  static_cast<void>(field.at({-500, 100}, &gradient));
  EXPECT_EQ(gradient.col(0), Eigen::Vector2d::Zero());
  EXPECT_NE(gradient.col(1), Eigen::Vector2d::Zero());
}

TEST(CorrectionField, IsUndoneEverywhere) {
  int num_checked = 0;
  // From slight displacements to as many as may be without a fold.
  for (const double px : {0.3, 3.0, 14.0}) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const CorrectionField field = scattered(CorrectionGrid::over(kImage, 4, 3), px, seed);
      Random random(seed);
      for (int k = 0; k < 1000; ++k) {
        const Eigen::Vector2d pixel(random.uniform(-900, 1500), random.uniform(-900, 1500));
        const auto back = field.undisplaced(pixel + field.at(pixel));
        ASSERT_TRUE(back);
        ASSERT_NEAR((*back - pixel).norm(), 0, 1e-9);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 9000);
  EXPECT_FALSE(scattered(CorrectionGrid::over(kImage, 4, 3), 1, 1).undisplaced({std::nan(""), 1}));
}

TEST(CorrectionField, RefusesWhatMayFold) {
  const CorrectionGrid grid = CorrectionGrid::over(kImage, 4, 3);
  const auto made = [&](CorrectionGrid of, std::size_t count, double value) {
    return CorrectionField(of, std::vector<double>(count, value));
  };
  const std::size_t count = 2 * static_cast<std::size_t>(grid.numPoints());
  EXPECT_NO_THROW(made(grid, count, 1e5));  // a shift
  EXPECT_THROW(made(grid, count - 2, 0), Error);
  EXPECT_THROW(made(grid, count, std::nan("")), Error);
  EXPECT_THROW(made(grid, count, 1e7), Error);
  EXPECT_THROW(made({.columns = 0, .rows = 3, .cell_px = {9, 9}}, 36, 0), Error);
  EXPECT_THROW(made({.columns = 100'000, .rows = 100'000, .cell_px = {9, 9}}, 36, 0), Error);
  EXPECT_THROW(made({.columns = 4, .rows = 3, .cell_px = {0, 9}}, count, 0), Error);
  EXPECT_THROW(made({.columns = 4, .rows = 3, .origin_px = {std::nan(""), 0}, .cell_px = {9, 9}}, count, 0),
               Error);
  // Mirrored about the middle in x: folded. Stretched twice as wide: not.
  for (const double stretch : {-2.0, -1.0, -0.9, 1.0}) {
    std::vector<double> points(count, 0.0);
    for (int i = 0; i < grid.numPoints(); ++i)
      points[2 * static_cast<std::size_t>(i)] = stretch * grid.cell_px.x() * (i % grid.pointsAcross());
    if (stretch > -0.95) {
      EXPECT_NO_THROW(CorrectionField(grid, points)) << stretch;
    } else {
      EXPECT_THROW(CorrectionField(grid, points), Error) << stretch;
    }
  }
  // Fields that are accepted never fold; of those without a fold, most are accepted.
  int num_sound = 0;
  int num_accepted = 0;
  Random random(1);
  for (int k = 0; k < 400; ++k) {
    // Waves, as strong lenses have them; those of noise between neighbours are refused sooner.
    std::vector<double> points;
    const double px = random.uniform(10, 500);
    const Eigen::Vector4d wave(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 6),
                               random.uniform(0, 6));
    for (int i = 0; i < grid.numPoints(); ++i) {
      const double at = wave.x() * (i % grid.pointsAcross()) + wave.y() * (i / grid.pointsAcross());
      points.insert(points.end(), {px * std::sin(at + wave.z()), px * std::sin(at + wave.w())});
    }
    double least = 1;
    const auto slopes = [&](const Eigen::Vector2d& pixel) {
      const CorrectionGrid::Patch patch = grid.patchAt(pixel);
      Eigen::Matrix2d J = Eigen::Matrix2d::Identity();
      for (std::size_t j = 0; j < 4; ++j) {
        for (std::size_t i = 0; i < 4; ++i) {
          const std::size_t at = 2 * (patch.first + 7 * j + i);
          const Eigen::Vector2d point(points[at], points[at + 1]);
          J += point * Eigen::RowVector2d(patch.dx[i] * patch.y[j], patch.x[i] * patch.dy[j]);
        }
      }
      return J;
    };
    for (double v = 0; v < 480; v += 8) {
      for (double u = 0; u < 640; u += 8) least = std::min(least, slopes({u, v}).determinant());
    }
    num_sound += least > 0 ? 1 : 0;
    try {
      const CorrectionField field(grid, points);
      ++num_accepted;
      EXPECT_GT(least, 0);
    } catch (const Error&) {
      continue;
    }
  }
  EXPECT_GT(num_sound, 100);
  EXPECT_LT(num_sound, 300);
  EXPECT_GT(num_accepted, num_sound * 45 / 100) << num_sound;
}

// Control points where no board was seen may be wild.
TEST(CorrectionField, HasASoundPart) {
  const CorrectionGrid grid = CorrectionGrid::over(kImage, 16, 12);
  std::vector<double> points = scattered(grid, 0.5, 6).points();
  const std::vector<double> smooth = points;
  points[2 * static_cast<std::size_t>(3 * grid.pointsAcross() + 1)] = 4000;  // near the upper left corner
  EXPECT_THROW(CorrectionField(grid, points), Error);
  const CorrectionField part = CorrectionField::soundPart(grid, points, {320, 240});
  EXPECT_GE(part.grid().columns * part.grid().rows, 12 * 8);
  EXPECT_LT(part.grid().columns * part.grid().rows, 16 * 12);
  const CorrectionField whole(grid, smooth);
  int num_checked = 0;
  for (double v = 5; v < 480; v += 10) {
    for (double u = 5; u < 640; u += 10) {
      const Eigen::Vector2d cell =
          (Eigen::Vector2d(u, v) - part.grid().origin_px).cwiseQuotient(part.grid().cell_px);
      if (cell.minCoeff() < 0 || cell.x() > part.grid().columns || cell.y() > part.grid().rows) continue;
      ASSERT_NEAR((part.at({u, v}) - whole.at({u, v})).norm(), 0, 1e-12);
      ++num_checked;
    }
  }
  EXPECT_GT(num_checked, 1500);
  EXPECT_EQ(CorrectionField::soundPart(grid, smooth, {-1e9, 1e9}).points(), smooth);
  // Beyond it, there are no pixels, one by one and in batches.
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240})
                               .withCorrection(std::make_shared<const CorrectionField>(part));
  const Eigen::Vector2d corner = part.grid().origin_px;
  ASSERT_TRUE(corner.x() > 10 || corner.y() > 10);
  const std::vector<Eigen::Vector3d> points_cam = {{0, 0, 1}, {(0.0 - 320) / 500, (0.0 - 240) / 500, 1}};
  std::vector<Projection> seen(2);
  projectBatch(camera, points_cam, seen);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(camera.project(points_cam[i]).status,
              i == 0 ? ProjectStatus::kOk : ProjectStatus::kOutsideDomain);
    EXPECT_EQ(seen[i].status, camera.project(points_cam[i]).status);
    EXPECT_EQ(seen[i].pixel.allFinite(), i == 0);
  }
  EXPECT_FALSE(camera.unproject({0, 0}));
  EXPECT_TRUE(camera.unproject({320, 240}));
  EXPECT_FALSE(certifyDomain(camera, kImage).full_image);
  points.assign(points.size(), std::nan(""));
  EXPECT_THROW(static_cast<void>(CorrectionField::soundPart(grid, points, {320, 240})), Error);
}

class CorrectionFieldOf : public OfModel {};
INSTANTIATE_TEST_SUITE_P(Models, CorrectionFieldOf, testing::ValuesIn(modelIds()), nameOfModel);

TEST_P(CorrectionFieldOf, DisplacesPixelsAndTheirDerivatives) {
  Random random(8);
  int num_checked = 0;
  for (const AnyCamera& plain : cameras()) {
    const AnyCamera camera = corrected(plain);
    const auto num_params = static_cast<Eigen::Index>(camera.parameters().size());
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector3d ray =
          rayAt(0.8 * camera.cone().max_angle_rad * random.uniform(), 6.2 * random.uniform());
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J;
      Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_params(2, num_params);
      const Projection seen = camera.project(ray, J.data(), J_params.data());
      ASSERT_TRUE(seen.ok());
      const Eigen::Vector2d of_model = plain.project(ray).pixel;
      ASSERT_EQ(seen.pixel, of_model + camera.correction()->at(of_model));
      if (of_model.norm() > 1e5) continue;
      constexpr double kStep = 1e-7;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(axis);
        const Eigen::Vector2d slope =
            (camera.project(ray + step).pixel - camera.project(ray - step).pixel) / (2 * kStep);
        ASSERT_NEAR((J.col(axis) - slope).norm(), 0, 1e-4 * (1 + slope.norm()));
      }
      std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
      params[2] += 1e-4;
      const Eigen::Vector2d by_cx = (camera.withParameters(params).project(ray).pixel - seen.pixel) / 1e-4;
      ASSERT_NEAR((J_params.col(2) - by_cx).norm(), 0, 1e-5);
      ++num_checked;
    }
  }
  EXPECT_GT(num_checked, 80 * static_cast<int>(cameras().size()));
}

TEST_P(CorrectionFieldOf, IsUndoneByUnproject) {
  Random random(9);
  int num_checked = 0;
  for (const AnyCamera& plain : cameras()) {
    const AnyCamera camera = corrected(plain);
    for (int k = 0; k < 300; ++k) {
      const Eigen::Vector3d ray =
          rayAt(0.95 * camera.cone().max_angle_rad * random.uniform(), 6.2 * random.uniform());
      const Projection seen = camera.project(ray);
      ASSERT_TRUE(seen.ok());
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J;
      Eigen::Matrix<double, 3, 2, Eigen::RowMajor> J_ray;
      const auto back = camera.unproject(seen.pixel, J_ray.data());
      ASSERT_TRUE(back);
      ASSERT_NEAR((*back - ray).norm(), 0, 1e-9);
      static_cast<void>(camera.project(ray, J.data()));
      ASSERT_NEAR((J * J_ray - Eigen::Matrix2d::Identity()).norm(), 0, 1e-6);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 300 * static_cast<int>(cameras().size()));
}

TEST_P(CorrectionFieldOf, IsTheSameInBatches) {
  constexpr std::size_t kNum = 501;
  Random random(9);
  const AnyCamera camera = corrected(cameras().front());
  const std::size_t num_params = camera.parameters().size();
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < kNum; ++i)
    points.push_back(random.uniform(0.02, 2) *
                     rayAt(1.1 * camera.cone().max_angle_rad * random.uniform(), 6.2 * random.uniform()));
  withAndWithoutAvx2([&] {
    std::vector<double> pixels(2 * kNum);
    std::vector<double> by_point(6 * kNum);
    std::vector<double> by_params(2 * num_params * kNum);
    std::vector<ProjectStatus> status(kNum);
    projectRows(camera, nullptr, {points.front().data(), 3 * kNum}, pixels, status,
                {.by_point = by_point.data(), .by_params = by_params.data()});
    std::vector<double> rays(3 * kNum);
    std::vector<ProjectStatus> back(kNum);
    unprojectRows(camera, pixels, rays, back);
    int num_seen = 0;
    for (std::size_t i = 0; i < kNum; ++i) {
      Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J;
      std::vector<double> J_params(2 * num_params);
      const Projection one = camera.project(points[i], J.data(), J_params.data());
      ASSERT_EQ(status[i], one.status) << i;
      ASSERT_EQ(back[i], one.ok() ? ProjectStatus::kOk : ProjectStatus::kOutsideDomain);
      if (!one.ok()) continue;
      const Eigen::Map<const Eigen::Vector2d> pixel(&pixels[2 * i]);
      ASSERT_NEAR((pixel - one.pixel).norm(), 0, 1e-10 * (1 + one.pixel.norm())) << i;
      for (std::size_t k = 0; k < 6; ++k)
        ASSERT_NEAR(by_point[6 * i + k], J.data()[k], 1e-9 * (1 + J.norm()));
      for (std::size_t k = 0; k < J_params.size(); ++k)
        ASSERT_NEAR(by_params[J_params.size() * i + k], J_params[k], 1e-9 * (1 + std::abs(J_params[k])));
      const Eigen::Map<const Eigen::Vector3d> ray(&rays[3 * i]);
      ASSERT_NEAR((ray - points[i].normalized()).norm(), 0, 1e-8);
      ++num_seen;
    }
    EXPECT_GT(num_seen, 350);
  });
}

TEST(CorrectionField, FollowsEdits) {
  const AnyCamera camera = corrected(
      AnyCamera::make("radtan", std::vector<double>{500, 502, 322, 238, -0.2, 0.05, 0.001, -0.0005, 0}));
  const auto turned = rotateCamera(camera, kImage, 1);
  int num_checked = 0;
  for (const EditedCamera& edited :
       {cropCamera(camera, kImage, {.x = 10, .y = 20, .width = 300, .height = 200}),
        resizeCamera(camera, kImage, {.width = 320, .height = 120}), binCamera(camera, kImage, 2), turned,
        rotateCamera(camera, kImage, 2), rotateCamera(camera, kImage, 3)}) {
    const AnyCamera plain = camera.withCorrection(nullptr);
    for (double y = -0.3; y < 0.31; y += 0.1) {
      for (double x = -0.4; x < 0.41; x += 0.1) {
        const Eigen::Vector3d ray(x, y, 1);
        const Eigen::Vector3d own = edited.new_from_old * ray;
        // What the edit does to pixels is that of a camera without distortion.
        const Eigen::Vector2d at = edited.camera.withCorrection(nullptr).project(own).pixel;
        const Eigen::Vector2d was = plain.project(ray).pixel;
        const Eigen::Vector2d step = camera.correction()->at(was);
        const auto& J = edited.J_new_old.view();
        const Eigen::Vector2d moved = J.block<2, 2>(2, 2) * step;
        ASSERT_NEAR((edited.camera.project(own).pixel - at - moved).norm(), 0, 1e-9);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 6 * 63);
  const CorrectionField back = *rotateCamera(turned.camera, turned.size, 3).camera.correction();
  EXPECT_EQ(back.points(), camera.correction()->points());
  EXPECT_NEAR((back.grid().origin_px - camera.correction()->grid().origin_px).norm(), 0, 1e-12);
}

TEST(CorrectionField, IsFittedByAnotherModelAndInTheSelfCheck) {
  const AnyCamera plain =
      AnyCamera::make("kannala_brandt", std::vector<double>{200, 201, 320, 240, 0.01, 0, 0, 0});
  const AnyCamera camera = corrected(plain, 0.5);
  const ModelFit fit = fitModel(camera, kImage, "kannala_brandt");
  EXPECT_EQ(fit.camera.correction(), nullptr);
  EXPECT_FALSE(fit.is_exact);
  EXPECT_GT(fit.rms_px, 0.1);
  EXPECT_LT(fit.rms_px, 0.5);
  const std::vector<SelfCheckPoint> points = makeSelfCheck(camera, kImage);
  EXPECT_TRUE(runSelfCheck(camera, kImage, points).isPassed());
  EXPECT_GT(runSelfCheck(plain, kImage, points).worst_px, 0.05);
  EXPECT_TRUE(certifyDomain(camera, kImage).full_image);
}

}  // namespace
}  // namespace alidade
