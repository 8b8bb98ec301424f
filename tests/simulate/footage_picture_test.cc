// SPDX-License-Identifier: MIT
// Rendered pictures against the exact tracks: optical flow from where a point is must end where it is next.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "simulate/footage_support.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

cv::Mat matOf(const GrayImage& image) {
  return cv::Mat(image.size.height, image.size.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data()))
      .clone();
}

constexpr int kHalfWindow = 6;

// All around a pixel lies on the point's own face, so that what is tracked is one surface.
bool isOnOneFace(const FootageSimulator& simulator, const ScenePoint& point, int frame,
                 const Vector2d& pixel) {
  constexpr int kMargin = kHalfWindow + 2;
  for (int dy = -kMargin; dy <= kMargin; dy += kMargin) {
    for (int dx = -kMargin; dx <= kMargin; dx += kMargin) {
      const Vector2d place = pixel + Vector2d(dx, dy);
      if (place.minCoeff() < kMargin || place.x() > kFootageSize.width - kMargin ||
          place.y() > kFootageSize.height - kMargin)
        return false;
      const auto there = simulator.pointAt(frame, place);
      if (!there || there->body != point.body || there->face != point.face) return false;
    }
  }
  return true;
}

struct FlowErrors {
  int count = 0;
  int num_beyond_right_angle = 0;  // of points whose ray goes backwards
  double mean_px = 0;
  double mean_flow_px = 0;
};

FlowErrors flowErrors(const FootageScene& scene, int frame) {
  const FootageSimulator simulator(scene);
  std::vector<cv::Point2f> from;
  std::vector<cv::Point2f> truth;
  std::vector<bool> is_behind;
  for (const TrueTrack& track : simulator.trackPoints({.columns = 32, .rows = 24})) {
    const int at = frame - track.first_frame;
    if (at < 0 || at + 1 >= static_cast<int>(track.pixels.size())) continue;
    const Vector2d& p = track.pixels[static_cast<std::size_t>(at)];
    const Vector2d& q = track.pixels[static_cast<std::size_t>(at) + 1];
    if (!isOnOneFace(simulator, track.point, frame, p) || !isOnOneFace(simulator, track.point, frame + 1, q))
      continue;
    from.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    truth.emplace_back(static_cast<float>(q.x()), static_cast<float>(q.y()));
    is_behind.push_back(scene.camera.unproject(p)->z() < 0);
  }
  // Started at the truth: what is tested is the pictures, not how far the tracker reaches.
  std::vector<cv::Point2f> found = truth;
  std::vector<std::uint8_t> is_found;
  std::vector<float> errors;
  cv::calcOpticalFlowPyrLK(matOf(simulator.renderFrame(frame)), matOf(simulator.renderFrame(frame + 1)), from,
                           found, is_found, errors, {2 * kHalfWindow + 1, 2 * kHalfWindow + 1}, 0,
                           {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-3},
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  FlowErrors result;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (is_found[i] == 0) continue;
    ++result.count;
    if (is_behind[i]) ++result.num_beyond_right_angle;
    result.mean_px += std::hypot(found[i].x - truth[i].x, found[i].y - truth[i].y);
    result.mean_flow_px += std::hypot(from[i].x - truth[i].x, from[i].y - truth[i].y);
  }
  result.mean_px /= result.count;
  result.mean_flow_px /= result.count;
  return result;
}

TEST(FootagePicture, AgreesWithTracksOfAPerspectiveLens) {
  for (const FootageSurroundings surroundings :
       {FootageSurroundings::kRoom, FootageSurroundings::kPlane, FootageSurroundings::kFar}) {
    FootageScene scene = footageScene(footageRadtan());
    scene.surroundings = surroundings;
    const FlowErrors errors = flowErrors(scene, 7);
    EXPECT_GT(errors.count, 200) << static_cast<int>(surroundings);
    EXPECT_LT(errors.mean_px, 0.1) << static_cast<int>(surroundings);
    EXPECT_GT(errors.mean_flow_px, 2) << static_cast<int>(surroundings);
  }
}

TEST(FootagePicture, AgreesWithTracksOfAFisheyeBeyondRightAngles) {
  FootageScene scene = footageScene(footageFisheye());
  scene.flow_px = 3;
  const FlowErrors room = flowErrors(scene, 7);
  EXPECT_GT(room.count, 100);
  EXPECT_LT(room.mean_px, 0.1);
  EXPECT_GT(room.mean_flow_px, 1.5);
  scene.surroundings = FootageSurroundings::kFar;
  const FlowErrors far = flowErrors(scene, 7);
  EXPECT_GT(far.count, 200);
  EXPECT_GT(far.num_beyond_right_angle, 5);
  EXPECT_LT(far.mean_px, 0.1);
}

TEST(FootagePicture, AgreesWithTracksWhereRowsAreTakenOneAfterAnother) {
  FootageScene scene = footageScene(footageRadtan());
  scene.effects.rolling_shutter = 0.9;
  const FlowErrors rolling = flowErrors(scene, 7);
  EXPECT_GT(rolling.count, 200);
  EXPECT_LT(rolling.mean_px, 0.1);
  scene.effects.stabilisation_frames = 6;
  scene.effects.shake_px = 3;
  scene.effects.zoom = 1.2;
  scene.effects.moving_objects = 6;
  const FlowErrors everything = flowErrors(scene, 7);
  EXPECT_GT(everything.count, 150);
  EXPECT_LT(everything.mean_px, 0.1);
}

// A shift of all pictures would not show in the flow between them, but does against a picture with twice as
// many pixels: half of it.
TEST(FootagePicture, HasPixelCentresWhereTheConventionsSay) {
  FootageScene scene = footageScene(footagePinhole());
  scene.path = FootagePath::kStatic;
  scene.effects.read_noise = 0;
  const GrayImage small = FootageSimulator(scene).renderFrame(0);
  scene.camera = AnyCamera::make("pinhole", std::vector<double>{500, 504, 2 * 158.5 - 0.5, 2 * 121.5 - 0.5});
  scene.image_size = {640, 480};
  scene.effects.blur_px *= 2;
  const GrayImage large = FootageSimulator(scene).renderFrame(0);
  const auto mean = [&](int x, int y) {
    return 0.25 * (large.at(2 * x, 2 * y) + large.at(2 * x + 1, 2 * y) + large.at(2 * x, 2 * y + 1) +
                   large.at(2 * x + 1, 2 * y + 1));
  };
  // The shift that fits best, linearised.
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Vector2d right = Vector2d::Zero();
  int count = 0;
  for (int y = 1; y < 239; ++y) {
    for (int x = 1; x < 319; ++x) {
      const Vector2d gradient(0.5 * (mean(x + 1, y) - mean(x - 1, y)),
                              0.5 * (mean(x, y + 1) - mean(x, y - 1)));
      const double difference = small.at(x, y) - mean(x, y);
      normal += gradient * gradient.transpose();
      right += difference * gradient;
      ++count;
    }
  }
  EXPECT_EQ(count, 318 * 238);
  const Vector2d shift = normal.inverse() * right;
  EXPECT_LT(shift.cwiseAbs().maxCoeff(), 0.01) << shift.transpose();
}

// Whatever is seen, in each part of the picture.
TEST(FootagePicture, GivesDetectorsCornersEverywhere) {
  int num_checked = 0;
  for (const AnyCamera& camera : {footageRadtan(), footageFisheye()}) {
    for (const FootageSurroundings surroundings : {FootageSurroundings::kRoom, FootageSurroundings::kFar}) {
      for (const int moving_objects : {0, 40}) {
        FootageScene scene = footageScene(camera);
        scene.surroundings = surroundings;
        scene.effects.moving_objects = moving_objects;
        scene.effects.moving_share = moving_objects > 0 ? 0.7 : 0;
        std::vector<cv::Point2f> corners;
        constexpr double kQuality = 0.02;
        constexpr double kDistancePx = 4;
        cv::goodFeaturesToTrack(matOf(FootageSimulator(scene).renderFrame(5)), corners, 0, kQuality,
                                kDistancePx);
        EXPECT_GT(corners.size(), 500U);
        constexpr int kColumns = 4;
        constexpr int kRows = 3;
        std::vector<int> num_in_cell(kColumns * kRows);
        for (const cv::Point2f& corner : corners) {
          const int column = static_cast<int>(corner.x * kColumns) / kFootageSize.width;
          const int row = static_cast<int>(corner.y * kRows) / kFootageSize.height;
          ++num_in_cell[static_cast<std::size_t>(row * kColumns + column)];
        }
        EXPECT_GE(*std::ranges::min_element(num_in_cell), 15);
        ++num_checked;
      }
    }
  }
  EXPECT_EQ(num_checked, 8);
}

TEST(FootagePicture, HasTheSameBytesForAnyNumberOfThreads) {
  FootageScene scene = footageScene(footageFisheye());
  scene.effects.rolling_shutter = 0.5;
  scene.effects.stabilisation_frames = 4;
  scene.effects.moving_objects = 4;
  const GrayImage one = FootageSimulator(scene).renderFrame(3);
  scene.num_jobs = 3;
  const FootageSimulator simulator(scene);
  EXPECT_EQ(one.pixels, simulator.renderFrame(3).pixels);
  EXPECT_EQ(one.pixels.size(), 320U * 240U);
  EXPECT_NE(one.pixels, simulator.renderFrame(4).pixels);
  scene.seed = 2;
  EXPECT_NE(one.pixels, FootageSimulator(scene).renderFrame(3).pixels);
}

TEST(FootagePicture, OfAStaticCameraDiffersByNoiseOnly) {
  FootageScene scene = footageScene(footagePinhole());
  scene.path = FootagePath::kStatic;
  scene.effects.read_noise = 4;
  const FootageSimulator noisy(scene);
  const GrayImage first = noisy.renderFrame(0);
  const GrayImage second = noisy.renderFrame(1);
  double sum2 = 0;
  for (std::size_t i = 0; i < first.pixels.size(); ++i) {
    const double d = static_cast<double>(first.pixels[i]) - second.pixels[i];
    sum2 += d * d;
  }
  // Two draws, each rounded; five standard errors are 1 %.
  const double expected = std::sqrt(2 * (16 + 1.0 / 12));
  EXPECT_NEAR(std::sqrt(sum2 / static_cast<double>(first.pixels.size())), expected, 0.015 * expected);
  scene.effects.read_noise = 0;
  const FootageSimulator clean(scene);
  EXPECT_EQ(clean.renderFrame(0).pixels, clean.renderFrame(1).pixels);
}

TEST(FootagePicture, IsDarkWhereThereIsNoRay) {
  // The domain of this lens ends inside the image.
  FootageScene scene = footageScene(AnyCamera::make("ucm", std::vector<double>{100, 100, 159.5, 119.5, 0.7}));
  scene.effects.read_noise = 0;
  ASSERT_FALSE(scene.camera.unproject({0, 0}).has_value());
  const GrayImage image = FootageSimulator(scene).renderFrame(0);
  EXPECT_EQ(image.at(0, 0), 0);
  EXPECT_GT(image.at(160, 120), 3);
}

}  // namespace
}  // namespace alidade
