// SPDX-License-Identifier: MIT
// Points of rigs of different lenses come back from their pixels, with the uncertainty that trials show.
#include "alidade/camera/triangulation.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "alidade/core/random.h"

namespace alidade {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

MountedCamera mounted(const std::string& name, std::string_view model, const std::vector<double>& params,
                      const Vector3d& turn, const Vector3d& at, const EntrancePupil& pupil = {}) {
  const SE3 rig_from_camera{SO3::exp(turn), at};
  return {.name = name,
          .camera = AnyCamera::make(model, params).withPupil(pupil),
          .image_size = {640, 480},
          .camera_from_rig = rig_from_camera.inverse()};
}

// Two ordinary lenses side by side, a fisheye that looks across and one that looks back at them from the
// front, and a camera above.
// @param are_central  false: the entrance pupils of the two wide lenses move
AnyRig mixedRig(bool are_central = false) {
  const EntrancePupil moving = are_central ? EntrancePupil() : EntrancePupil{.s1_m = 0.003, .s2_m = -0.001};
  return AnyRig({mounted("left", "radtan", {520, 522, 318, 241, -0.2, 0.05, 1e-3, -5e-4, 0}, {0.01, 0, 0},
                         {0.02, 0, 0}),
                 mounted("right", "thin_prism",
                         {480, 481, 322, 239, -0.1, 0.02, 0, 1e-4, 0, 0.01, 0, 0, 1e-4, 0, 2e-4, 0},
                         {0, -0.05, 0.02}, {0.2, 0.01, 0}),
                 mounted("side", "kannala_brandt", {190, 191, 320, 240, 0.01, -0.003, 0.001, 0},
                         {0, -1.6, 0.1}, {0.9, 0, 0.3}, moving),
                 mounted("opposite", "double_sphere", {300, 301, 319, 242, -0.15, 0.6}, {0, 3.0, 0},
                         {0.1, 0.1, 2.5}, moving),
                 mounted("top", "omni", {450, 452, 320, 238, 0.8, -0.1, 0.02, 1e-4, 0}, {-0.5, 0.1, 0},
                         {0.1, -0.6, 0})});
}

// Exact pixels in the cameras that see the point, in or near the image.
std::vector<RigPixel> pixelsOf(const AnyRig& rig, const Vector3d& point, double sigma_px = 1) {
  std::vector<RigPixel> pixels;
  for (std::size_t i = 0; i < rig.size(); ++i) {
    const Projection projection = rig.project(i, point);
    const bool is_near = projection.pixel.cwiseAbs().maxCoeff() < 1000;  // false for NaN
    if (is_near) pixels.push_back({.camera = i, .pixel = projection.pixel, .sigma_px = sigma_px});
  }
  return pixels;
}

// Points before and beside the rig, near and far.
std::vector<Vector3d> points(int count) {
  Random random(7);
  std::vector<Vector3d> all;
  for (int i = 0; i < count; ++i) {
    const double distance = std::pow(10.0, random.uniform(-0.3, 2));
    const Vector3d direction(random.uniform(-1, 1), random.uniform(-0.6, 0.6), random.uniform(0.2, 1));
    all.push_back(distance * direction.normalized());
  }
  return all;
}

// @param share  largest error, as a share of the standard deviation that a noise of one pixel would cause
void expectExactPoints(const AnyRig& rig, double share) {
  int num_pairs = 0;
  int num_wide = 0;  // with a pixel more than a right angle from its camera's axis
  for (const Vector3d& point : points(300)) {
    const std::vector<RigPixel> all = pixelsOf(rig, point);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if ((rig.camera(all[i].camera).camera_from_rig * point).z() < 0) ++num_wide;
      for (std::size_t j = 0; j < all.size(); ++j) {
        if (i == j) continue;
        const std::vector<RigPixel> two = {all[i], all[j]};
        const Triangulation answer = triangulate(rig, two);
        ASSERT_EQ(answer.status, TriangulationStatus::kOk) << point.transpose() << " " << i << " " << j;
        EXPECT_LT(answer.error_px, 1e-9);
        EXPECT_LT((answer.p_rig - point).norm(), share * std::sqrt(answer.covariance().trace()) + 1e-12)
            << point.transpose() << " " << i << " " << j;
        ++num_pairs;
      }
    }
    const Triangulation answer = triangulate(rig, all);
    ASSERT_TRUE(answer.ok());
    EXPECT_LT((answer.p_rig - point).norm(), share * std::sqrt(answer.covariance().trace()) + 1e-12);
    EXPECT_EQ(answer.residuals.size(), all.size());
    EXPECT_EQ(answer.covariance_by_rig, Matrix3d::Zero());
  }
  EXPECT_GT(num_pairs, 2000);
  EXPECT_GT(num_wide, 100);
}

TEST(Triangulation, FindsExactPoints) {
  expectExactPoints(mixedRig(true), 1e-9);
  // The search ends where pixels agree to 1e-9, in any of two pixels.
  expectExactPoints(mixedRig(), 2e-9);
}

// The minimum is that of the pixel errors, not of the distances from the rays.
TEST(Triangulation, MinimisesWeightedPixelErrors) {
  const AnyRig rig = mixedRig();
  Random random(3);
  int num_checked = 0;
  for (const Vector3d& point : points(40)) {
    std::vector<RigPixel> pixels = pixelsOf(rig, point);
    if (pixels.size() < 3) continue;
    double k = 1;
    for (RigPixel& pixel : pixels) {
      pixel.sigma_px = k++;
      pixel.pixel += Vector2d(random.normal(), random.normal());
    }
    const Triangulation answer = triangulate(rig, pixels);
    if (!answer.ok()) continue;
    const auto cost = [&](const Vector3d& p) {
      double sum = 0;
      for (const RigPixel& pixel : pixels)
        sum += (rig.project(pixel.camera, p).pixel - pixel.pixel).squaredNorm() / std::pow(pixel.sigma_px, 2);
      return sum;
    };
    const double least = cost(answer.p_rig);
    const Eigen::LLT<Matrix3d> std(answer.covariance());
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d step = 1e-3 * std.matrixL().toDenseMatrix().col(axis);
      const double up = cost(answer.p_rig + step);
      const double down = cost(answer.p_rig - step);
      EXPECT_GE(up, least);
      EXPECT_GE(down, least);
      EXPECT_LT(std::abs(up - down), 1e-2 * (up + down - 2 * least));  // the parabola's vertex
    }
    ++num_checked;
  }
  EXPECT_GE(num_checked, 20);
}

// Sample covariance of the points of many trials, by the stated one: near the identity.
Matrix3d normalised(const std::vector<Vector3d>& errors, const Matrix3d& stated) {
  Matrix3d sum = Matrix3d::Zero();
  for (const Vector3d& error : errors) sum += error * error.transpose();
  const Matrix3d L = stated.llt().matrixL();
  const Matrix3d L_inverse = L.inverse();
  return L_inverse * (sum / static_cast<double>(errors.size())) * L_inverse.transpose();
}

// Five standard deviations of an entry of a sample covariance.
double samplingError(int num_trials) {
  return 5 * std::sqrt(2.0 / num_trials);
}

const std::vector<Vector3d> kFewPoints = {{0.1, -0.05, 1.2}, {0.5, 0.2, 2}, {-1, 0.3, 4}, {0.4, 0.05, 0.6}};

TEST(Triangulation, StatesTheUncertaintyByPixels) {
  const AnyRig rig = mixedRig();
  Random random(11);
  constexpr int kNumTrials = 4000;
  int num_checked = 0;
  for (const Vector3d& point : kFewPoints) {
    for (const bool is_pair : {true, false}) {
      std::vector<RigPixel> exact = pixelsOf(rig, point, 0.2);
      ASSERT_GE(exact.size(), 3u);
      if (is_pair) exact.resize(2);
      exact.front().sigma_px = 0.5;
      const Triangulation at_truth = triangulate(rig, exact);
      ASSERT_TRUE(at_truth.ok());
      std::vector<Vector3d> errors;
      for (int i = 0; i < kNumTrials; ++i) {
        std::vector<RigPixel> noisy = exact;
        for (RigPixel& pixel : noisy)
          pixel.pixel += pixel.sigma_px * Vector2d(random.normal(), random.normal());
        const Triangulation answer = triangulate(rig, noisy);
        ASSERT_TRUE(answer.ok());
        errors.push_back(answer.p_rig - point);
      }
      const Matrix3d ratio = normalised(errors, at_truth.covariance());
      EXPECT_LT((ratio - Matrix3d::Identity()).cwiseAbs().maxCoeff(), samplingError(kNumTrials))
          << point.transpose() << "\n"
          << ratio;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 8);
}

// The rig moved by a vector of all its unknowns, in the order of the joint covariance.
AnyRig perturbed(const AnyRig& rig, const Eigen::VectorXd& change) {
  std::vector<MountedCamera> cameras = rig.cameras();
  Eigen::Index at = 0;
  for (MountedCamera& camera : cameras) {
    std::vector<double> params(camera.camera.parameters().begin(), camera.camera.parameters().end());
    for (double& value : params) value += change[at++];
    camera.camera = AnyCamera::make(camera.camera.modelId(), params).withPupil(camera.camera.pupil());
  }
  for (std::size_t i = 1; i < cameras.size(); ++i, at += 6)
    cameras[i].camera_from_rig = cameras[i].camera_from_rig * SE3::exp(change.segment<6>(at));
  EXPECT_EQ(at, change.size());
  return AnyRig(std::move(cameras));
}

// A covariance with correlations all over: half a pixel for fx fy cx cy, small for lenses, a millimetre and a
// milliradian for poses. Its Cholesky factor.
Eigen::MatrixXd rigSpread(const AnyRig& rig, Random& random) {
  Eigen::VectorXd scale(numRigUnknowns(rig));
  Eigen::Index at = 0;
  for (const MountedCamera& camera : rig.cameras()) {
    for (std::size_t k = 0; k < camera.camera.parameters().size(); ++k) scale[at++] = k < 4 ? 0.5 : 1e-4;
  }
  scale.tail(scale.size() - at).setConstant(1e-3);
  Eigen::MatrixXd L = Eigen::MatrixXd::Identity(scale.size(), scale.size());
  for (Eigen::Index r = 0; r < L.rows(); ++r) {
    for (Eigen::Index c = 0; c < r; ++c) L(r, c) = 0.1 * random.normal();
  }
  return scale.asDiagonal() * L;
}

// Against points of rigs with one unknown changed at a time.
TEST(Triangulation, StatesTheUncertaintyByTheRig) {
  const AnyRig rig = mixedRig();
  Random random(19);
  const Eigen::MatrixXd L = rigSpread(rig, random);
  const Eigen::MatrixXd covariance = L * L.transpose();
  const Eigen::Index num_unknowns = numRigUnknowns(rig);
  ASSERT_EQ(num_unknowns, 9 + 16 + 8 + 6 + 9 + 4 * 6);
  std::vector<std::vector<RigPixel>> pixels;
  for (const Vector3d& point : kFewPoints) pixels.push_back(pixelsOf(rig, point, 0.2));
  std::vector<Eigen::MatrixXd> by_unknown(kFewPoints.size(), Eigen::MatrixXd::Zero(3, num_unknowns));
  constexpr double kStep = 1e-6;
  for (Eigen::Index k = 0; k < num_unknowns; ++k) {
    for (const double step : {kStep, -kStep}) {
      const AnyRig moved = perturbed(rig, step * Eigen::VectorXd::Unit(num_unknowns, k));
      for (std::size_t i = 0; i < pixels.size(); ++i)
        by_unknown[i].col(k) += triangulate(moved, pixels[i]).p_rig / (2 * step);
    }
  }
  int num_checked = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    ASSERT_GE(pixels[i].size(), 3u);
    const Triangulation answer = triangulate(rig, pixels[i], covariance);
    ASSERT_TRUE(answer.ok());
    EXPECT_TRUE(answer.covariance_by_pixels.isApprox(triangulate(rig, pixels[i]).covariance_by_pixels));
    const Matrix3d numeric = by_unknown[i] * covariance * by_unknown[i].transpose();
    EXPECT_TRUE(answer.covariance_by_rig.isApprox(numeric, 1e-5)) << answer.covariance_by_rig << "\n\n"
                                                                  << numeric;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);
}

// The noise of pixels and the errors of the rig at once.
TEST(Triangulation, StatesTheWholeUncertainty) {
  const std::vector<MountedCamera> all = mixedRig().cameras();
  const AnyRig rig({all[0], all[2], all[3]});  // those that are fast to make
  Random random(29);
  constexpr int kNumTrials = 800;
  const Eigen::MatrixXd L = rigSpread(rig, random);
  const Vector3d point(0.1, -0.05, 1.2);
  const std::vector<RigPixel> exact = pixelsOf(rig, point, 0.5);
  ASSERT_EQ(exact.size(), 3u);
  const Triangulation at_truth = triangulate(rig, exact, L * L.transpose());
  EXPECT_GT(at_truth.covariance_by_rig.trace(), 0.1 * at_truth.covariance_by_pixels.trace());
  EXPECT_LT(at_truth.covariance_by_rig.trace(), 10 * at_truth.covariance_by_pixels.trace());
  std::vector<Vector3d> errors;
  for (int i = 0; i < kNumTrials; ++i) {
    const auto noise = [&](Eigen::Index) { return random.normal(); };
    const Eigen::VectorXd change = L * Eigen::VectorXd::NullaryExpr(L.rows(), noise);
    std::vector<RigPixel> noisy = exact;
    for (RigPixel& pixel : noisy) pixel.pixel += 0.5 * Vector2d(random.normal(), random.normal());
    const Triangulation answer = triangulate(perturbed(rig, change), noisy);
    ASSERT_TRUE(answer.ok());
    errors.push_back(answer.p_rig - point);
  }
  const Matrix3d ratio = normalised(errors, at_truth.covariance());
  EXPECT_LT((ratio - Matrix3d::Identity()).cwiseAbs().maxCoeff(), samplingError(kNumTrials)) << ratio;
}

TEST(Triangulation, SaysWhyThereIsNoPoint) {
  const AnyRig rig = mixedRig(true);
  const auto status = [&](const std::vector<RigPixel>& pixels) { return triangulate(rig, pixels).status; };
  const std::vector<RigPixel> good = pixelsOf(rig, {0.1, 0, 2});
  EXPECT_EQ(status({}), TriangulationStatus::kTooFewCameras);
  EXPECT_EQ(status({good[0]}), TriangulationStatus::kTooFewCameras);
  EXPECT_EQ(status({good[0], good[0]}), TriangulationStatus::kTooFewCameras);
  EXPECT_EQ(status({good[0], {.camera = 2, .pixel = {9000, 9000}}}), TriangulationStatus::kNoRay);
  // What lies at infinity is seen in one direction from everywhere.
  const auto towards = [&](std::size_t camera, const Vector3d& direction) {
    const MountedCamera& mount = rig.camera(camera);
    const Projection projection = mount.camera.project(mount.camera_from_rig.rotation * direction);
    EXPECT_TRUE(projection.ok());
    return RigPixel{.camera = camera, .pixel = projection.pixel, .sigma_px = 0.2};
  };
  const Vector3d far(0.1, 0.05, 1);
  EXPECT_EQ(status({towards(0, far), towards(1, far), towards(2, far)}), TriangulationStatus::kAtInfinity);
  // Diverging by a tenth of a degree, which a fifth of a pixel does not explain, and by a little.
  EXPECT_EQ(status({towards(0, far), towards(1, far + Vector3d(0.1, 0, 0))}), TriangulationStatus::kBehind);
  EXPECT_EQ(status({towards(0, far), towards(1, far + Vector3d(5e-4, 0, 0))}),
            TriangulationStatus::kAtInfinity);
  EXPECT_EQ(status({towards(0, far), towards(1, far - Vector3d(5e-3, 0, 0))}), TriangulationStatus::kOk);
  // Along the line through two fisheyes, each sees the other and all points between.
  const Vector3d line = rig.camera(3).camera_from_rig.inverse().translation -
                        rig.camera(2).camera_from_rig.inverse().translation;
  EXPECT_EQ(status({towards(2, line), towards(3, -line)}), TriangulationStatus::kUndetermined);
  EXPECT_TRUE(std::isnan(triangulate(rig, std::vector{good[0]}).p_rig.x()));
  EXPECT_EQ(statusId(TriangulationStatus::kAtInfinity), "at_infinity");
}

// Wrong pairs must not crash or run for ever, and pixels at random mostly belong to no point.
TEST(Triangulation, EndsForPixelsAtRandom) {
  const AnyRig rig = mixedRig();
  Random random(23);
  int num_ok = 0;
  constexpr int kNumPairs = 5000;
  for (int i = 0; i < kNumPairs; ++i) {
    std::vector<RigPixel> pixels;
    for (int k = 0; k < 2 + i % 3; ++k) {
      pixels.push_back({.camera = static_cast<std::size_t>(random.index(rig.size())),
                        .pixel = {random.uniform(0, 640), random.uniform(0, 480)}});
    }
    const Triangulation answer = triangulate(rig, pixels);
    EXPECT_EQ(answer.ok(), answer.p_rig.allFinite());
    EXPECT_EQ(answer.ok(), std::isfinite(answer.error_px));
    num_ok += answer.ok() ? 1 : 0;
  }
  EXPECT_GT(num_ok, kNumPairs / 10);
}

}  // namespace
}  // namespace alidade
