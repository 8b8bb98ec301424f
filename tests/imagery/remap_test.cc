// SPDX-License-Identifier: MIT
#include "alidade/imagery/remap.h"

#include <gmock/gmock.h>
#include <opencv2/core/version.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "alidade/detect/corner/corner_fit.h"
#include "alidade/imagery/undistortion_view.h"
#include "alidade/simulate/random_views.h"
#include "alidade/simulate/render.h"
#include "support/pixel_from_ray.h"

namespace alidade {
namespace {

constexpr std::array kInterpolations = {Interpolation::kLinear, Interpolation::kCubic};

// A table from the place of each output pixel.
RemapTable tableOf(ImageSize source_size, ImageSize size, const std::function<SourcePixel(int, int)>& place) {
  RemapTable table{.source_size = source_size, .size = size, .pixels = {}};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) table.pixels.push_back(place(x, y));
  }
  return table;
}

constexpr SourcePixel kNowhere{std::numeric_limits<float>::quiet_NaN(),
                               std::numeric_limits<float>::quiet_NaN()};

// Samples by pixel and channel.
template <class Sample>
RasterImage rasterOf(ImageSize size, int num_channels, const std::function<double(int, int, int)>& sample) {
  RasterImage image{.size = size,
                    .num_channels = num_channels,
                    .bits_per_sample = 8 * static_cast<int>(sizeof(Sample)),
                    .bytes = {}};
  image.bytes.resize(image.numPixels() * image.bytesPerPixel());
  auto* out = reinterpret_cast<Sample*>(image.bytes.data());
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      for (int c = 0; c < num_channels; ++c) *out++ = static_cast<Sample>(sample(x, y, c));
    }
  }
  return image;
}

template <class Sample>
double sampleAt(const RasterImage& image, int x, int y, int c) {
  const auto* samples = reinterpret_cast<const Sample*>(image.bytes.data());
  return samples[(static_cast<std::ptrdiff_t>(y) * image.size.width + x) * image.num_channels + c];
}

// Source places are rounded to 1/32 px, by OpenCV 5 only with two channels and linear interpolation.
double roundedPlace(float place, int num_channels, Interpolation interpolation) {
  const bool is_rounded =
      CV_VERSION_MAJOR < 5 || (num_channels == 2 && interpolation == Interpolation::kLinear);
  const double steps = is_rounded ? 32 : 1 << 20;
  return std::round(steps * static_cast<double>(place)) / steps;
}

// Planes of grey levels come out up to the rounding, whatever the channels and bits; the cubic kernel moves
// them by up to a twentieth of a pixel between pixels.
template <class Sample>
int checkPlanes(double scale) {
  int num_checked = 0;
  const ImageSize size{37, 29};
  const auto level = [&](double x, double y, int c) { return scale * (20 + (c + 1) * x + (4 - c) * y); };
  const auto place = [](int x, int y) {
    return SourcePixel{3 + 0.93F * static_cast<float>(x), 2.5F + 0.81F * static_cast<float>(y)};
  };
  const RemapTable table = tableOf(size, {30, 25}, place);
  for (int num_channels = 1; num_channels <= 4; ++num_channels) {
    const RasterImage image = rasterOf<Sample>(size, num_channels, level);
    for (const Interpolation interpolation : kInterpolations) {
      const RasterImage out = remap(table, image, interpolation, 2);
      EXPECT_EQ(out.size, table.size);
      EXPECT_EQ(out.num_channels, num_channels);
      EXPECT_EQ(out.bits_per_sample, image.bits_per_sample);
      double worst = 0;
      for (int y = 0; y < 25; ++y) {
        for (int x = 0; x < 30; ++x) {
          const double source_x = roundedPlace(place(x, y).x, num_channels, interpolation);
          const double source_y = roundedPlace(place(x, y).y, num_channels, interpolation);
          for (int c = 0; c < num_channels; ++c)
            worst = std::max(worst, std::abs(sampleAt<Sample>(out, x, y, c) - level(source_x, source_y, c)));
        }
      }
      const double per_pixel = 5 * scale;  // the sum of both slopes
      EXPECT_LE(worst, 0.51 + (interpolation == Interpolation::kCubic ? 0.05 * per_pixel : 0))
          << num_channels;
      ++num_checked;
    }
  }
  return num_checked;
}

TEST(Remap, ReproducesPlanesInAnyChannelsAndBits) {
  EXPECT_EQ(checkPlanes<std::uint8_t>(1), 8);
  EXPECT_EQ(checkPlanes<std::uint16_t>(200), 8);
}

TEST(Remap, DoesNotDependOnThreads) {
  // More rows than a strip has.
  const ImageSize size{300, 500};
  const RasterImage image =
      rasterOf<std::uint8_t>(size, 3, [](int x, int y, int c) { return (7 * x * y + 31 * c) % 256; });
  const RemapTable table = tableOf(size, {400, 600}, [](int x, int y) {
    return (x + y) % 5 == 0 ? kNowhere
                            : SourcePixel{0.71F * static_cast<float>(x), 0.83F * static_cast<float>(y)};
  });
  for (const Interpolation interpolation : kInterpolations)
    EXPECT_EQ(remap(table, image, interpolation, 1).bytes, remap(table, image, interpolation, 3).bytes);
}

TEST(Remap, IsBlackWithoutASourceAndOnlyThere) {
  const ImageSize size{16, 12};
  const RasterImage image = rasterOf<std::uint8_t>(size, 4, [](int, int, int) { return 255; });
  // From beyond the outer pixels' centres to beyond their edges.
  const RemapTable table = tableOf(size, {5, 1}, [](int x, int) {
    return std::vector<SourcePixel>{
        {-0.5F, -0.5F}, {15.49F, 11.49F}, {15.5F, 11.5F}, kNowhere, {7, 5}}[static_cast<std::size_t>(x)];
  });
  for (const Interpolation interpolation : kInterpolations) {
    const RasterImage out = remap(table, image, interpolation);
    for (int c = 0; c < 4; ++c) {
      EXPECT_EQ(sampleAt<std::uint8_t>(out, 0, 0, c), 255);
      EXPECT_EQ(sampleAt<std::uint8_t>(out, 1, 0, c), 255);
      EXPECT_EQ(sampleAt<std::uint8_t>(out, 2, 0, c), 255);
      EXPECT_EQ(sampleAt<std::uint8_t>(out, 3, 0, c), 0);
      EXPECT_EQ(sampleAt<std::uint8_t>(out, 4, 0, c), 255);
    }
  }
}

TEST(Remap, KeepsWithinTheRangeOfSamples) {
  // A single bright column in the dark and a dark one in the bright, where the cubic kernel overshoots.
  const RasterImage image = rasterOf<std::uint16_t>(
      {20, 5}, 1, [](int x, int, int) { return (x == 5) != (x >= 10 && x != 15) ? 65535 : 0; });
  const RemapTable table = tableOf({20, 5}, {77, 5}, [](int x, int y) {
    return SourcePixel{0.25F * static_cast<float>(x), static_cast<float>(y)};
  });
  const RasterImage out = remap(table, image, Interpolation::kCubic);
  EXPECT_EQ(sampleAt<std::uint16_t>(out, 4 * 5, 2, 0), 65535);
  EXPECT_EQ(sampleAt<std::uint16_t>(out, 4 * 5 + 6, 2, 0), 0) << "below zero without the clamp";
  EXPECT_EQ(sampleAt<std::uint16_t>(out, 4 * 15 + 6, 2, 0), 65535) << "above the range without the clamp";
}

TEST(Remap, RefusesImagesOfAnotherSize) {
  const RemapTable table = tableOf({4, 4}, {4, 4}, [](int, int) { return SourcePixel{1, 1}; });
  const RasterImage other = rasterOf<std::uint8_t>({4, 5}, 1, [](int, int, int) { return 0; });
  EXPECT_THROW((void)remap(table, other, Interpolation::kLinear), std::logic_error);
}

struct CornerErrors {
  int num_corners = 0;
  int num_found = 0;
  double worst_px = 0;
  double sum_squares = 0;
};

// Renders views through a lens, takes its distortion out, and measures where the corners are.
CornerErrors cornerErrors(ViewProjection projection, Interpolation interpolation) {
  const ImageSize size{320, 240};
  const Checkerboard board{.columns = 6, .rows = 5, .square_m = 0.03};
  const AnyCamera camera =
      AnyCamera::make("radtan", std::vector<double>{260, 262, 163, 118, -0.28, 0.08, 1e-3, -5e-4, 0});
  const OutputView view =
      chooseView(camera, size, {.projection = projection, .extent = ViewExtent::kAll, .size = {}}).view;
  const RemapTable table = makeRemapTable(camera, size, view);
  Random random(5);
  RandomViewOptions options;
  options.min_fill = 0.7;
  CornerErrors errors;
  const Renderer renderer(camera, size);
  for (const SE3& camera_from_board : randomViews(camera, size, board, 2, random, options)) {
    GrayImage seen = renderer.render(board, camera_from_board,
                                     {.read_noise = 0, .full_well_electrons = 0, .samples = 233});
    const GrayImage image{view.size,
                          remap(table, {.size = size, .bytes = std::move(seen.pixels)}, interpolation).bytes};
    std::vector<Eigen::Vector2d> truth;
    for (int id = 0; id < board.numCorners(); ++id) {
      const Eigen::Vector3d point = camera_from_board * board.corner(id);
      truth.push_back(projection == ViewProjection::kRectilinear ? pinholeOf(view).project(point).pixel
                                                                 : pixelFromRay(view, point).value());
    }
    const auto stepAt = [&](int id, int stride, int index, int count) -> Eigen::Vector2d {
      const auto at = [&](int k) { return truth[static_cast<std::size_t>(k)]; };
      if (index == 0) return at(id + stride) - at(id);
      if (index == count - 1) return at(id) - at(id - stride);
      return 0.5 * (at(id + stride) - at(id - stride));
    };
    for (int id = 0; id < board.numCorners(); ++id) {
      ++errors.num_corners;
      const Eigen::Vector2d expected = truth[static_cast<std::size_t>(id)];
      const CornerGuess guess{.pixel = expected + Eigen::Vector2d(0.7, -0.4),
                              .step_u = stepAt(id, 1, id % board.columns, board.columns),
                              .step_v = stepAt(id, board.columns, id / board.columns, board.rows)};
      const auto fit = CornerFitter().fit(image, guess);
      if (!fit) continue;
      ++errors.num_found;
      const double error = (fit->pixel - expected).norm();
      errors.worst_px = std::max(errors.worst_px, error);
      errors.sum_squares += error * error;
    }
  }
  return errors;
}

TEST(Remap, PutsCornersWhereTheViewHasThem) {
  int num_views = 0;
  for (const ViewProjection projection :
       {ViewProjection::kRectilinear, ViewProjection::kCylindrical, ViewProjection::kEquirectangular}) {
    for (const Interpolation interpolation : kInterpolations) {
      const CornerErrors errors = cornerErrors(projection, interpolation);
      EXPECT_EQ(errors.num_corners, 60);
      EXPECT_EQ(errors.num_found, 60) << projectionName(projection);
      EXPECT_LT(errors.worst_px, 0.08) << projectionName(projection);
      EXPECT_LT(std::sqrt(errors.sum_squares / errors.num_found), 0.03) << projectionName(projection);
      ++num_views;
    }
  }
  EXPECT_EQ(num_views, 6);
}

}  // namespace
}  // namespace alidade
