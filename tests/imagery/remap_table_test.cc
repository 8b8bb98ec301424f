// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "alidade/camera/camera_variant.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "support/cameras_of_model.h"
#include "support/image_sizes.h"
#include "support/rays.h"

namespace alidade {
namespace {

constexpr std::array kProjections = {ViewProjection::kRectilinear, ViewProjection::kCylindrical,
                                     ViewProjection::kEquirectangular};

class RemapTableOfModel : public OfModel {};
INSTANTIATE_TEST_SUITE_P(, RemapTableOfModel, testing::ValuesIn(modelIds()), nameOfModel);

// How a table differs from the projections of all rays.
struct Difference {
  std::size_t num_pixels = 0;
  std::size_t num_with_source = 0;
  std::size_t num_at_border = 0;  // with a source beside a pixel without one
  std::size_t num_wrong = 0;      // a source where there is none, or none where there is one
  double worst_px = 0;            // beyond what the nearest float is off
};

Difference differenceFromProjection(const AnyCamera& camera, const OutputView& view,
                                    const RemapTable& table) {
  Difference result;
  for (int y = 0; y < view.size.height; ++y) {
    for (int x = 0; x < view.size.width; ++x) {
      const auto ray = view.rayFromPixel({x, y});
      const Projection source = ray ? camera.project(*ray) : Projection{};
      const bool is_inside = source.ok() && source.pixel.minCoeff() >= -0.5 &&
                             source.pixel.x() < kTestImage.width - 0.5 &&
                             source.pixel.y() < kTestImage.height - 0.5;
      const SourcePixel& found = table.at(x, y);
      ++result.num_pixels;
      result.num_wrong += found.exists() == is_inside ? 0 : 1;
      if (!found.exists() || !is_inside) continue;
      ++result.num_with_source;
      const bool is_at_border = (x > 0 && !table.at(x - 1, y).exists()) ||
                                (x + 1 < view.size.width && !table.at(x + 1, y).exists()) ||
                                (y > 0 && !table.at(x, y - 1).exists()) ||
                                (y + 1 < view.size.height && !table.at(x, y + 1).exists());
      result.num_at_border += is_at_border ? 1 : 0;
      for (const auto& [value, exact] :
           {std::pair{found.x, source.pixel.x()}, std::pair{found.y, source.pixel.y()}}) {
        const float above = std::nextafter(std::abs(value), std::numeric_limits<float>::infinity());
        const double half_ulp = 0.5 * (static_cast<double>(above) - std::abs(value));
        result.worst_px = std::max(result.worst_px, std::abs(value - exact) - half_ulp);
      }
    }
  }
  return result;
}

constexpr double kPromisedPx = 1e-9;

// Far more than the camera sees; all that it sees; and the last corner of the image, enlarged.
std::vector<OutputView> viewsOf(const AnyCamera& camera, ViewProjection projection) {
  const OutputView far{
      .projection = projection, .size = {211, 137}, .scale_px = {25, 25}, .axis_px = {103.3, 60.8}};
  const auto choose = [&](ViewExtent extent, std::optional<ImageSize> size) {
    return chooseView(camera, kTestImage, {.projection = projection, .extent = extent, .size = size}).view;
  };
  const OutputView all = choose(ViewExtent::kAll, ImageSize{281, 199});
  OutputView corner = choose(ViewExtent::kAll, ImageSize{900, 700});
  corner.axis_px -= Eigen::Vector2d(900 - 241, 700 - 183);
  corner.size = {241, 183};
  return {far, all, corner};
}

TEST_P(RemapTableOfModel, AgreesWithTheProjectionOfEveryRay) {
  std::size_t num_views = 0;
  Difference sum;
  for (const AnyCamera& camera : cameras()) {
    for (const ViewProjection projection : kProjections) {
      for (const OutputView& view : viewsOf(camera, projection)) {
        const RemapTable table = makeRemapTable(camera, kTestImage, view, 2);
        const Difference d = differenceFromProjection(camera, view, table);
        EXPECT_EQ(table.pixels.size(), d.num_pixels);
        EXPECT_EQ(d.num_wrong, 0u) << projectionName(projection);
        EXPECT_EQ(table.num_without_source, d.num_pixels - d.num_with_source);
        EXPECT_LE(d.worst_px, kPromisedPx) << projectionName(projection) << " " << view.size.width;
        sum.num_with_source += d.num_with_source;
        sum.num_at_border += d.num_at_border;
        sum.worst_px = std::max(sum.worst_px, d.worst_px);
        ++num_views;
      }
    }
  }
  EXPECT_EQ(num_views, 9 * cameras().size());
  EXPECT_GT(sum.num_with_source, 10'000 * num_views / 3);
  EXPECT_GT(sum.num_at_border, 100 * num_views);
  this->RecordProperty("worst_px", std::to_string(sum.worst_px));
}

TEST(RemapTable, KeepsDigitsWhereTheViewIsMuchCoarserThanTheSource) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{9000, 9000, 959.5, 599.5});
  int num_scales = 0;
  for (const double scale_px : {500.0, 2000.0, 8000.0, 30000.0}) {
    const OutputView view{.size = {640, 480}, .scale_px = {scale_px, scale_px}, .axis_px = {320.25, 240.5}};
    const Difference d = differenceFromProjection(camera, view, makeRemapTable(camera, kTestImage, view));
    EXPECT_EQ(d.num_wrong, 0u);
    EXPECT_LE(d.worst_px, kPromisedPx) << scale_px;
    EXPECT_GT(d.num_with_source, 5'000u);
    ++num_scales;
  }
  EXPECT_EQ(num_scales, 4);
}

TEST(RemapTable, TakesAnySizeOfOutput) {
  const AnyCamera camera{Camera<Radtan>({1003, 1001, 961, 597, -0.28, 0.08, 1e-3, -5e-4, 0})};
  int num_sizes = 0;
  for (const ImageSize size :
       {ImageSize{1, 1}, {1, 700}, {900, 1}, {7, 300}, {8, 8}, {9, 17}, {161, 160}, {319, 15}, {333, 331}}) {
    const OutputView view{
        .size = size, .scale_px = {400, 410}, .axis_px = {0.45 * size.width, 0.52 * size.height}};
    const Difference d = differenceFromProjection(camera, view, makeRemapTable(camera, kTestImage, view));
    EXPECT_EQ(d.num_wrong, 0u) << size.width << "x" << size.height;
    EXPECT_LE(d.worst_px, kPromisedPx) << size.width << "x" << size.height;
    EXPECT_GT(d.num_with_source, 0u);
    ++num_sizes;
  }
  EXPECT_EQ(num_sizes, 9);
}

TEST(RemapTable, ShowsNothingBeyondAFold) {
  // Folds 41 degrees off the axis; beyond it the bare formula comes back into the image.
  const std::vector<double> params = {300, 300, 319.5, 239.5, -0.45, 0, 0, 0, 0};
  const AnyCamera camera = AnyCamera::make("radtan", params);
  ASSERT_TRUE(camera.cone().is_limited_by_fold);
  const OutputView view{.size = {641, 481}, .scale_px = {100, 100}, .axis_px = {320, 240}};
  const RemapTable table = makeRemapTable(camera, kVga, view);
  int num_beyond = 0;
  int num_back_in_the_image = 0;
  for (int y = 0; y < 481; ++y) {
    for (int x = 0; x < 641; ++x) {
      const double r = std::hypot(x - 320, y - 240) / 100;
      const bool is_beyond = std::atan(r) > camera.cone().max_angle_rad;
      if (!is_beyond) continue;
      EXPECT_FALSE(table.at(x, y).exists()) << x << " " << y;
      ++num_beyond;
      if (300 * std::abs(r * (1 - 0.45 * r * r)) < 200) ++num_back_in_the_image;
    }
  }
  EXPECT_GT(num_beyond, 100'000);
  EXPECT_GT(num_back_in_the_image, 10'000) << "the case that the test is about";
}

TEST(RemapTable, EndsAtTheOuterEdgesOfTheOuterPixels) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{1000, 1000, 0, 0});
  // Four output pixels for one of the source.
  const OutputView view{.size = {60, 8}, .scale_px = {4000, 4000}, .axis_px = {6, 0}};
  const RemapTable table = makeRemapTable(camera, {10, 8}, view);
  EXPECT_FALSE(table.at(3, 0).exists()) << "at -0.75";
  EXPECT_TRUE(table.at(4, 0).exists()) << "at -0.5";
  EXPECT_TRUE(table.at(43, 0).exists()) << "at 9.25";
  EXPECT_FALSE(table.at(44, 0).exists()) << "at 9.5";
  EXPECT_EQ(table.num_without_source, 8u * 20u);
}

TEST(RemapTable, DoesNotDependOnThreadsAndCanBeStopped) {
  const AnyCamera camera{Camera<Radtan>({533, 535, 342, 234, -0.28, 0.08, 1e-3, -5e-4, 0})};
  const OutputView view = chooseView(camera, kVga, {.extent = ViewExtent::kAll, .size = {}}).view;
  const RemapTable one = makeRemapTable(camera, kVga, view, 1);
  const RemapTable three = makeRemapTable(camera, kVga, view, 3);
  EXPECT_TRUE(std::equal(one.pixels.begin(), one.pixels.end(), three.pixels.begin(), three.pixels.end(),
                         [](const SourcePixel& a, const SourcePixel& b) {
                           return a.exists() == b.exists() && (!a.exists() || (a.x == b.x && a.y == b.y));
                         }));
  EXPECT_GT(one.num_without_source, 0u);
  EXPECT_EQ(one.num_without_source, three.num_without_source);
  const CancelFlag cancel{true};
  EXPECT_THROW((void)makeRemapTable(camera, kVga, view, 1, &cancel), Cancelled);
}

}  // namespace
}  // namespace alidade
