// SPDX-License-Identifier: MIT
#include "alidade/camera/any_camera.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

#include "alidade/camera/batch.h"
#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"

namespace alidade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string messageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(AnyCamera, ListsModelsAndParameterNames) {
  EXPECT_THAT(modelIds(), ElementsAre("pinhole", "radtan", "brown", "inverse_brown", "rational", "thin_prism",
                                      "tilted", "division", "kannala_brandt", "kannala_brandt_skew",
                                      "thin_prism_fisheye", "fisheye624", "ftheta", "ftheta_inverse", "ocam",
                                      "fov", "ucm", "omni", "eucm", "double_sphere"));
  EXPECT_THAT(parameterNames("pinhole"), ElementsAre("fx", "fy", "cx", "cy"));
  EXPECT_THAT(parameterNames("radtan"), ElementsAre("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"));
}

TEST(AnyCamera, RefusesUnknownModelsWithTheNearestName) {
  const std::string message =
      messageOf([] { static_cast<void>(AnyCamera::make("radtn", std::vector<double>{})); });
  EXPECT_THAT(message, HasSubstr("'radtn'"));
  EXPECT_THAT(message, HasSubstr("pinhole, radtan, brown"));
  EXPECT_THAT(message, HasSubstr("did you mean 'radtan'?"));
}

TEST(AnyCamera, RefusesParametersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](std::vector<double> params) {
    return messageOf([&] { static_cast<void>(AnyCamera::make("pinhole", params)); });
  };
  EXPECT_THAT(message({500, 500, 320}), HasSubstr("3 numbers; expected 4"));
  EXPECT_THAT(message({500, nan, 320, 240}), HasSubstr("parameter fy: nan"));
  EXPECT_THAT(message({-500, 500, 320, 240}), HasSubstr("parameter fx: -500; expected a positive"));
  EXPECT_THAT(message({500, 500, 320, std::numeric_limits<double>::infinity()}), HasSubstr("parameter cy"));
  EXPECT_EQ(message({500, 500, 320, 240}), "no error");
}

TEST(AnyCamera, IsMadeFromParametersByName) {
  std::map<std::string, double> params = {{"cy", 240}, {"fx", 500}, {"alpha", 0.6}, {"fy", 510}, {"cx", 320}};
  const AnyCamera camera = AnyCamera::make("ucm", params);
  EXPECT_THAT(camera.parameters(), ElementsAre(500, 510, 320, 240, 0.6));
  EXPECT_EQ(camera.parameter("alpha"), 0.6);
  EXPECT_THAT(messageOf([&] { static_cast<void>(camera.parameter("beta")); }),
              HasSubstr("parameters of model ucm: unknown name 'beta'; expected fx, fy, cx, cy, alpha"));
  params["beta"] = 1;
  const auto make = [&] { static_cast<void>(AnyCamera::make("ucm", params)); };
  EXPECT_THAT(messageOf(make), HasSubstr("unknown name 'beta'"));
  params.erase("fy");
  EXPECT_THAT(messageOf(make), HasSubstr("parameters of model ucm: no fy; expected fx, fy, cx, cy, alpha"));
}

TEST(AnyCamera, NamesTheStatusOfAProjection) {
  const AnyCamera camera = AnyCamera::make("pinhole", std::vector<double>{500, 500, 320, 240});
  EXPECT_EQ(statusId(camera.project({0, 0, 1}).status), "ok");
  EXPECT_EQ(statusId(camera.project({0, 0, -1}).status), "behind");
  EXPECT_EQ(statusId(camera.project({0, 0, 0}).status), "outside");
}

TEST(AnyCamera, RefusesLensParametersOutOfRange) {
  const auto message = [](const char* model, std::vector<double> params) {
    return messageOf([&] { static_cast<void>(AnyCamera::make(model, params)); });
  };
  EXPECT_THAT(message("ucm", {500, 500, 320, 240, 1.1}),
              HasSubstr("parameter alpha: 1.1; expected a number from 0 to 1"));
  EXPECT_THAT(message("eucm", {500, 500, 320, 240, 0.5, -1}),
              HasSubstr("parameter beta: -1; expected a number of at least"));
  EXPECT_THAT(message("double_sphere", {500, 500, 320, 240, -1, 0.5}), HasSubstr("parameter xi: -1"));
  EXPECT_THAT(message("fov", {500, 500, 320, 240, 3.2}), HasSubstr("parameter w: 3.2"));
  EXPECT_THAT(message("omni", {500, 500, 320, 240, -0.1, 0, 0, 0, 0}), HasSubstr("parameter xi: -0.1"));
  EXPECT_EQ(message("ucm", {500, 500, 320, 240, 1}), "no error");
}

TEST(AnyCamera, BatchEqualsOneByOne) {
  const std::vector<double> params = {500, 510, 320, 240, -0.2, 0, 1e-3, -1e-3, 0};
  const AnyCamera camera = AnyCamera::make("radtan", params);
  const std::vector<Eigen::Vector3d> points = {{0, 0, 1}, {0.3, -0.2, 1}, {0, 0, -1}, {50, 0, 1}};
  std::vector<Projection> batch(points.size());
  projectBatch(camera, points, batch);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Projection single = camera.project(points[i]);
    EXPECT_EQ(batch[i].status, single.status);
    if (single.ok()) {
      EXPECT_LT((batch[i].pixel - single.pixel).norm(), 1e-9);
    }
  }
  EXPECT_EQ(batch[2].status, ProjectStatus::kBehind);
  EXPECT_EQ(batch[3].status, ProjectStatus::kOutsideDomain);
}

TEST(AnyCamera, StartsUndistortedAtTheImagesMiddle) {
  EXPECT_THAT(startParameters("radtan", 700, {.width = 640, .height = 480}),
              ElementsAre(700, 700, 319.5, 239.5, 0, 0, 0, 0, 0));
}

// The focal length asked for is that of the axis, whatever scale a model's formula has.
TEST(AnyCamera, StartsHaveTheFocalLengthAskedFor) {
  int num_checked = 0;
  for (const std::string& id : modelIds()) {
    const AnyCamera camera = AnyCamera::make(id, startParameters(id, 700, {.width = 640, .height = 480}));
    const Projection projection = camera.project({1e-4, -1e-4, 1});
    ASSERT_TRUE(projection.ok()) << id;
    EXPECT_NEAR(projection.pixel.x(), 319.5 + 0.07, 1e-8) << id;
    EXPECT_NEAR(projection.pixel.y(), 239.5 - 0.07, 1e-8) << id;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 20);
}

TEST(SelfCheck, PointsProjectToTheirPixelsAllOverTheImage) {
  const ImageSize size{.width = 640, .height = 480};
  const std::vector<double> params = {500, 510, 320, 240, -0.2, 0.05, 1e-3, -1e-3, 0};
  const AnyCamera camera = AnyCamera::make("radtan", params);
  const std::vector<SelfCheckPoint> points = makeSelfCheck(camera, size);
  ASSERT_EQ(points.size(), 9U);
  for (const SelfCheckPoint& point : points) EXPECT_EQ(camera.project(point.point).pixel, point.pixel);
  EXPECT_LT(points.front().pixel.norm(), 30);
  EXPECT_LT((points.back().pixel - Eigen::Vector2d(640, 480)).norm(), 30);
}

// A tenth of a millimetre, to which the points are rounded, is many pixels of a long lens.
TEST(SelfCheck, HoldsForAnyFocalLength) {
  int num_checked = 0;
  for (const double f_over_width : {0.1, 0.3, 1.0, 10.0, 100.0, 300.0, 1e3, 1e4}) {
    for (const double shift : {0.0, 0.1376, 0.4121}) {
      const ImageSize size{.width = 200, .height = 150};
      const double f = f_over_width * size.width;
      const AnyCamera camera =
          AnyCamera::make("pinhole", std::vector<double>{f, f, 99.5 + shift, 74.5 - 2 * shift});
      const std::vector<SelfCheckPoint> points = makeSelfCheck(camera, size);
      EXPECT_EQ(points.size(), 9U);
      EXPECT_TRUE(runSelfCheck(camera, size, points).isPassed()) << f_over_width << " " << shift;
      for (const SelfCheckPoint& point : points) {
        EXPECT_GT(point.pixel.minCoeff(), 0) << f_over_width;
        EXPECT_LT(point.pixel.x(), size.width - 1) << f_over_width;
        EXPECT_LT(point.pixel.y(), size.height - 1) << f_over_width;
      }
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 24);
}

// What earlier versions wrote: f = 58011 px, rounded to a tenth of a millimetre.
TEST(SelfCheck, LetsPassWhatRoundingOnceMovedOutOfTheImage) {
  const ImageSize size{.width = 200, .height = 150};
  const AnyCamera camera =
      AnyCamera::make("pinhole", std::vector<double>{58011, 58011, 101.31366278095172, 76.48743672414555});
  const Eigen::Vector3d point(-0.0013, -0.0010, 0.75);
  const Eigen::Vector2d pixel = camera.project(point).pixel;
  ASSERT_LT(pixel.y(), -0.5);
  const std::vector<SelfCheckPoint> points = {{point, pixel}};
  EXPECT_TRUE(runSelfCheck(camera, size, points).isPassed());
  const std::vector<SelfCheckPoint> other_size = {{{0.002, 0, 0.75}, camera.project({0.002, 0, 0.75}).pixel}};
  EXPECT_FALSE(runSelfCheck(camera, size, other_size).isPassed());
}

}  // namespace
}  // namespace alidade
