// SPDX-License-Identifier: MIT
#include "alidade/image/remap_table.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "alidade/image/undistortion_view.h"
#include "support/model_fixture.h"

namespace alidade {
namespace {

constexpr ImageSize kSize{640, 480};
constexpr std::array kProjections = {ViewProjection::kRectilinear, ViewProjection::kCylindrical,
                                     ViewProjection::kEquirectangular};

template <class M>
class RemapTableOfModel : public testing::Test {};
TYPED_TEST_SUITE(RemapTableOfModel, AllModelTypes, ModelName);

TYPED_TEST(RemapTableOfModel, AgreesWithTheProjectionOfEveryRay) {
  std::size_t num_views = 0;
  for (const auto& params : ModelFixture<TypeParam>::paramSets()) {
    const AnyCamera camera{Camera<TypeParam>(params)};
    for (const ViewProjection projection : kProjections) {
      // Far more than the camera sees.
      const OutputView view{
          .projection = projection, .size = {211, 137}, .scale_px = {25, 25}, .axis_px = {103.3, 60.8}};
      const RemapTable table = makeRemapTable(camera, kTestImage, view, 2);
      ASSERT_EQ(table.pixels.size(), 211u * 137u);
      double worst = 0;
      std::size_t num_without = 0;
      std::size_t num_wrong = 0;
      for (int y = 0; y < 137; ++y) {
        for (int x = 0; x < 211; ++x) {
          const auto ray = view.rayFromPixel({x, y});
          const Projection source = ray ? camera.project(*ray) : Projection{};
          const bool is_inside = source.ok() && source.pixel.minCoeff() >= -0.5 &&
                                 source.pixel.x() < kTestImage.width - 0.5 &&
                                 source.pixel.y() < kTestImage.height - 0.5;
          const SourcePixel& found = table.at(x, y);
          num_wrong += found.exists() == is_inside ? 0 : 1;
          num_without += is_inside ? 0 : 1;
          if (!found.exists() || !is_inside) continue;
          worst =
              std::max({worst, std::abs(found.x - source.pixel.x()), std::abs(found.y - source.pixel.y())});
        }
      }
      EXPECT_EQ(num_wrong, 0u) << projectionName(projection);
      EXPECT_EQ(table.num_without_source, num_without);
      EXPECT_LT(num_without, table.pixels.size());
      EXPECT_LT(worst, 1e-3) << projectionName(projection);
      ++num_views;
    }
  }
  EXPECT_EQ(num_views, 3 * ModelFixture<TypeParam>::paramSets().size());
}

TEST(RemapTable, ShowsNothingBeyondAFold) {
  // Folds 41 degrees off the axis; beyond it the bare formula comes back into the image.
  const std::vector<double> params = {300, 300, 319.5, 239.5, -0.45, 0, 0, 0, 0};
  const AnyCamera camera = AnyCamera::make("radtan", params);
  ASSERT_TRUE(camera.cone().is_limited_by_fold);
  const OutputView view{.size = {641, 481}, .scale_px = {100, 100}, .axis_px = {320, 240}};
  const RemapTable table = makeRemapTable(camera, kSize, view);
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
  const OutputView view = chooseView(camera, kSize, {.extent = ViewExtent::kAll, .size = {}}).view;
  const RemapTable one = makeRemapTable(camera, kSize, view, 1);
  const RemapTable three = makeRemapTable(camera, kSize, view, 3);
  const auto same = [](const SourcePixel& a, const SourcePixel& b) {
    return a.exists() == b.exists() && (!a.exists() || (a.x == b.x && a.y == b.y));
  };
  EXPECT_TRUE(
      std::equal(one.pixels.begin(), one.pixels.end(), three.pixels.begin(), three.pixels.end(), same));
  EXPECT_GT(one.num_without_source, 0u);
  EXPECT_EQ(one.num_without_source, three.num_without_source);
  const CancelFlag cancel{true};
  EXPECT_THROW((void)makeRemapTable(camera, kSize, view, 1, &cancel), Cancelled);
}

}  // namespace
}  // namespace alidade
