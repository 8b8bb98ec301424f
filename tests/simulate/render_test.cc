// SPDX-License-Identifier: MIT
#include "alidade/simulate/render.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/LU>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "alidade/simulate/observe.h"
#include "alidade/simulate/random_views.h"
#include "pattern_tone.h"
#include "support/loop_variants.h"

namespace alidade {
namespace {

constexpr Checkerboard kBoard = {.columns = 8, .rows = 6, .square_m = 0.025};
constexpr ImageSize kSmallSize = {.width = 320, .height = 240};

RenderOptions withoutNoise() {
  return {.read_noise = 0, .full_well_electrons = 0, .num_jobs = 1};
}

AnyCamera distorted() {
  return AnyCamera::make("radtan", std::vector<double>{280, 285, 163, 118, -0.25, 0.08, 1e-3, -5e-4, 0});
}

// With squares of 20 pixels when a board of 1 m squares is 10 m away, and corner 0 at `corner_px`.
AnyCamera pinhole() {
  return AnyCamera::make("pinhole", std::vector<double>{200, 200, 0, 0});
}
SE3 facingAt(const Eigen::Vector2d& corner_px) {
  return {{}, {10 * corner_px.x() / 200, 10 * corner_px.y() / 200, 10}};
}
constexpr Checkerboard kFacingBoard = {.columns = 8, .rows = 6, .square_m = 1};

GrayImage renderBoard(const AnyCamera& camera, ImageSize size, const Checkerboard& board,
                      const SE3& camera_from_board, const RenderOptions& options) {
  return Renderer(camera, size, options.num_jobs).render(board, camera_from_board, options);
}

TEST(Render, CoversPixelsAtAnEdgeByTheirArea) {
  RenderOptions options = withoutNoise();
  options.blur_px = 0;
  options.dark_level = 0;
  options.bright_level = 255;
  int num_checked = 0;
  for (const double offset : {-0.45, -0.3, 0.0, 0.125, 0.4}) {
    const GrayImage image =
        renderBoard(pinhole(), kSmallSize, kFacingBoard, facingAt({100 + offset, 80 + offset}), options);
    // Dark from corner 0 to the right and bright to the left, in the first row of inner squares.
    const double bright = 0.5 + offset;
    // Half a sample of 987 and half a level of rounding.
    const double tolerance = 255 * 0.5 / 987 + 0.5;
    for (int y = 83; y < 97; ++y) {
      EXPECT_NEAR(image.at(100, y), 255 * bright, tolerance) << offset;
      EXPECT_EQ(image.at(99, y), 255);
      EXPECT_EQ(image.at(101, y), 0);
      ++num_checked;
    }
    // The same for the horizontal edge above the square.
    for (int x = 103; x < 117; ++x) {
      EXPECT_NEAR(image.at(x, 80), 255 * bright, tolerance) << offset;
      ++num_checked;
    }
    // At the corner two of the four quarters are dark; the lattice spreads its places evenly in both axes at
    // once, to 1 in 100.
    EXPECT_NEAR(image.at(100, 80), 255 * 2 * bright * (1 - bright), 255 * 0.01 + 0.5) << offset;
  }
  EXPECT_EQ(num_checked, 5 * 28);
}

TEST(Render, SpreadsAnEdgeAsTheGaussianOverThePixel) {
  // Far from other edges of squares of 20 pixels.
  for (const double blur : {0.5, 0.8, 1.5}) {
    RenderOptions options = withoutNoise();
    options.blur_px = blur;
    const double edge = 100.3;
    const GrayImage image = renderBoard(pinhole(), kSmallSize, kFacingBoard, facingAt({edge, 80.2}), options);
    for (int x = 94; x <= 106; ++x) {
      // Mean over the pixel of the Gaussian's integral, by Simpson's rule (error below 1e-5 here).
      constexpr int kNumSteps = 20;
      double dark = 0;
      for (int i = 0; i <= kNumSteps; ++i) {
        const double t = x - 0.5 + static_cast<double>(i) / kNumSteps;
        const double weight = (i == 0 || i == kNumSteps) ? 1 : (i % 2 == 1 ? 4 : 2);
        dark += weight * 0.5 * std::erfc(-(t - edge) / (blur * std::numbers::sqrt2)) / (3 * kNumSteps);
      }
      EXPECT_NEAR(image.at(x, 90), 220 + (30 - 220) * dark, 190 * 0.5 / 987 + 0.5) << blur << " " << x;
    }
  }
}

// By brute force: the sum over a fine grid with the point spread's density, each place unprojected exactly.
double exactLight(const AnyCamera& camera, const SE3& camera_from_board, const RenderOptions& options, int x,
                  int y) {
  constexpr double kStep = 1.0 / 24;
  const double reach = 0.5 + 3.6 * options.blur_px;
  const int num_steps = static_cast<int>(std::ceil(2 * reach / kStep));
  const auto distribution = [&](double t) {
    return 0.5 * std::erfc(-t / (options.blur_px * std::numbers::sqrt2));
  };
  std::vector<double> places;
  std::vector<double> weights;
  for (int i = 0; i < num_steps; ++i) {
    const double d = -reach + (i + 0.5) * 2 * reach / num_steps;
    places.push_back(d);
    weights.push_back(distribution(d + 0.5) - distribution(d - 0.5));
  }
  const SE3 board_from_camera = camera_from_board.inverse();
  const Eigen::Vector3d origin = board_from_camera.translation;
  const std::array<double, 3> levels = {options.dark_level, options.bright_level, options.background_level};
  const InkPattern pattern(kBoard);
  double sum = 0;
  double total = 0;
  for (std::size_t j = 0; j < places.size(); ++j) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto ray = camera.unproject({x + places[i], y + places[j]});
      const Eigen::Vector3d direction = board_from_camera.rotation * ray.value();
      const Eigen::Vector3d point = origin - origin.z() / direction.z() * direction;
      sum += weights[i] * weights[j] * levels[static_cast<std::size_t>(toneAt(pattern, point.head<2>()))];
      total += weights[i] * weights[j];
    }
  }
  return sum / total;
}

TEST(Render, AgreesWithBruteForceUnderDistortion) {
  constexpr int kNumPixels = 200;
  // Half a level is rounding; the rest are three standard deviations of the 987 samples.
  constexpr double kTolerance = 1.5;
  const AnyCamera camera = distorted();
  Random random(21);
  const std::vector<SE3> poses = randomViews(camera, kSmallSize, kBoard, 4, random);
  int num_checked = 0;
  double sum = 0;
  for (const SE3& pose : poses) {
    const GrayImage image = renderBoard(camera, kSmallSize, kBoard, pose, withoutNoise());
    for (int num = 0; num < kNumPixels / 4;) {
      const int x = 1 + static_cast<int>(random.index(kSmallSize.width - 2));
      const int y = 1 + static_cast<int>(random.index(kSmallSize.height - 2));
      const int change = std::abs(image.at(x + 1, y) - image.at(x - 1, y)) +
                         std::abs(image.at(x, y + 1) - image.at(x, y - 1));
      if (change < 20) continue;
      const double difference = image.at(x, y) - exactLight(camera, pose, withoutNoise(), x, y);
      EXPECT_LT(std::abs(difference), kTolerance) << x << " " << y;
      sum += difference;
      ++num;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, kNumPixels);
  // No bias: rounding alone has a standard error of 0.02.
  EXPECT_NEAR(sum / num_checked, 0, 0.1);
}

// The place near `pixel` at which the gradients of the surrounding pixels are at right angles to the lines
// that join it with them (Foerstner and Guelch 1987).
Eigen::Vector2d refineSaddle(const GrayImage& image, Eigen::Vector2d pixel) {
  constexpr int kHalf = 4;
  constexpr double kWindowSigma = 2;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const int x0 = static_cast<int>(std::lround(pixel.x()));
    const int y0 = static_cast<int>(std::lround(pixel.y()));
    Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (int y = y0 - kHalf; y <= y0 + kHalf; ++y) {
      for (int x = x0 - kHalf; x <= x0 + kHalf; ++x) {
        const Eigen::Vector2d place(x, y);
        const Eigen::Vector2d gradient(image.at(x + 1, y) - image.at(x - 1, y),
                                       image.at(x, y + 1) - image.at(x, y - 1));
        const double weight = std::exp(-0.5 * (place - pixel).squaredNorm() / (kWindowSigma * kWindowSigma));
        A += weight * gradient * gradient.transpose();
        b += weight * gradient * gradient.dot(place);
      }
    }
    pixel = A.inverse() * b;
  }
  return pixel;
}

TEST(Render, PutsSaddlesWhereExactViewSays) {
  const AnyCamera camera = distorted();
  Random random(31);
  int num_corners = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double sum2 = 0;
  // Tilts and fills for which the window of 4 pixels and the gradients' reach stay within the four squares.
  const RandomViewOptions view_options{.max_tilt_deg = 20, .min_fill = 0.6, .margin_px = 10};
  for (const SE3& pose : randomViews(camera, kSmallSize, kBoard, 6, random, view_options)) {
    const GrayImage image = renderBoard(camera, kSmallSize, kBoard, pose, withoutNoise());
    for (const Corner& corner : exactView(camera, kSmallSize, kBoard, pose, "").corners) {
      const Eigen::Vector2d error = refineSaddle(image, corner.pixel) - corner.pixel;
      EXPECT_LT(error.norm(), 0.05) << corner.id;  // half a pixel's shift would be 0.7
      sum += error;
      sum2 += error.squaredNorm();
      ++num_corners;
    }
  }
  ASSERT_EQ(num_corners, 6 * 48);
  EXPECT_LT((sum / num_corners).norm(), 0.003);
  EXPECT_LT(std::sqrt(sum2 / num_corners), 0.015);
}

struct Statistics {
  double mean = 0;
  double sigma = 0;
};
Statistics statistics(const GrayImage& image) {
  Statistics s;
  for (const std::uint8_t v : image.pixels) s.mean += v;
  s.mean /= static_cast<double>(image.pixels.size());
  for (const std::uint8_t v : image.pixels) s.sigma += (v - s.mean) * (v - s.mean);
  s.sigma = std::sqrt(s.sigma / static_cast<double>(image.pixels.size()));
  return s;
}

TEST(Render, NoiseHasTheAskedForSpread) {
  const SE3 away = facingAt({1e5, 1e5});  // only background is in the image
  const double num_pixels = kSmallSize.width * kSmallSize.height;
  for (const double full_well : {0.0, 10000.0, 1000.0}) {
    RenderOptions options;
    options.background_level = 110.4;
    options.read_noise = 2;
    options.full_well_electrons = full_well;
    const Statistics s = statistics(renderBoard(pinhole(), kSmallSize, kFacingBoard, away, options));
    // Electrons are levels times full_well / 255 and their variance is their number; rounding adds 1 / 12.
    const double shot = full_well == 0 ? 0 : 110.4 * 255 / full_well;
    const double sigma = std::sqrt(4 + shot + 1.0 / 12);
    EXPECT_NEAR(s.mean, 110.4, 5 * sigma / std::sqrt(num_pixels)) << full_well;
    EXPECT_NEAR(s.sigma, sigma, 5 * sigma / std::sqrt(2 * num_pixels)) << full_well;
  }
}

TEST(Render, ClampsToEightBits) {
  RenderOptions options;
  options.read_noise = 200;
  const GrayImage image = renderBoard(pinhole(), kSmallSize, kFacingBoard, facingAt({100, 80}), options);
  EXPECT_GT(std::count(image.pixels.begin(), image.pixels.end(), 0), 1000);
  EXPECT_GT(std::count(image.pixels.begin(), image.pixels.end(), 255), 1000);
}

TEST(Render, ShadesByColumnAndFieldAngle) {
  RenderOptions options = withoutNoise();
  options.background_level = 200;
  options.falloff = 0.5;
  const SE3 away = facingAt({1e5, 1e5});
  GrayImage image = renderBoard(pinhole(), kSmallSize, kFacingBoard, away, options);
  for (int x = 0; x < kSmallSize.width; ++x)
    EXPECT_NEAR(image.at(x, 7), 200 * (1 - 0.5 * (x + 0.5) / 320), 0.5001);
  options.falloff = 0;
  options.vignetting_exponent = 4;
  image = renderBoard(pinhole(), kSmallSize, kFacingBoard, away, options);
  for (int x = 0; x < kSmallSize.width; ++x) {
    const double cosine = 200 / std::hypot(200, x, 7);
    EXPECT_NEAR(image.at(x, 7), 200 * std::pow(cosine, 4), 0.501);
  }
}

TEST(Render, DependsOnTheSeedAndNotOnTheThreads) {
  Random random(41);
  const SE3 pose = randomViews(distorted(), kSmallSize, kBoard, 1, random).front();
  RenderOptions options;
  options.num_jobs = 1;
  const GrayImage one = renderBoard(distorted(), kSmallSize, kBoard, pose, options);
  for (const int num_jobs : {2, 8}) {
    options.num_jobs = num_jobs;
    EXPECT_EQ(renderBoard(distorted(), kSmallSize, kBoard, pose, options).pixels, one.pixels) << num_jobs;
  }
  const Renderer renderer(distorted(), kSmallSize);
  EXPECT_EQ(renderer.render(kBoard, pose, options).pixels, one.pixels);
  options.seed = 2;
  const GrayImage other = renderer.render(kBoard, pose, options);
  std::size_t num_different = 0;
  for (std::size_t i = 0; i < one.pixels.size(); ++i)
    num_different += one.pixels[i] != other.pixels[i] ? 1 : 0;
  EXPECT_GT(num_different, one.pixels.size() / 2);
}

TEST(Render, ShowsTheBackgroundForABoardFromBehindOrBehindTheCamera) {
  const auto turned = SO3::exp({0, std::numbers::pi, 0});
  for (const SE3& pose : {SE3{turned, {8, 4, 10}}, SE3{{}, {-5, -5, -10}}}) {
    const GrayImage image = renderBoard(pinhole(), kSmallSize, kFacingBoard, pose, withoutNoise());
    EXPECT_EQ(std::count(image.pixels.begin(), image.pixels.end(), 110),
              kSmallSize.width * kSmallSize.height);
  }
}

TEST(Render, EndsABoardAtItsHorizon) {
  // A floor of squares 2 m below the camera: the horizon crosses the image at y = 119.5.
  const Checkerboard board = {.columns = 400, .rows = 400, .square_m = 1};
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{200, 200, 159.5, 119.5});
  const SE3 pose = SE3{SO3::exp({-std::numbers::pi / 2, 0, 0}), {0, 2, 0}} * SE3{{}, {-200.3, -200, 0}};
  const GrayImage image = renderBoard(camera, kSmallSize, board, pose, withoutNoise());
  int num_sky = 0;
  for (int y = 0; y < 115; ++y) num_sky += image.at(160, y) == 110 ? 1 : 0;
  EXPECT_EQ(num_sky, 115);
  // Right below the horizon the squares are much smaller than pixels: their mean, 125.
  EXPECT_NEAR(image.at(160, 122), 125, 25);
  // Further down they can be told apart.
  EXPECT_GT(std::count(image.pixels.begin(), image.pixels.end(), 30), 1000);
  EXPECT_GT(std::count(image.pixels.begin(), image.pixels.end(), 220), 1000);
}

TEST(Render, LeavesPixelsWithoutARayBlack) {
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{160, 160, 170, 118, -0.35, 0, 0, 0, 0});
  const GrayImage image = renderBoard(camera, kSmallSize, kFacingBoard, facingAt({1e5, 1e5}), withoutNoise());
  int num_black = 0;
  for (int y = 0; y < kSmallSize.height; ++y) {
    for (int x = 0; x < kSmallSize.width; ++x) {
      const bool has_ray = camera.unproject({x, y}).has_value();
      ASSERT_EQ(image.at(x, y), has_ray ? 110 : 0) << x << " " << y;
      num_black += has_ray ? 0 : 1;
    }
  }
  EXPECT_GT(num_black, 30000);
}

// A print that looks the same with other cells and instructions, square by square and disc by disc.
TEST(Render, IsTheSameByMarksAndPlaceByPlace) {
  BoardInk few{.boxes = {}, .extent = {Eigen::Vector2d(-0.025, -0.025), Eigen::Vector2d(0.8, 0.8)}};
  for (int row = -1; row < kBoard.rows; ++row) {
    for (int column = -1; column < kBoard.columns; ++column) {
      const Eigen::Vector2d low = kBoard.square_m * Eigen::Vector2d(column, row);
      const Eigen::Vector2d inset = 0.2 * Eigen::Vector2d(kBoard.square_m, kBoard.square_m);
      const Eigen::AlignedBox2d square(low, low + 5 * inset);
      if ((row + column) % 2 == 0) few.boxes.push_back(square);
      if ((row + column) % 2 != 0) few.discs.emplace_back(square.min() + inset, square.max() - inset);
    }
  }
  // So many marks, far beyond the images, that a pixel covers many cells.
  BoardInk many = few;
  for (int i = 0; i < 400 * 400; ++i) {
    const Eigen::Vector2d low(0.79 + 2.5e-5 * (i % 400), 0.79 + 2.5e-5 * (i / 400));
    many.boxes.emplace_back(low, low + Eigen::Vector2d(1e-5, 1e-5));
  }
  const AnyCamera camera = distorted();
  const Renderer renderer(camera, kSmallSize, 1);
  Random random(5);
  std::vector<GrayImage> images;
  for (const SE3& pose : randomViews(camera, kSmallSize, kBoard, 3, random)) {
    images.clear();
    withAndWithoutAvx2([&] { images.push_back(renderer.render(few, pose, withoutNoise())); });
    images.push_back(renderer.render(many, pose, withoutNoise()));
    ASSERT_EQ(images.size(), 3U);
    EXPECT_EQ(images[0].pixels, images[1].pixels);
    EXPECT_EQ(images[0].pixels, images[2].pixels);
    const auto [dark, bright] = std::ranges::minmax(images[0].pixels);
    EXPECT_EQ(dark, 30);
    EXPECT_EQ(bright, 220);
  }
}

TEST(Render, RefusesOptionsOutOfRange) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<RenderOptions> wrong = {{.blur_px = -1},
                                            {.blur_px = kNan},
                                            {.dark_level = -1},
                                            {.bright_level = 256},
                                            {.border_square = kNan},
                                            {.border_square = -3},
                                            {.border_square = 1e300},
                                            {.falloff = 1.5},
                                            {.read_noise = -0.1},
                                            {.full_well_electrons = -1},
                                            {.samples = 0},
                                            {.background_level = kNan},
                                            {.vignetting_exponent = -1}};
  for (const RenderOptions& options : wrong) {
    EXPECT_THROW((void)renderBoard(pinhole(), kSmallSize, kFacingBoard, facingAt({100, 80}), options), Error);
  }
}

TEST(Render, StopsWhenCancelled) {
  const CancelFlag cancel = true;
  const Renderer renderer(pinhole(), kSmallSize, 1);
  EXPECT_THROW((void)renderer.render(kFacingBoard, facingAt({100, 80}), withoutNoise(), &cancel), Cancelled);
}

}  // namespace
}  // namespace alidade
