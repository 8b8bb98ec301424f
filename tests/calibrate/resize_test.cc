// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/core/random.h"
#include "alidade/detect/detect_images.h"
#include "alidade/simulate/random_views.h"
#include "alidade/simulate/render.h"

namespace alidade {
namespace {

constexpr ImageSize kFull{.width = 1280, .height = 960};
constexpr ImageSize kHalf{.width = 640, .height = 480};
constexpr Checkerboard kBoard{.columns = 9, .rows = 6, .square_m = 0.025};
constexpr int kNumViews = 16;
constexpr double kMaxSigmas = 3;

// Renders the views, looks for the board in them, and calibrates from what was found.
Calibration calibrateRendered(const AnyCamera& camera, ImageSize size, const std::vector<SE3>& poses,
                              std::uint64_t seed) {
  const Renderer renderer(camera, size);
  std::vector<View> views;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const GrayImage image = renderer.render(kBoard, poses[i], {.seed = streamSeed(seed, i), .samples = 377});
    const Detection detection = findBoard(image, kBoard);
    EXPECT_TRUE(detection.found()) << "view " << i << ": " << detection.detail;
    views.push_back({.image = "view_" + std::to_string(i), .size = size, .corners = detection.corners});
  }
  return calibrate(kBoard, std::move(views), {.model = "radtan"});
}

// The same scene by one camera at full and at half size, as two sets of images with nothing else in common:
// what the one calibration says of the other's images must be what those say themselves.
TEST(Resize, FullCalibrationResizedAgreesWithThatOfHalfSizeImages) {
  const AnyCamera truth =
      AnyCamera::make("radtan", std::vector<double>{1003, 1001, 645, 475, -0.28, 0.08, 8e-4, -4e-4, -0.01});
  const EditedCamera half_truth = resizeCamera(truth, kFull, kHalf);
  Random random(21);
  const std::vector<SE3> poses = randomViews(truth, kFull, kBoard, kNumViews, random);

  const Calibration full = calibrateRendered(truth, kFull, poses, 1);
  const Calibration half = calibrateRendered(half_truth.camera, kHalf, poses, 2);
  for (const Calibration* result : {&full, &half}) {
    ASSERT_TRUE(result->isUsable());
    ASSERT_TRUE(result->uncertainty.covariance);
    EXPECT_EQ(numCorners(result->fit), kNumViews * 54);
  }
  const EditedCamera resized = resizeCamera(full.camera(), kFull, kHalf);
  const Eigen::MatrixXd covariance =
      resized.J_new_old.view() * full.uncertainty.covariance->view() * resized.J_new_old.view().transpose() +
      half.uncertainty.covariance->view();
  int num_checked = 0;
  for (int i = 0; i < static_cast<int>(covariance.rows()); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double difference = resized.camera.parameters()[k] - onlyCamera(half.fit).params[k];
    const double sigma = std::sqrt(covariance(i, i));
    const std::string name(truth.parameterNames()[k]);
    std::printf("%-3s %12.6f from full size, %12.6f from half size: %+.2f sigma\n", name.c_str(),
                resized.camera.parameters()[k], onlyCamera(half.fit).params[k], difference / sigma);
    EXPECT_LE(std::abs(difference), kMaxSigmas * sigma) << name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 9);
  // Sigmas that are small enough to notice a forgotten half pixel, or a focal length that was not halved.
  EXPECT_LT(kMaxSigmas * std::sqrt(covariance(2, 2)), 0.25);
  EXPECT_LT(kMaxSigmas * std::sqrt(covariance(3, 3)), 0.25);
}

}  // namespace
}  // namespace alidade
