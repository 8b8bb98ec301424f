// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "alidade/detect/detect_images.h"
#include "alidade/simulate/render.h"
#include "support/board_photo.h"
#include "support/image_sizes.h"

namespace alidade {
namespace {

constexpr int kNumViews = 3;
const std::array kCutWidths = {0.25, 0.33, 0.5, 0.75};

const SimulatedSet& truthOfViews() {
  static const SimulatedSet truth = [] {
    RandomViewOptions views;
    views.max_roll_deg = 180;
    return simulateSet(commonCamera(kVga), kVga, kNumViews, 0, 31, views);
  }();
  return truth;
}

// Rendered once for all tests.
const GrayImage& rendered(std::size_t view, double border_square) {
  static const Renderer renderer(truthOfViews().camera, kVga);
  static std::map<std::pair<std::size_t, double>, GrayImage> images;
  GrayImage& image = images[{view, border_square}];
  if (!image.empty()) return image;
  RenderOptions options;
  options.blur_px = 0.7;
  options.read_noise = 2;
  options.border_square = border_square;
  options.seed = 100 + view;
  options.samples = 233;
  return image = renderer.render(truthOfViews().board, truthOfViews().poses[view], options);
}

// The image with all that lies beyond `edge` along `outwards` covered by `level`.
GrayImage covered(GrayImage image, const Eigen::Vector2d& edge, const Eigen::Vector2d& outwards,
                  double level) {
  const Eigen::Vector2d normal = outwards.normalized();
  for (int y = 0; y < kVga.height; ++y) {
    for (int x = 0; x < kVga.width; ++x) {
      std::uint8_t& grey = image.pixels[static_cast<std::size_t>(y * kVga.width + x)];
      const double share = 0.5 * std::erfc(-normal.dot(Eigen::Vector2d(x, y) - edge));
      grey = static_cast<std::uint8_t>(std::lround((1 - share) * grey + share * level));
    }
  }
  return image;
}

// Of corners against the truth, per axis.
struct Errors {
  int num_found = 0;  // views with all corners
  int num_corners = 0;
  double square = 0;
  double square_sigmas = 0;

  void add(const Detection& detection, const View& truth) {
    num_found += detection.found() ? 1 : 0;
    for (const Corner& corner : detection.corners) {
      const double error =
          (corner.pixel - truth.corners[static_cast<std::size_t>(corner.id)].pixel).squaredNorm() / 2;
      square += error;
      square_sigmas += error / (corner.sigma_px * corner.sigma_px);
      ++num_corners;
    }
  }
  [[nodiscard]] double rms() const { return std::sqrt(square / num_corners); }
  [[nodiscard]] double rmsOfSigmas() const { return std::sqrt(square_sigmas / num_corners); }
};

Errors errorsAt(double border_square) {
  Errors errors;
  for (std::size_t view = 0; view < kNumViews; ++view)
    errors.add(findBoard(rendered(view, border_square), truthOfViews().board), truthOfViews().views[view]);
  return errors;
}

TEST(CutSquares, AllCornersAreFoundAsExactlyAsOnAWholeBoard) {
  const Errors whole = errorsAt(1);
  EXPECT_EQ(whole.num_found, kNumViews);
  int num_corners = 0;
  for (const double width : kCutWidths) {
    const Errors errors = errorsAt(width);
    EXPECT_EQ(errors.num_found, kNumViews) << width;
    // Half of the corners lie on the rim, where the edges are shorter by a third.
    EXPECT_LE(errors.rms(), 1.35 * whole.rms()) << width;
    EXPECT_GE(errors.rmsOfSigmas(), 0.85) << width;
    EXPECT_LE(errors.rmsOfSigmas(), 1.15) << width;
    num_corners += errors.num_corners;
  }
  EXPECT_EQ(num_corners, 4 * kNumViews * 54);
}

TEST(CutSquares, MayBeOnOneSideOnly) {
  constexpr double kBrightLevel = 220;
  Errors errors;
  for (const double width : {0.25, 0.33, 0.5}) {
    for (std::size_t view = 0; view < kNumViews; ++view) {
      const View& truth = truthOfViews().views[view];
      const auto pixelOf = [&](std::size_t id) { return truth.corners[id].pixel; };
      const Eigen::Vector2d top = pixelOf(0) - width * (pixelOf(1) - pixelOf(0));
      const Eigen::Vector2d bottom = pixelOf(45) - width * (pixelOf(46) - pixelOf(45));
      const Eigen::Vector2d left((bottom - top).y() * -1, (bottom - top).x());
      errors.add(findBoard(covered(rendered(view, 1), top, left, kBrightLevel), truthOfViews().board), truth);
    }
  }
  EXPECT_EQ(errors.num_found, 3 * kNumViews);
  EXPECT_EQ(errors.num_corners, 3 * kNumViews * 54);
  EXPECT_LE(errors.rms(), 1.2 * errorsAt(1).rms());
  EXPECT_LE(errors.rmsOfSigmas(), 1.15);
}

// Beside a bright cover, neither whole boards nor cut ones may gain corners that are wrong.
TEST(CutSquares, AreNotSeenInACover) {
  Random random(8);
  int num_checked = 0;
  int num_corners = 0;
  for (const double width : {0.33, 1.0}) {
    for (int i = 0; i < 45; ++i) {
      const auto view = static_cast<std::size_t>(i % kNumViews);
      const View& truth = truthOfViews().views[view];
      const auto pixelOf = [&](int id) { return truth.corners[static_cast<std::size_t>(id)].pixel; };
      // The cover ends near the last column of corners.
      const Eigen::Vector2d step = pixelOf(26) - pixelOf(25);
      const Eigen::Vector2d outwards = Eigen::Rotation2Dd(random.uniform(-0.1, 0.1)) * step;
      const GrayImage image = covered(rendered(view, width), pixelOf(26) + random.uniform(-0.1, 0.5) * step,
                                      outwards, random.uniform(150, 250));
      for (const Corner& corner : findBoard(image, truthOfViews().board).corners) {
        EXPECT_LE((corner.pixel - pixelOf(corner.id)).norm(), std::max(0.05, 8 * corner.sigma_px))
            << width << " " << i << " corner " << corner.id;
        ++num_corners;
      }
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 90);
  EXPECT_GE(num_corners, 45 * 40);
}

}  // namespace
}  // namespace alidade
