// SPDX-License-Identifier: MIT
#include "alidade/simulate/random_views.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/simulate/observe.h"
#include "alidade/target/board_turns.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr Checkerboard kPlacedBoard = {.columns = 8, .rows = 6, .square_m = 0.025};

AnyCamera cameraOfWidth(double field_of_view_deg, const std::string& model) {
  const double f = 0.5 * kVga.width / std::tan(0.5 * field_of_view_deg / kDegPerRad);
  std::vector<double> params = {f, f, 319.5, 239.5};
  // Distortion that a lens of this width may have without a fold inside the image.
  if (model == "radtan") params.insert(params.end(), {-0.1, 0.02, 1e-3, -5e-4, 0});
  return AnyCamera::make(model, params);
}

// The corners of all squares, one square beyond the inner corners.
Checkerboard grown(const Checkerboard& board) {
  return {.columns = board.columns + 2, .rows = board.rows + 2, .square_m = board.square_m};
}
SE3 poseOfGrown(const SE3& camera_from_board, const Checkerboard& board) {
  return camera_from_board * SE3{{}, {-board.square_m, -board.square_m, 0}};
}

TEST(RandomViews, ShowTheWholeBoardWithinTheLimits) {
  constexpr int kCount = 60;
  int num_views = 0;
  for (const std::string model : {"pinhole", "radtan"}) {
    for (const double field_of_view_deg : {20.0, 45.0, 70.0, 90.0, 110.0}) {
      SCOPED_TRACE(model + " of " + std::to_string(field_of_view_deg) + " degrees");
      const AnyCamera camera = cameraOfWidth(field_of_view_deg, model);
      const RandomViewOptions options;
      Random random(11);
      const std::vector<SE3> poses = randomViews(camera, kVga, kPlacedBoard, kCount, random, options);
      ASSERT_EQ(poses.size(), static_cast<std::size_t>(kCount));
      double largest_tilt_deg = 0;
      for (const SE3& pose : poses) {
        ASSERT_TRUE(seesPrintedSide(pose));
        const View view = exactView(camera, kVga, grown(kPlacedBoard), poseOfGrown(pose, kPlacedBoard), "");
        ASSERT_EQ(view.corners.size(), 80U);
        Eigen::Vector2d low = view.corners[0].pixel;
        Eigen::Vector2d high = low;
        for (const Corner& corner : view.corners) {
          low = low.cwiseMin(corner.pixel);
          high = high.cwiseMax(corner.pixel);
        }
        ASSERT_GE(low.minCoeff(), options.margin_px - 0.5);
        ASSERT_LE(high.x(), kVga.width - 0.5 - options.margin_px);
        ASSERT_LE(high.y(), kVga.height - 0.5 - options.margin_px);
        const double fill = std::max((high.x() - low.x()) / kVga.width, (high.y() - low.y()) / kVga.height);
        // The fill is found by 20 bisections between two distances of which one is twice the other, at most.
        ASSERT_GE(fill, options.min_fill - 1e-4);
        ASSERT_LE(fill, options.max_fill);

        const Eigen::Vector3d middle = pose * Eigen::Vector3d(3.5 * 0.025, 2.5 * 0.025, 0);
        const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
        largest_tilt_deg =
            std::max(largest_tilt_deg, std::acos(normal.dot(middle.normalized())) * kDegPerRad);
        ++num_views;
      }
      EXPECT_LE(largest_tilt_deg, options.max_tilt_deg + 1e-6);
      EXPECT_GT(largest_tilt_deg, 0.8 * options.max_tilt_deg);
    }
  }
  EXPECT_EQ(num_views, 2 * 5 * kCount);
}

TEST(RandomViews, AreNearTheIdentityRotationWithoutTiltAndRoll) {
  Random random(3);
  const RandomViewOptions options{.max_tilt_deg = 0, .max_roll_deg = 0};
  for (const SE3& pose : randomViews(cameraOfWidth(20, "pinhole"), kVga, kPlacedBoard, 10, random, options)) {
    EXPECT_LT(pose.rotation.log().norm() * kDegPerRad, 15);  // half of the image's diagonal is 13 degrees
  }
}

TEST(RandomViews, FollowTheSeed) {
  const AnyCamera camera = cameraOfWidth(70, "radtan");
  Random a(7);
  Random b(7);
  Random c(8);
  const auto views_a = randomViews(camera, kVga, kPlacedBoard, 20, a);
  const auto views_b = randomViews(camera, kVga, kPlacedBoard, 20, b);
  const auto views_c = randomViews(camera, kVga, kPlacedBoard, 20, c);
  for (std::size_t i = 0; i < views_a.size(); ++i) {
    EXPECT_EQ(views_a[i].matrix(), views_b[i].matrix());
    EXPECT_NE(views_a[i].matrix(), views_c[i].matrix());
  }
}

TEST(RandomViews, ReduceAFillThatDoesNotFit) {
  // A board that fills the whole image cannot keep a margin.
  Random random(3);
  const RandomViewOptions options{.min_fill = 1, .max_fill = 1, .margin_px = 100, .max_attempts = 20};
  EXPECT_EQ(randomViews(cameraOfWidth(60, "pinhole"), kVga, kPlacedBoard, 5, random, options).size(), 5U);
}

TEST(RandomViews, SayWhenNothingFits) {
  Random random(3);
  const RandomViewOptions options{.margin_px = 240, .max_attempts = 5};
  try {
    (void)randomViews(cameraOfWidth(60, "pinhole"), kVga, kPlacedBoard, 5, random, options);
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("640x480"), testing::HasSubstr("next: ")));
  }
}

TEST(RandomViews, RefuseOptionsOutOfRange) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<RandomViewOptions> wrong = {
      {.max_tilt_deg = 90}, {.max_tilt_deg = kNan}, {.max_roll_deg = 181},
      {.min_fill = 0},      {.min_fill = 0.9},  // above max_fill
      {.max_fill = 1.1},    {.margin_px = -1},      {.max_attempts = 0}};
  Random random(3);
  for (const RandomViewOptions& options : wrong) {
    EXPECT_THROW((void)randomViews(cameraOfWidth(60, "pinhole"), kVga, kPlacedBoard, 1, random, options),
                 Error);
  }
}

}  // namespace
}  // namespace alidade
