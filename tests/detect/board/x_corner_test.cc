// SPDX-License-Identifier: MIT
#include "alidade/detect/board/x_corner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "alidade/core/random.h"
#include "alidade/imagery/gray_image.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

// Grey levels by place, averaged over 4 x 4 points of each pixel.
GrayImage draw(ImageSize size, const std::function<double(const Vector2d&)>& level) {
  GrayImage image{.size = size, .pixels = {}};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) sum += level({x - 0.375 + 0.25 * i, y - 0.375 + 0.25 * j});
      }
      image.pixels.push_back(static_cast<std::uint8_t>(std::lround(sum / 16)));
    }
  }
  return image;
}

// Two lines through `center` at these angles; the sector clockwise of the first is dark.
GrayImage drawCorner(const Vector2d& center, double first, double second, double dark, double bright) {
  return draw({.width = 41, .height = 41}, [=](const Vector2d& p) {
    const Vector2d d = p - center;
    const double a = std::cos(first) * d.y() - std::sin(first) * d.x();
    const double b = std::cos(second) * d.y() - std::sin(second) * d.x();
    return (a > 0) != (b > 0) ? dark : bright;
  });
}

TEST(FindXCorners, SeesPositionEdgesAndColoursAtAnyAngle) {
  int num_checked = 0;
  Random random(1);
  for (int turn = 0; turn < 40; ++turn) {
    const double first = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double opening = random.uniform(0.6, std::numbers::pi - 0.6);
    const Vector2d center(20 + random.uniform(-0.5, 0.5), 20 + random.uniform(-0.5, 0.5));
    const std::vector<XCorner> corners =
        findXCorners(smoothed(drawCorner(center, first, first + opening, 40, 200)));
    ASSERT_EQ(corners.size(), 1U) << "angles " << first << " + " << opening;
    const XCorner& corner = corners.front();
    EXPECT_LT((corner.pixel - center).norm(), 0.5);
    EXPECT_LT(corner.contrast, 165);
    EXPECT_GT(corner.contrast, 95) << "smoothing takes most from narrow sectors";
    for (int k = 0; k < 4; ++k) {
      const Vector2d& edge = corner.edges[static_cast<std::size_t>(k)];
      const Vector2d& next = corner.edges[static_cast<std::size_t>((k + 1) % 4)];
      EXPECT_NEAR(edge.norm(), 1, 1e-12);
      EXPECT_GT(edge.x() * next.y() - edge.y() * next.x(), 0) << "clockwise as seen";
      const auto distance = [&](double angle) {
        return std::abs(edge.x() * std::sin(angle) - edge.y() * std::cos(angle));
      };
      EXPECT_LT(std::min(distance(first), distance(first + opening)), 0.2);
      const bool middle_is_dark = [&] {
        const Vector2d d = edge + next;
        const double a = std::cos(first) * d.y() - std::sin(first) * d.x();
        const double b = std::cos(first + opening) * d.y() - std::sin(first + opening) * d.x();
        return (a > 0) != (b > 0);
      }();
      EXPECT_EQ(corner.sectorIsDark(k), middle_is_dark);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 160);
}

TEST(FindXCorners, SeesNoneInEdgesLineEndsBlobsAndFaintPatterns) {
  const ImageSize size{.width = 41, .height = 41};
  const std::vector<std::pair<std::string, GrayImage>> images = {
      {"flat", draw(size, [](const Vector2d&) { return 100.0; })},
      {"edge", draw(size, [](const Vector2d& p) { return p.x() + 0.3 * p.y() > 25 ? 200.0 : 40.0; })},
      {"L", draw(size, [](const Vector2d& p) { return p.x() > 20 && p.y() > 20 ? 40.0 : 200.0; })},
      {"T", draw(size, [](const Vector2d& p) { return p.y() < 20   ? 200.0
                                                      : p.x() > 20 ? 40.0
                                                                   : 120.0; })},
      {"blob",
       draw(size, [](const Vector2d& p) { return (p - Vector2d(20, 20)).norm() < 5 ? 40.0 : 200.0; })},
      {"ramp", draw(size, [](const Vector2d& p) { return 5 * p.x(); })},
      {"faint", drawCorner({20, 20}, 0.1, 1.6, 100, 106)},
  };
  int num_checked = 0;
  for (const auto& [name, image] : images) {
    EXPECT_TRUE(findXCorners(smoothed(image)).empty()) << name;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 7);
}

TEST(Smoothed, IsTheBinomialMeanAndKeepsTheBorder) {
  Random random(2);
  GrayImage image{.size = {.width = 9, .height = 7}, .pixels = {}};
  for (int i = 0; i < 63; ++i) image.pixels.push_back(static_cast<std::uint8_t>(random.index(256)));
  const SmoothImage smooth = smoothed(image);
  constexpr int kWeights[5] = {1, 4, 6, 4, 1};
  int num_checked = 0;
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 9; ++x) {
      int sum = 0;
      for (int dy = -2; dy <= 2; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) {
          sum += kWeights[dx + 2] * kWeights[dy + 2] *
                 image.at(std::clamp(x + dx, 0, 8), std::clamp(y + dy, 0, 6));
        }
      }
      EXPECT_EQ(smooth.row(y)[x], sum);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 63);
}

TEST(Halved, IsTheMeanOfFourAndKnowsWhereItsPixelsLie) {
  const GrayImage image{.size = {.width = 5, .height = 3},
                        .pixels = {10, 20, 30, 40, 99, 30, 40, 50, 61, 99, 99, 99, 99, 99, 99}};
  const GrayImage half = detail::shrunk(image, 2);
  EXPECT_EQ(half.size, (ImageSize{.width = 2, .height = 1}));
  EXPECT_EQ(half.pixels, (std::vector<std::uint8_t>{25, 45}));
  EXPECT_EQ(fromHalved({0, 0}, 1), Vector2d(0.5, 0.5));
  EXPECT_EQ(fromHalved({1, 0}, 1), Vector2d(2.5, 0.5));
  EXPECT_EQ(fromHalved({0, 0}, 2), Vector2d(1.5, 1.5));
  EXPECT_TRUE(detail::shrunk({.size = {.width = 1, .height = 4}, .pixels = {1, 2, 3, 4}}, 2).empty());
}

}  // namespace
}  // namespace alidade
