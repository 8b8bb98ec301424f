// SPDX-License-Identifier: MIT
#include "alidade/imagery/frame_choice.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "imagery/video_files.h"

namespace alidade {
namespace {

GrayImage grayOf(const cv::Mat& mat) {
  return {.size = {mat.cols, mat.rows}, .pixels = {mat.datastart, mat.dataend}};
}

cv::Mat blurred(const cv::Mat& frame) {
  cv::Mat result;
  cv::GaussianBlur(frame, result, {}, 3);
  return result;
}

TEST(FrameChoice, TakesWhatDiffers) {
  FrameChooser chooser(10);
  for (int i = 0; i < 200; ++i) chooser.add(static_cast<std::size_t>(i), lookAt(grayOf(movingSquare(i))));
  const std::vector<std::size_t> chosen = chooser.chosen();
  ASSERT_EQ(chosen.size(), 10u);
  EXPECT_TRUE(std::is_sorted(chosen.begin(), chosen.end()));
  // The square is in another place of the image in each.
  std::set<std::pair<std::size_t, std::size_t>> places;
  for (const std::size_t number : chosen) places.insert({number % 40 / 5, number / 40});
  EXPECT_EQ(places.size(), 10u);
}

TEST(FrameChoice, TakesWhatLooksTheSameOnce) {
  FrameChooser chooser(10);
  for (std::size_t i = 0; i < 300; ++i) chooser.add(i, lookAt(grayOf(movingSquare(i < 150 ? 3 : 30))));
  EXPECT_EQ(chooser.chosen().size(), 2u);
}

TEST(FrameChoice, AvoidsBlurredFrames) {
  FrameChooser chooser(20);
  for (int i = 0; i < 120; ++i) {
    const cv::Mat frame = movingSquare(i);
    chooser.add(static_cast<std::size_t>(i), lookAt(grayOf(i % 3 == 0 ? frame : blurred(frame))));
  }
  const std::vector<std::size_t> chosen = chooser.chosen();
  EXPECT_EQ(chosen.size(), 20u);
  const auto num_sharp =
      std::count_if(chosen.begin(), chosen.end(), [](std::size_t n) { return n % 3 == 0; });
  EXPECT_GE(num_sharp, 19);
}

TEST(FrameChoice, TakesAllPhotographsOfASequence) {
  // Photographs differ in sharpness by what they show.
  FrameChooser chooser(100);
  for (int i = 0; i < 20; ++i) {
    const cv::Mat frame = movingSquare(8 * i);
    chooser.add(static_cast<std::size_t>(i), lookAt(grayOf(i % 2 == 0 ? frame : blurred(frame))));
  }
  EXPECT_EQ(chooser.chosen().size(), 20u);
}

TEST(FrameChoice, CoversALongVideo) {
  FrameChooser chooser(8);
  constexpr std::size_t kNumFrames = 100'000;
  FrameLook look;
  look.sharpness = 100;
  for (std::size_t i = 0; i < kNumFrames; ++i) {
    look.thumbnail.fill(static_cast<std::uint8_t>(i * 256 / kNumFrames));
    chooser.add(i, look);
  }
  const std::vector<std::size_t> chosen = chooser.chosen();
  ASSERT_EQ(chosen.size(), 8u);
  EXPECT_LT(chosen.front(), kNumFrames / 20);
  EXPECT_GT(chosen.back(), kNumFrames - kNumFrames / 10);
  for (std::size_t i = 1; i < chosen.size(); ++i) EXPECT_LT(chosen[i] - chosen[i - 1], kNumFrames / 4);
}

}  // namespace
}  // namespace alidade
