// SPDX-License-Identifier: MIT
#include "alidade/validate/held_out/held_scores.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>

#include "alidade/adjust/board/view_pose.h"
#include "support/fit_set.h"
#include "support/lens_draw.h"
#include "support/user_views.h"

namespace alidade {
namespace {

using testing::HasSubstr;

constexpr double kNoisePx = 0.1;

DrawnCamera distortedCamera() {
  return {
      AnyCamera::make("radtan", std::vector<double>{535, 534, 322.5, 238.1, -0.28, 0.08, 8e-4, -4e-4, -0.01}),
      {.width = 640, .height = 480},
      0.75};
}

// Each view is sheared and stretched on its own by so many pixels over a side, as a moving board would be.
void moveViews(std::vector<View>& views, double px, Random& random) {
  for (View& view : views) {
    Eigen::Matrix2d move;
    for (double& x : move.reshaped()) x = px / view.size.width * random.normal();
    const Eigen::Vector2d middle(0.5 * view.size.width, 0.5 * view.size.height);
    for (Corner& corner : view.corners) corner.pixel += move * (corner.pixel - middle);
  }
}

PosedViews fitHeld(const AnyCamera& camera, const UserSet& set) {
  PosedViews posed{.fit = fitAt(set, camera), .weights = {}};
  for (const FitView& view : posed.fit.views) {
    const auto pose = refitPose(camera.modelId(), camera.parameters(), view.corners, {.threshold_px = 2},
                                set.poses[view.source]);
    EXPECT_TRUE(pose);
    posed.fit.placements[view.placement].rig_from_body = *pose;
  }
  return posed;
}

HeldScores scoresOf(const AnyCamera& camera, const UserSet& set,
                    const std::optional<Eigen::MatrixXd>& covariance = {}) {
  const auto scores =
      HeldScores::make(camera, fitHeld(camera, set), nullptr, kNoisePx * kNoisePx, covariance);
  EXPECT_TRUE(scores);
  return *scores;
}

// How often the right camera is accused, by any of the single changes that count and by all parameters
// together: with noise alone, and with views that are moved by ten and thirty times as much. One in twenty is
// what users can put up with; ten views moved the most come to 3 %.
TEST(HeldScores, HardlyEverAccuseTheRightCamera) {
  const DrawnCamera drawn = distortedCamera();
  constexpr int kSets = 300;
  int num_rows = 0;
  for (const int num_views : {3, 4, 6, 10, 20}) {
    for (const double moved_px : {0.0, 1.0, 3.0}) {
      int num_by_change = 0;
      int num_overall = 0;
      for (std::uint64_t seed = 0; seed < kSets; ++seed) {
        Random random(seed);
        UserSet set = drawUserViews(drawn, num_views, kNoisePx, random);
        moveViews(set.views, moved_px, random);
        const HeldScores scores = scoresOf(drawn.camera, set);
        bool is_accused = false;
        for (const CameraChangeKind change : kIntrinsicsChanges) {
          const auto estimate = scores.along(directionOf(change, drawn.camera));
          ASSERT_TRUE(estimate);
          is_accused = is_accused || (change != CameraChangeKind::kPixelOrigin && estimate->isSignificant());
        }
        num_by_change += is_accused ? 1 : 0;
        num_overall += scores.overall().isSignificant() ? 1 : 0;
      }
      const std::string row =
          std::to_string(num_views) + " views moved by " + std::to_string(moved_px) + " px";
      EXPECT_LE(num_by_change, 0.04 * kSets) << row;
      EXPECT_LE(num_overall, 0.02 * kSets) << row;
      ++num_rows;
    }
  }
  EXPECT_EQ(num_rows, 15);
}

TEST(HeldScores, TellWhichChangeACameraNeeds) {
  const DrawnCamera drawn = distortedCamera();
  struct Case {
    CameraChangeKind change;
    double amount;
    const char* complaint;
  };
  const std::vector<Case> cases = {{CameraChangeKind::kFocalLength, 0.01, "its focal length is 1 +-"},
                                   {CameraChangeKind::kCenterX, -5, "its cx is "},
                                   {CameraChangeKind::kCenterY, 5, "its cy is "},
                                   {CameraChangeKind::kDistortion, -0.02, "its distortion is "}};
  for (const Case& c : cases) {
    Random random(3);
    const UserSet set = drawUserViews(drawn, 40, kNoisePx, random);
    const AnyCamera tested = *changed(drawn.camera, c.change, c.amount);
    const HeldScores scores = scoresOf(tested, set);
    const auto estimate = scores.along(directionOf(c.change, tested));
    ASSERT_TRUE(estimate);
    const double true_amount =
        c.change == CameraChangeKind::kFocalLength || c.change == CameraChangeKind::kDistortion
            ? -c.amount / (1 + c.amount)
            : -c.amount;
    EXPECT_NEAR(estimate->amount, true_amount, 3 * estimate->std + 0.02 * std::abs(true_amount));
    EXPECT_TRUE(estimate->isSignificant());
    EXPECT_TRUE(scores.overall().isSignificant());
    EXPECT_GT(scores.overall().sure_share, 0.3);
    EXPECT_LT(scores.overall().sure_share, 1);
    for (const CameraChangeKind other : kIntrinsicsChanges) {
      if (other == c.change) continue;
      EXPECT_LT(scores.along(directionOf(other, tested))->sigmas, estimate->sigmas)
          << static_cast<int>(other);
    }
    const std::string complaint = complaintOf(c.change, estimate->amount, estimate->effectiveStd());
    EXPECT_THAT(complaint, HasSubstr(c.complaint));
    EXPECT_THAT(complaint, HasSubstr(c.amount > 0                                ? "too l"
                                     : c.change == CameraChangeKind::kDistortion ? "too weak"
                                                                                 : "too small"));
  }
}

// Half a pixel is mostly a turn of the camera; it takes a hundred views to see the rest.
TEST(HeldScores, SeeTheOtherPixelOrigin) {
  const DrawnCamera drawn = distortedCamera();
  Random random(4);
  const UserSet set = drawUserViews(drawn, 120, kNoisePx, random);
  const AnyCamera tested = *changed(drawn.camera, CameraChangeKind::kPixelOrigin, 0.5);
  const auto estimate = scoresOf(tested, set).along(directionOf(CameraChangeKind::kPixelOrigin, tested));
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->amount, -0.5, 3 * estimate->std);
  EXPECT_TRUE(estimate->isSignificant()) << estimate->sigmas;
}

TEST(HeldScores, AllowForTheCamerasOwnUncertainty) {
  const DrawnCamera drawn = distortedCamera();
  Random random(5);
  const UserSet set = drawUserViews(drawn, 12, kNoisePx, random);
  const AnyCamera tested = *changed(drawn.camera, CameraChangeKind::kCenterX, 5);
  const Eigen::VectorXd direction = directionOf(CameraChangeKind::kCenterX, tested);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(9, 9);
  covariance(2, 2) = 9;  // cx is known to 3 px
  const auto exact = scoresOf(tested, set).along(direction);
  const auto uncertain = scoresOf(tested, set, covariance).along(direction);
  ASSERT_TRUE(exact && uncertain);
  EXPECT_EQ(exact->amount, uncertain->amount);
  EXPECT_NEAR(std::hypot(exact->std, 3), uncertain->std, 1e-9);
  EXPECT_GT(uncertain->freedom, exact->freedom);
  EXPECT_TRUE(exact->isSignificant());
  EXPECT_FALSE(uncertain->isSignificant());
  EXPECT_LT(scoresOf(tested, set, covariance).overall().sigmas, scoresOf(tested, set).overall().sigmas);
}

TEST(HeldScores, TakeAMatrixThatIsNoCovarianceForNone) {
  const DrawnCamera drawn = distortedCamera();
  Random random(7);
  const UserSet set = drawUserViews(drawn, 12, kNoisePx, random);
  Eigen::MatrixXd indefinite = Eigen::MatrixXd::Identity(9, 9);
  indefinite(0, 1) = indefinite(1, 0) = 2;
  EXPECT_EQ(scoresOf(drawn.camera, set, indefinite).overall().sigmas,
            scoresOf(drawn.camera, set).overall().sigmas);
}

TEST(HeldScores, CountWeightedViewsForLess) {
  const DrawnCamera drawn = distortedCamera();
  Random random(8);
  UserSet set = drawUserViews(drawn, 20, kNoisePx, random);
  std::vector<View> first(set.views.begin(), set.views.begin() + 5);
  moveViews(first, 10, random);
  std::copy(first.begin(), first.end(), set.views.begin());
  PosedViews posed = fitHeld(drawn.camera, set);
  const Eigen::VectorXd direction = directionOf(CameraChangeKind::kFocalLength, drawn.camera);
  const auto alike = HeldScores::make(drawn.camera, posed, nullptr, 0.01, {})->along(direction);
  posed.weights.assign(20, 1.0);
  std::fill_n(posed.weights.begin(), 5, 1e-3);
  const auto weighted = HeldScores::make(drawn.camera, posed, nullptr, 0.01, {})->along(direction);
  ASSERT_TRUE(alike && weighted);
  EXPECT_LT(weighted->std, 0.5 * alike->std);
}

TEST(HeldScores, NeedThreeViewsAndNoise) {
  const DrawnCamera drawn = distortedCamera();
  Random random(6);
  const UserSet set = drawUserViews(drawn, 2, kNoisePx, random);
  EXPECT_FALSE(HeldScores::make(drawn.camera, fitHeld(drawn.camera, set), nullptr, 0.01, {}));
  const UserSet enough = drawUserViews(drawn, 3, kNoisePx, random);
  EXPECT_TRUE(HeldScores::make(drawn.camera, fitHeld(drawn.camera, enough), nullptr, 0.01, {}));
  EXPECT_FALSE(HeldScores::make(drawn.camera, fitHeld(drawn.camera, enough), nullptr, 0, {}));
}

TEST(CameraChangeKind, HasNoDistortionWithoutOne) {
  const AnyCamera pinhole = AnyCamera::make("pinhole", std::vector<double>{500, 510, 320, 240});
  EXPECT_EQ(directionOf(CameraChangeKind::kDistortion, pinhole).size(), 0);
  EXPECT_EQ(directionOf(CameraChangeKind::kFocalLength, pinhole), Eigen::Vector4d(500, 510, 0, 0));
  EXPECT_EQ(changed(pinhole, CameraChangeKind::kPixelOrigin, 0.5)->parameters()[3], 240.5);
}

TEST(CameraChangeKind, MakesNoCameraThatCannotBe) {
  const AnyCamera pinhole = AnyCamera::make("pinhole", std::vector<double>{500, 510, 320, 240});
  EXPECT_FALSE(changed(pinhole, CameraChangeKind::kFocalLength, -1.5));
  EXPECT_TRUE(changed(pinhole, CameraChangeKind::kFocalLength, 2));
  // Where the unified models' shape has its neutral value is not the same for all; they have no strength.
  const AnyCamera ucm = AnyCamera::make("ucm", std::vector<double>{300, 300, 320, 240, 0.6});
  EXPECT_EQ(directionOf(CameraChangeKind::kDistortion, ucm).size(), 0);
}

}  // namespace
}  // namespace alidade
