// SPDX-License-Identifier: MIT
#include "alidade/compare/projection_difference.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "alidade/camera/camera_edit.h"
#include "alidade/camera/camera_variant.h"
#include "alidade/camera/model_fit.h"
#include "alidade/compare/ray_alignment.h"
#include "alidade/core/error.h"
#include "support/image_sizes.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kSamePx = 1e-9;

AnyCamera radtan(double fx = 533, double cx = 342, double k1 = -0.28) {
  return AnyCamera::make("radtan", std::vector<double>{fx, 532, cx, 234, k1, 0.06, 1e-3, -5e-4, 0.01});
}

std::vector<AnyCamera> fixtureCameras() {
  std::vector<AnyCamera> cameras;
  AllModels::forEach([&]<class M>() {
    for (const auto& params : ModelFixture<M>::paramSets()) cameras.emplace_back(Camera<M>(params));
  });
  return cameras;
}

double angleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return SO3::fromQuaternion(Eigen::Quaterniond(Eigen::Matrix3d(a.transpose() * b))).log().norm();
}

TEST(ProjectionDifference, OfACameraWithItselfIsZeroWhateverTheImagesTurn) {
  int num_compared = 0;
  int num_refused = 0;
  for (const AnyCamera& camera : fixtureCameras()) {
    for (int turns = 0; turns < 4; ++turns) {
      std::optional<EditedCamera> edited;
      try {
        edited.emplace(rotateCamera(camera, kTestImage, turns));
      } catch (const Error& e) {  // of skewed pixels, by 90 degrees
        EXPECT_EQ(turns % 2, 1);
        EXPECT_THAT(e.what(), HasSubstr("after a turn by 90 degrees"));
        ++num_refused;
        continue;
      }
      const EditedCamera& turned = *edited;
      const ProjectionDifference found = projectionDifference(
          {&camera, kTestImage}, {&turned.camera, turned.size}, {.quarter_turns = turns});
      if (found.num_compared < 6) continue;  // a lens that folds near its axis
      EXPECT_TRUE(found.is_converged) << camera.modelId() << turns;
      EXPECT_LE(found.max_px, kSamePx) << camera.modelId() << ", " << turns;
      EXPECT_LE(angleBetween(found.b_from_a.rotation.matrix(), turned.new_from_old), 1e-10)
          << camera.modelId() << ", " << turns;
      EXPECT_EQ(found.b_from_a.translation, Eigen::Vector3d::Zero());
      EXPECT_EQ(found.match.quarter_turns, turns);
      ++num_compared;
    }
  }
  EXPECT_GE(num_compared, 4 * 50);
  EXPECT_EQ(num_refused, 14);
}

TEST(ProjectionDifference, FindsTheQuarterTurnThatTheSizesAskFor) {
  const AnyCamera camera = radtan();
  for (const int turns : {1, 3}) {
    const EditedCamera turned = rotateCamera(camera, kVga, turns);
    const auto found = projectionDifference({&camera, kVga}, {&turned.camera, turned.size});
    EXPECT_EQ(found.match.quarter_turns, turns);
    EXPECT_LE(found.max_px, kSamePx);
    EXPECT_LE(angleBetween(found.b_from_a.rotation.matrix(), turned.new_from_old), 1e-10);
  }
  // Upside down the sizes are the same: two cameras, as long as nobody says otherwise.
  const EditedCamera upside_down = rotateCamera(camera, kVga, 2);
  EXPECT_GE(projectionDifference({&camera, kVga}, {&upside_down.camera, kVga}).max_px, 1);
}

// No model's parameters hold a frame turned by an angle of its own, but rays can be.
TEST(RayAlignment, ReturnsAnyRotation) {
  Random random(5);
  int num_checked = 0;
  for (const AnyCamera& camera :
       {radtan(),
        AnyCamera::make("kannala_brandt", std::vector<double>{320, 321, 318, 242, 0.01, -0.005, 0.001, 0})}) {
    std::vector<Eigen::Vector2d> pixels;
    for (int y = 10; y < kVga.height; y += 50) {
      for (int x = 10; x < kVga.width; x += 50) pixels.emplace_back(x, y);
    }
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d w(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3));
      const SO3 turn = SO3::exp(w);
      std::vector<PixelPair> pairs;
      for (const Eigen::Vector2d& pixel : pixels) {
        const auto ray = camera.unproject(pixel);
        ASSERT_TRUE(ray);
        pairs.push_back({.pixel_a = pixel, .pixel_b = pixel, .ray_a = *ray, .ray_b = turn * *ray});
      }
      const SE3 found = kabschRotation(pairs);
      EXPECT_LE((found.rotation.inverse() * turn).log().norm(), 1e-12);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 40);
}

TEST(ProjectionDifference, IsAKnownShiftWhereNothingIsTakenOut) {
  const AnyCamera a = radtan();
  const AnyCamera b = radtan(533, 342.5);
  const auto found = projectionDifference({&a, kVga}, {&b, kVga}, {.freed = std::nullopt});
  EXPECT_EQ(found.num_compared, 40 * 30);
  int num_checked = 0;
  for (const Eigen::Vector2d& difference : found.difference_px) {
    EXPECT_LE((difference - Eigen::Vector2d(0.5, 0)).norm(), 1e-6);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 40 * 30);
  for (const double figure : {found.mean_px, found.rms_px, found.p95_px, found.max_px})
    EXPECT_NEAR(figure, 0.5, 1e-6);
  EXPECT_EQ(found.b_from_a.rotation.log(), Eigen::Vector3d::Zero());
}

// A tele lens sees a turn as a shift, so the shift is in the rotation.
TEST(ProjectionDifference, TakesAShiftForATurn) {
  const AnyCamera a = AnyCamera::make("pinhole", std::vector<double>{20000, 20000, 320, 240});
  const AnyCamera b = AnyCamera::make("pinhole", std::vector<double>{20000, 20000, 320.5, 240});
  const auto found = projectionDifference({&a, kVga}, {&b, kVga});
  EXPECT_LE(found.max_px, 1e-3);
  EXPECT_NEAR(found.b_from_a.rotation.log().y(), -0.5 / 20000, 1e-8);
}

struct PairCase {
  const char* what;
  AnyCamera a;
  ImageSize a_size;
  AnyCamera b;
  ImageSize b_size;
};

std::vector<PairCase> pairsOfCameras() {
  const AnyCamera a = radtan();
  const AnyCamera other = radtan(538, 330, -0.26);
  const ModelFit fit = fitModel(a, kVga, "kannala_brandt");
  const EditedCamera half = resizeCamera(other, kVga, {.width = 320, .height = 240});
  const EditedCamera odd = resizeCamera(other, kVga, {.width = 427, .height = 320});
  const EditedCamera turned = rotateCamera(half.camera, half.size, 1);
  return {{"one size", a, kVga, other, kVga},
          {"another model", a, kVga, fit.camera, kVga},
          {"half the size", a, kVga, half.camera, half.size},
          {"two thirds, rounded", a, kVga, odd.camera, odd.size},
          {"turned and half the size", a, kVga, turned.camera, turned.size}};
}

TEST(ProjectionDifference, IsSymmetric) {
  int num_checked = 0;
  for (const PairCase& c : pairsOfCameras()) {
    for (const std::optional<Freed> freed :
         {std::optional<Freed>(), std::optional(Freed::kRotation), std::optional(Freed::kPose)}) {
      const DifferenceOptions options{.freed = freed, .distance_m = 2};
      const auto there = projectionDifference({&c.a, c.a_size}, {&c.b, c.b_size}, options);
      const auto back = projectionDifference({&c.b, c.b_size}, {&c.a, c.a_size}, options);
      EXPECT_TRUE(there.is_converged && back.is_converged) << c.what;
      EXPECT_EQ(there.num_compared, back.num_compared) << c.what;
      EXPECT_NEAR(there.mean_px, back.mean_px, 1e-8) << c.what;
      EXPECT_NEAR(there.rms_px, back.rms_px, 1e-8) << c.what;
      EXPECT_NEAR(there.p95_px, back.p95_px, 1e-8) << c.what;
      EXPECT_NEAR(there.max_px, back.max_px, 1e-8) << c.what;
      EXPECT_LE((there.match.inB(there.worst_pixel) - back.worst_pixel).norm(), 1e-9) << c.what;
      EXPECT_LE((there.b_from_a * back.b_from_a).log().norm(), 1e-7) << c.what;
      EXPECT_EQ(there.match.unit_size, back.match.unit_size);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 15);
}

TEST(ProjectionDifference, OfAResizedCameraIsZero) {
  const AnyCamera camera = radtan();
  int num_checked = 0;
  for (const ImageSize size : {ImageSize{320, 240}, ImageSize{1280, 960}, ImageSize{427, 320}}) {
    const EditedCamera resized = resizeCamera(camera, kVga, size);
    const auto found = projectionDifference({&camera, kVga}, {&resized.camera, size});
    EXPECT_LE(found.max_px, kSamePx);
    EXPECT_GE(found.num_compared, 1000);
    EXPECT_EQ(found.match.unit_size, size.width > kVga.width ? size : kVga);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

// Nothing near the answer leaves less.
TEST(ProjectionDifference, TakesOutTheBestRotationAndPose) {
  const AnyCamera a = radtan();
  const AnyCamera b = radtan(538, 330, -0.26);
  int num_checked = 0;
  for (const Freed freed : {Freed::kRotation, Freed::kPose}) {
    const DifferenceOptions options{.freed = freed};
    const auto found = projectionDifference({&a, kVga}, {&b, kVga}, options);
    const CameraPair cameras{.a = &a, .b = &b, .match = found.match};
    const auto costAt = [&](const SE3& b_from_a) {
      double cost = 0;
      for (const Eigen::Vector2d& pixel : found.pixels) {
        const PixelPair pair{pixel, pixel, a.unproject(pixel).value(), b.unproject(pixel).value()};
        const auto differences = differencesAt(cameras, pair, b_from_a);
        cost += differences->a_to_b.squaredNorm() + differences->b_to_a.squaredNorm();
      }
      return cost;
    };
    const double best = costAt(found.b_from_a);
    for (int i = freed == Freed::kRotation ? 3 : 0; i < 6; ++i) {
      for (const double step : {-1e-4, 1e-4}) {
        SE3::Vec6 xi = SE3::Vec6::Zero();
        xi(i) = step;
        EXPECT_GT(costAt(found.b_from_a * SE3::exp(xi)), best) << i;
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 6 + 12);
}

TEST(ProjectionDifference, DoesNotDependOnTheDistanceButForTheTranslation) {
  const AnyCamera a = radtan();
  const AnyCamera b = radtan(538, 330, -0.26);
  const auto near = projectionDifference({&a, kVga}, {&b, kVga}, {.freed = Freed::kPose, .distance_m = 0.5});
  const auto far = projectionDifference({&a, kVga}, {&b, kVga}, {.freed = Freed::kPose, .distance_m = 50});
  EXPECT_EQ(near.rms_px, far.rms_px);
  EXPECT_LE((100 * near.b_from_a.translation - far.b_from_a.translation).norm(),
            1e-12 * far.b_from_a.translation.norm());
  EXPECT_LT(near.rms_px, projectionDifference({&a, kVga}, {&b, kVga}).rms_px);
}

TEST(ProjectionDifference, SaysWhatOneCameraDoesNotSee) {
  const AnyCamera wide =
      AnyCamera::make("kannala_brandt", std::vector<double>{200, 200, 319.5, 239.5, 0.01, -0.005, 0.001, 0});
  const AnyCamera folded =
      AnyCamera::make("radtan", std::vector<double>{400, 400, 319.5, 239.5, -0.5, 0, 0, 0, 0});
  const auto found = projectionDifference({&wide, kVga}, {&folded, kVga});
  EXPECT_TRUE(found.is_converged);
  EXPECT_GT(found.num_compared, 100);
  EXPECT_GT(found.num_seen_by_one, 100);
  int num_nan = 0;
  for (const Eigen::Vector2d& difference : found.difference_px) num_nan += difference.allFinite() ? 0 : 1;
  EXPECT_EQ(num_nan, found.num_seen_by_one + found.num_seen_by_neither);
  EXPECT_EQ(num_nan + found.num_compared, 40 * 30);
}

TEST(ProjectionDifference, RefusesWhatCannotBeCompared) {
  const AnyCamera camera = radtan();
  const ComparedCamera a{&camera, kVga};
  const ComparedCamera wide{&camera, {.width = 1280, .height = 720}};
  EXPECT_THAT([&] { (void)projectionDifference(a, wide); },
              ThrowsMessage<Error>(AllOf(HasSubstr("640x480 and 1280x720"), HasSubstr("convert --crop"))));
  EXPECT_THAT([&] { (void)projectionDifference(a, a, {.quarter_turns = 1}); },
              ThrowsMessage<Error>(HasSubstr("a rotation by 90 degrees")));
  EXPECT_THAT([&] { (void)projectionDifference(a, a, {.freed = Freed::kPose, .distance_m = 0}); },
              ThrowsMessage<Error>(HasSubstr("a distance of 0 m")));
  EXPECT_THAT([&] { (void)projectionDifference(a, a, {.columns = -1}); },
              ThrowsMessage<Error>(HasSubstr("a grid of -1x0")));
}

}  // namespace
}  // namespace alidade
