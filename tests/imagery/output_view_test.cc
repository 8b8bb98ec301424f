// SPDX-License-Identifier: MIT
#include "alidade/imagery/output_view.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "alidade/core/error.h"
#include "support/model_fixture.h"
#include "support/pixel_from_ray.h"

namespace alidade {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr std::array kProjections = {ViewProjection::kRectilinear, ViewProjection::kCylindrical,
                                     ViewProjection::kEquirectangular};

OutputView viewOf(ViewProjection projection) {
  return {.projection = projection, .size = {640, 480}, .scale_px = {150, 150}, .axis_px = {300.25, 250.5}};
}

TEST(OutputView, NamesProjections) {
  int num_names = 0;
  for (const ViewProjection projection : kProjections) {
    EXPECT_EQ(projectionOf(projectionName(projection)), projection);
    EXPECT_EQ(projectionNames()[static_cast<std::size_t>(num_names)], projectionName(projection));
    ++num_names;
  }
  EXPECT_EQ(num_names, 3);
  try {
    (void)projectionOf("rectilinar");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean 'rectilinear'?"));
  }
}

TEST(OutputView, TurnsPixelsIntoRaysAndBack) {
  int num_checked = 0;
  for (const ViewProjection projection : kProjections) {
    const OutputView view = viewOf(projection);
    for (int y = 20; y < 480; y += 37) {
      for (int x = 3; x < 640; x += 41) {
        const Vector2d pixel(x, y);
        const auto ray = view.rayFromPixel(pixel);
        ASSERT_TRUE(ray) << x << " " << y;
        const auto back = pixelFromRay(view, 3.5 * *ray);
        ASSERT_TRUE(back);
        EXPECT_LT((*back - pixel).norm(), 1e-10);
        ++num_checked;
      }
    }
    EXPECT_LT((*pixelFromRay(view, Vector3d::UnitZ()) - view.axis_px).norm(), 1e-12);
  }
  EXPECT_EQ(num_checked, 3 * 13 * 16);
}

TEST(OutputView, MeasuresAnglesAlongTheHorizon) {
  for (const ViewProjection projection : {ViewProjection::kCylindrical, ViewProjection::kEquirectangular}) {
    const OutputView view = viewOf(projection);
    for (const double angle : {-2.5, -1.0, 0.3, 2.0}) {
      const auto pixel = pixelFromRay(view, Eigen::Vector3d{std::sin(angle), 0, std::cos(angle)});
      ASSERT_TRUE(pixel);
      EXPECT_NEAR(pixel->x(), 300.25 + 150 * angle, 1e-9);
      EXPECT_NEAR(pixel->y(), 250.5, 1e-9);
    }
  }
}

TEST(OutputView, ShowsNothingTwice) {
  const Vector2d axis = viewOf(ViewProjection::kCylindrical).axis_px;
  for (const ViewProjection projection : {ViewProjection::kCylindrical, ViewProjection::kEquirectangular}) {
    const OutputView view = viewOf(projection);
    EXPECT_TRUE(view.rayFromPixel(axis + Vector2d(150 * (pi - 1e-6), 0)));
    EXPECT_FALSE(view.rayFromPixel(axis + Vector2d(150 * (pi + 1e-6), 0)));
    EXPECT_FALSE(view.rayFromPixel(axis - Vector2d(150 * (pi + 1e-6), 0)));
  }
  const OutputView sphere = viewOf(ViewProjection::kEquirectangular);
  EXPECT_TRUE(sphere.rayFromPixel(axis + Vector2d(0, 150 * (pi / 2 - 1e-6))));
  EXPECT_FALSE(sphere.rayFromPixel(axis + Vector2d(0, 150 * (pi / 2 + 1e-6))));
}

TEST(OutputView, HasNoPlaceForWhatItCannotShow) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(pixelFromRay(viewOf(ViewProjection::kRectilinear), Eigen::Vector3d{1, 0, 0}));
  EXPECT_FALSE(pixelFromRay(viewOf(ViewProjection::kRectilinear), Eigen::Vector3d{0, 0, -1}));
  EXPECT_FALSE(pixelFromRay(viewOf(ViewProjection::kCylindrical), Eigen::Vector3d{0, 1, 0}));
  EXPECT_TRUE(pixelFromRay(viewOf(ViewProjection::kEquirectangular), Eigen::Vector3d{0, 1, 0}));
  int num_checked = 0;
  for (const ViewProjection projection : kProjections) {
    EXPECT_FALSE(pixelFromRay(viewOf(projection), Eigen::Vector3d{0, 0, 0}));
    EXPECT_FALSE(pixelFromRay(viewOf(projection), Eigen::Vector3d{nan, 0, 1}));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

// Points along a line of the camera frame.
std::vector<Vector2d> lineOf(const OutputView& view, const Vector3d& from, const Vector3d& to) {
  std::vector<Vector2d> pixels;
  for (int i = 0; i <= 10; ++i) pixels.push_back(*pixelFromRay(view, from + 0.1 * i * (to - from)));
  return pixels;
}

double distanceFromChord(const std::vector<Vector2d>& pixels) {
  const Vector2d along = (pixels.back() - pixels.front()).normalized();
  double worst = 0;
  for (const Vector2d& pixel : pixels) {
    const Vector2d d = pixel - pixels.front();
    worst = std::max(worst, std::abs(d.x() * along.y() - d.y() * along.x()));
  }
  return worst;
}

TEST(OutputView, KeepsTheLinesStraightThatItSaysItDoes) {
  const Vector3d left(-0.8, -0.5, 1);
  const Vector3d right(0.9, -0.4, 1.2);
  const Vector3d below(-0.8, 0.7, 1);
  EXPECT_LT(distanceFromChord(lineOf(viewOf(ViewProjection::kRectilinear), left, right)), 1e-9);
  EXPECT_LT(distanceFromChord(lineOf(viewOf(ViewProjection::kRectilinear), left, below)), 1e-9);
  EXPECT_LT(distanceFromChord(lineOf(viewOf(ViewProjection::kCylindrical), left, below)), 1e-9);
  EXPECT_LT(distanceFromChord(lineOf(viewOf(ViewProjection::kEquirectangular), left, below)), 1e-9);
  // Horizontal ones bend, away from the horizon.
  EXPECT_GT(distanceFromChord(lineOf(viewOf(ViewProjection::kCylindrical), left, right)), 5);
  EXPECT_GT(distanceFromChord(lineOf(viewOf(ViewProjection::kEquirectangular), left, right)), 5);
}

TEST(OutputView, MeasuresItsField) {
  OutputView view{.size = {640, 480}, .scale_px = {320, 320}, .axis_px = {319.5, 239.5}};
  EXPECT_NEAR(view.horizontalFieldRad(), pi / 2, 1e-12);
  view.projection = ViewProjection::kCylindrical;
  EXPECT_NEAR(view.horizontalFieldRad(), 2, 1e-12);
  view.scale_px = {64, 64};
  EXPECT_NEAR(view.horizontalFieldRad(), 2 * pi, 1e-12) << "columns beyond half a turn show nothing";
}

}  // namespace
}  // namespace alidade
