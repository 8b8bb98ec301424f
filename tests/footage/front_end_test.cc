// SPDX-License-Identifier: MIT
#include "alidade/footage/follow/front_end.h"

#include <cmath>
#include <cstdio>
#include <map>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "alidade/core/median.h"
#include "alidade/simulate/footage_simulator.h"
#include "footage/points_scene.h"

namespace alidade {
namespace {

using testing::footageCameras;
using testing::kFootageSize;

// Errors of tracks against the exact pixels of the point that each track began at.
struct FollowErrors {
  std::vector<double> lengths;
  Eigen::Vector2d sum{0, 0};  // of those below a pixel
  int num_close = 0;
};

FollowErrors followErrors(FrontEndKind kind, int num_frames, int step) {
  FootageScene scene{.camera = footageCameras()[1],
                     .image_size = kFootageSize,
                     .num_frames = 40,
                     .flow_px = 6,
                     .num_jobs = 1};
  const FootageSimulator simulator(scene);
  const auto front_end = makeFrontEnd(kind);
  std::map<std::uint32_t, ScenePoint> starts;
  FollowErrors errors;
  for (int i = 0; i < num_frames; ++i) {
    for (const TrackPixel& at : front_end->follow(simulator.renderFrame(i * step))) {
      const auto known = starts.find(at.track);
      if (known == starts.end()) {
        const auto point = simulator.pointAt(i * step, at.pixel);
        if (point) starts.emplace(at.track, *point);
        continue;
      }
      const auto truth = simulator.pixelOf(known->second, i * step);
      if (!truth) continue;
      const Eigen::Vector2d error = at.pixel - *truth;
      errors.lengths.push_back(error.norm());
      if (error.norm() > 1) continue;
      errors.sum += error;
      ++errors.num_close;
    }
  }
  return errors;
}

TEST(FrontEnd, FlowFollowsPointsExactly) {
  const FollowErrors errors = followErrors(FrontEndKind::kFlow, 6, 1);
  ASSERT_GT(errors.lengths.size(), 1000U);
  EXPECT_GT(errors.num_close, 0.9 * static_cast<double>(errors.lengths.size()));
  std::printf("flow: median error %.3f px of %zu\n", medianOf(errors.lengths), errors.lengths.size());
  EXPECT_LT(medianOf(errors.lengths), 0.06);
  const Eigen::Vector2d bias = errors.sum / errors.num_close;
  EXPECT_LT(bias.cwiseAbs().maxCoeff(), 0.03);
}

TEST(FrontEnd, ErrorsOfFlowDoNotAddUp) {
  const FollowErrors few = followErrors(FrontEndKind::kFlow, 6, 1);
  const FollowErrors many = followErrors(FrontEndKind::kFlow, 18, 1);
  ASSERT_GT(many.lengths.size(), 3000U);
  std::printf("flow: median error %.3f px in 6 frames, %.3f px in 18\n", medianOf(few.lengths),
              medianOf(many.lengths));
  EXPECT_LT(medianOf(many.lengths), 1.3 * medianOf(few.lengths));
}

TEST(FrontEnd, KeyPointsAreMatchedOverLargerMotions) {
  const FollowErrors errors = followErrors(FrontEndKind::kKeyPoints, 3, 4);
  ASSERT_GT(errors.lengths.size(), 200U);
  EXPECT_GT(errors.num_close, 0.7 * static_cast<double>(errors.lengths.size()));
  std::printf("key points: median error %.3f px of %zu\n", medianOf(errors.lengths), errors.lengths.size());
  EXPECT_LT(medianOf(errors.lengths), 0.08);
}

// A photograph turned, scaled and far above the size that is searched.
TEST(FrontEnd, KeyPointsAreAlignedInTurnedAndScaledImages) {
  FootageScene scene{
      .camera = footageCameras()[1], .image_size = kFootageSize, .num_frames = 40, .num_jobs = 1};
  const GrayImage rendered = FootageSimulator(scene).renderFrame(0);
  for (const double enlarged : {1.0, 5.0}) {
    cv::Mat first;
    cv::resize(cv::Mat(rendered.size.height, rendered.size.width, CV_8U,
                       const_cast<std::uint8_t*>(rendered.pixels.data())),
               first, {}, enlarged, enlarged, cv::INTER_CUBIC);
    const cv::Point2f centre(0.5F * static_cast<float>(first.cols), 0.5F * static_cast<float>(first.rows));
    const cv::Mat map = cv::getRotationMatrix2D(centre, 35, 0.8);
    cv::Mat second;
    cv::warpAffine(first, second, map, first.size(), cv::INTER_CUBIC);
    const auto imageOf = [](const cv::Mat& mat) {
      return GrayImage{{mat.cols, mat.rows}, {mat.begin<std::uint8_t>(), mat.end<std::uint8_t>()}};
    };
    const auto front_end = makeFrontEnd(FrontEndKind::kKeyPoints);
    const auto before = front_end->follow(imageOf(first));
    const auto after = front_end->follow(imageOf(second));
    std::vector<double> errors;
    for (const auto& [i, j] : commonTracks(before, after)) {
      const Eigen::Vector2d& p = before[i].pixel;
      const Eigen::Vector2d truth(
          map.at<double>(0, 0) * p.x() + map.at<double>(0, 1) * p.y() + map.at<double>(0, 2),
          map.at<double>(1, 0) * p.x() + map.at<double>(1, 1) * p.y() + map.at<double>(1, 2));
      errors.push_back((after[j].pixel - truth).norm() / enlarged);
    }
    ASSERT_GT(errors.size(), 150U);
    std::printf("key points, turned and scaled: median error %.3f px of %zu\n", medianOf(errors),
                errors.size());
    EXPECT_LT(medianOf(errors), 0.05);
  }
}

// Too small for any point, and of any shape.
TEST(FrontEnd, SmallImagesHaveNoPoints) {
  int num_checked = 0;
  for (const FrontEndKind kind : {FrontEndKind::kFlow, FrontEndKind::kKeyPoints}) {
    for (const ImageSize& size :
         {ImageSize{1, 1}, ImageSize{4001, 1}, ImageSize{5001, 2}, ImageSize{15, 15}}) {
      GrayImage image{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.width * size.height))};
      for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = static_cast<std::uint8_t>(37 * i);
      const auto front_end = makeFrontEnd(kind);
      for (int again = 0; again < 2; ++again) EXPECT_TRUE(front_end->follow(image).empty());
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 8);
}

// A symmetric spot lies where it was drawn: OpenCV's own numbers are a quarter of a pixel off.
TEST(FrontEnd, KeyPointsHaveNoShift) {
  GrayImage image{.size = {320, 240}, .pixels = std::vector<std::uint8_t>(320 * 240)};
  const std::vector<Eigen::Vector2d> spots = {{60.3, 70.6},  {160.0, 70.0},  {255.5, 80.25},
                                              {70.8, 170.1}, {160.4, 165.5}, {250.1, 170.9}};
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      double light = 40;
      for (const Eigen::Vector2d& spot : spots)
        light += 180 * std::exp(-(Eigen::Vector2d(x, y) - spot).squaredNorm() / (2 * 9));
      image.pixels[static_cast<std::size_t>(y * 320 + x)] = static_cast<std::uint8_t>(std::lround(light));
    }
  }
  const auto found = makeFrontEnd(FrontEndKind::kKeyPoints)->follow(image);
  Eigen::Vector2d sum{0, 0};
  int count = 0;
  for (const Eigen::Vector2d& spot : spots) {
    double least = 1;
    Eigen::Vector2d nearest{0, 0};
    for (const TrackPixel& at : found) {
      if ((at.pixel - spot).norm() >= least) continue;
      least = (at.pixel - spot).norm();
      nearest = at.pixel - spot;
    }
    if (least == 1) continue;
    sum += nearest;
    ++count;
  }
  ASSERT_EQ(count, 6);
  EXPECT_LT((sum / count).cwiseAbs().maxCoeff(), 0.05);
}

}  // namespace
}  // namespace alidade
