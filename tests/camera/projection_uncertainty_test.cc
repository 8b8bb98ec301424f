// SPDX-License-Identifier: MIT
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/camera/camera_variant.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/geometry/se3.h"
#include "alidade/geometry/symmetric_eigen.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kFewColumns = 12;

std::vector<AnyCamera> firstCameras() {
  std::vector<AnyCamera> cameras;
  AllModels::forEach(
      [&]<class M>() { cameras.emplace_back(Camera<M>(ModelFixture<M>::paramSets().front())); });
  return cameras;
}

// The pixels of the points at `distance_m` that `camera` sees at the grid's pixels, by another camera that
// was moved to fit them best: Gauss and Newton with numerical derivatives, to the end.
class BestFit {
 public:
  BestFit(const AnyCamera& camera, const AnyCamera& other, const ProjectionUncertainty& uncertainty,
          double distance_m, int num_freed)
      : other_(other), num_freed_(num_freed) {
    for (std::size_t i = 0; i < uncertainty.pixels().size(); ++i) {
      if (!uncertainty.hasRay(static_cast<int>(i))) continue;
      index_.push_back(static_cast<int>(i));
      pixels_.push_back(uncertainty.pixels()[i]);
      points_.emplace_back(distance_m * *camera.unproject(pixels_.back()));
    }
    constexpr int kRounds = 8;
    constexpr double kStep = 1e-6;
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::VectorXd error = errors(move_);
      Eigen::MatrixXd J(error.size(), num_freed_);
      for (int k = 0; k < num_freed_; ++k) {
        const Eigen::VectorXd by = kStep * Eigen::VectorXd::Unit(num_freed_, k);
        J.col(k) = (errors(moved(by)) - errors(moved(-by))) / (2 * kStep);
      }
      move_ = moved(-(J.transpose() * J).ldlt().solve(J.transpose() * error));
    }
  }

  [[nodiscard]] const std::vector<int>& index() const { return index_; }
  // Where the points appear less where they were, point by point; zero for one that was lost at the rim.
  [[nodiscard]] Eigen::VectorXd left() const { return errors(move_); }

 private:
  // Rotation first; then the position.
  [[nodiscard]] SE3 moved(const Eigen::VectorXd& by) const {
    Eigen::Matrix<double, 6, 1> xi = Eigen::Matrix<double, 6, 1>::Zero();
    xi.tail<3>() = by.head<3>();
    if (num_freed_ > 3) xi.head<3>() = by.tail<3>();
    return move_ * SE3::exp(xi);
  }

  [[nodiscard]] Eigen::VectorXd errors(const SE3& move) const {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(points_.size()));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Projection projection = other_.project(move * points_[i]);
      if (projection.ok()) all.segment<2>(2 * static_cast<Eigen::Index>(i)) = projection.pixel - pixels_[i];
    }
    return all;
  }

  const AnyCamera& other_;
  int num_freed_;
  SE3 move_;
  std::vector<int> index_;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<Eigen::Vector3d> points_;
};

AnyCamera changed(const AnyCamera& camera, const Eigen::VectorXd& change) {
  std::vector<double> params(camera.parameters().begin(), camera.parameters().end());
  for (std::size_t k = 0; k < params.size(); ++k) params[k] += change(static_cast<Eigen::Index>(k));
  return AnyCamera::make(camera.modelId(), params);
}

TEST(ProjectionUncertainty, IsWhatTheBestMoveOfAChangedCameraLeaves) {
  int num_compared = 0;
  for (const AnyCamera& camera : firstCameras()) {
    for (const double distance_m : {kInfinity, 0.7}) {
      const ProjectionUncertainty uncertainty(camera, kTestImage, distance_m, std::nullopt, kFewColumns);
      const bool is_far = std::isinf(distance_m);
      for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(camera.parameters().size()); ++k) {
        const auto n = static_cast<Eigen::Index>(camera.parameters().size());
        // A change that moves pixels by some thousandths, so that only the first order shows.
        double scale = 0;
        for (std::size_t i = 0; i < uncertainty.pixels().size(); ++i)
          scale = std::max(scale, uncertainty.jacobian(static_cast<int>(i)).col(k).norm());
        ASSERT_GT(scale, 0);
        const Eigen::VectorXd change = 2e-3 / scale * Eigen::VectorXd::Unit(n, k);
        const AnyCamera other = changed(camera, change);
        const BestFit best(camera, other, uncertainty, is_far ? 1 : distance_m, is_far ? 3 : 6);
        const Eigen::VectorXd left = best.left();
        for (std::size_t i = 0; i < best.index().size(); ++i) {
          const Eigen::Vector2d expected = uncertainty.jacobian(best.index()[i]) * change;
          EXPECT_LE((left.segment<2>(2 * static_cast<Eigen::Index>(i)) - expected).norm(), 2e-5)
              << camera.modelId() << " " << camera.parameterNames()[static_cast<std::size_t>(k)] << " pixel "
              << uncertainty.pixels()[static_cast<std::size_t>(best.index()[i])].transpose();
          ++num_compared;
        }
      }
    }
  }
  EXPECT_GT(num_compared, 10'000);
}

TEST(ProjectionUncertainty, OfALongLensForgivesThePrincipalPoint) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{20000, 20000, 960, 600});
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(4, 4);
  covariance(2, 2) = 25 * 25;
  const UncertaintyGrid grid = ProjectionUncertainty(camera, kTestImage, kInfinity).grid(covariance);
  EXPECT_LT(grid.worst_px, 0.1);
  EXPECT_GT(grid.worst_px, 0.01);
  // The focal length is not forgiven at infinity, but it is where a step forward has the same effect.
  covariance.setZero();
  covariance(0, 0) = covariance(0, 1) = covariance(1, 0) = covariance(1, 1) = 100 * 100;
  EXPECT_GT(ProjectionUncertainty(camera, kTestImage, kInfinity).grid(covariance).worst_px, 4);
  EXPECT_LT(ProjectionUncertainty(camera, kTestImage, 2.0).grid(covariance).worst_px, 0.1);
}

TEST(ProjectionUncertainty, DoesNotDependOnAFiniteDistance) {
  int num_compared = 0;
  for (const AnyCamera& camera : firstCameras()) {
    const auto n = static_cast<Eigen::Index>(camera.parameters().size());
    const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(n, n);
    const auto near = ProjectionUncertainty(camera, kTestImage, 0.1).worst(covariance);
    const auto far = ProjectionUncertainty(camera, kTestImage, 100).worst(covariance);
    EXPECT_EQ(near.std_px, far.std_px);
    EXPECT_EQ(near.index, far.index);
    const auto turned = ProjectionUncertainty(camera, kTestImage, 5, Freed::kRotation).worst(covariance);
    const auto infinite = ProjectionUncertainty(camera, kTestImage, kInfinity).worst(covariance);
    EXPECT_EQ(turned.std_px, infinite.std_px);
    EXPECT_LT(near.std_px, infinite.std_px);
    ++num_compared;
  }
  EXPECT_EQ(num_compared, 20);
}

TEST(ProjectionUncertainty, GridHasTheBorderAndSquareCells) {
  const ProjectionUncertainty uncertainty(firstCameras().front(), kTestImage, kInfinity);
  EXPECT_EQ(uncertainty.columns(), 40);
  EXPECT_EQ(uncertainty.rows(), 25);
  ASSERT_EQ(uncertainty.pixels().size(), 1000U);
  EXPECT_EQ(uncertainty.pixels().front(), Eigen::Vector2d(0, 0));
  EXPECT_EQ(uncertainty.pixels().back(), Eigen::Vector2d(1919, 1199));
  const Eigen::Vector2d cell = uncertainty.pixels()[41] - uncertainty.pixels()[0];
  EXPECT_NEAR(cell.x() / cell.y(), 1, 0.03);
  const ProjectionUncertainty thin(firstCameras().front(), {.width = 3, .height = 1}, kInfinity);
  EXPECT_EQ(thin.columns(), 3);
  EXPECT_EQ(thin.rows(), 1);
}

TEST(ProjectionUncertainty, SummaryAgreesWithTheGrid) {
  const AnyCamera camera = firstCameras()[1];
  const auto n = static_cast<Eigen::Index>(camera.parameters().size());
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) root(i, j) = std::sin(static_cast<double>(3 * i + 7 * j + 1));
  }
  const Eigen::MatrixXd covariance = 1e-6 * root * root.transpose();
  const ProjectionUncertainty uncertainty(camera, kTestImage, kInfinity);
  const UncertaintyGrid grid = uncertainty.grid(covariance);
  ASSERT_EQ(grid.std_px.size(), grid.pixels.size());
  double worst = 0;
  std::size_t at_worst = 0;
  int num_compared = 0;
  for (std::size_t i = 0; i < grid.std_px.size(); ++i) {
    if (!uncertainty.hasRay(static_cast<int>(i))) continue;
    ++num_compared;
    const auto J = uncertainty.jacobian(static_cast<int>(i));
    const Eigen::Matrix2d pixel = J * covariance * J.transpose();
    const SymmetricEigen solver(pixel);
    EXPECT_NEAR(grid.std_px[i], std::sqrt(solver.eigenvalues()(1)), 1e-9 * grid.std_px[i]);
    if (grid.std_px[i] > worst) at_worst = i;
    worst = std::max(worst, grid.std_px[i]);
  }
  EXPECT_GT(num_compared, 900);
  EXPECT_EQ(grid.worst_pixel, grid.pixels[at_worst]);
  EXPECT_EQ(grid.worst_px, worst);
  EXPECT_EQ(uncertainty.worst(covariance).std_px, worst);
  // With an odd number of columns and rows the centre is one of them.
  const ProjectionUncertainty odd(camera, {.width = 1921, .height = 1153}, kInfinity, std::nullopt, 41);
  const UncertaintyGrid centred = odd.grid(covariance);
  const std::size_t middle = centred.pixels.size() / 2;
  EXPECT_EQ(centred.pixels[middle], Eigen::Vector2d(960, 576));
  EXPECT_NEAR(centred.center_px, centred.std_px[middle], 1e-12);
  EXPECT_TRUE(std::isnan(uncertainty.worst(std::numeric_limits<double>::quiet_NaN() * covariance).std_px));
}

TEST(ProjectionUncertainty, LeavesOutPixelsWithoutARay) {
  // A barrel that folds inside the image.
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{700, 700, 960, 600, -0.3, 0, 0, 0, 0});
  const ProjectionUncertainty uncertainty(camera, kTestImage, kInfinity);
  const UncertaintyGrid grid = uncertainty.grid(Eigen::MatrixXd::Identity(9, 9));
  EXPECT_FALSE(uncertainty.hasRay(0));
  EXPECT_TRUE(std::isnan(grid.std_px[0]));
  EXPECT_TRUE(uncertainty.jacobian(0).isZero(0));
  EXPECT_TRUE(std::isfinite(grid.center_px));
  EXPECT_TRUE(std::isfinite(grid.worst_px));
  EXPECT_NE(grid.worst_pixel, Eigen::Vector2d(0, 0));
}

TEST(ProjectionUncertainty, RefusesWhatMakesNoSense) {
  const AnyCamera camera = firstCameras().front();
  const auto make = [&](double distance_m, std::optional<Freed> freed, int columns) {
    return ProjectionUncertainty(camera, kTestImage, distance_m, freed, columns);
  };
  EXPECT_THROW(make(0, std::nullopt, 40), Error);
  EXPECT_THROW(make(std::nan(""), std::nullopt, 40), Error);
  EXPECT_THROW(make(kInfinity, Freed::kPose, 40), Error);
  EXPECT_THROW(make(1, std::nullopt, 1), Error);
  EXPECT_NO_THROW(make(1, Freed::kRotation, 2));
}

}  // namespace
}  // namespace alidade
