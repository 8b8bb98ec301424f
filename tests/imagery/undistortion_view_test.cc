// SPDX-License-Identifier: MIT
#include "alidade/imagery/undistortion_view.h"
#include "alidade/camera/lens_shapes.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/core/random.h"
#include "alidade/imagery/remap.h"
#include "support/cameras_of_model.h"
#include "support/image_sizes.h"
#include "support/pixel_from_ray.h"
#include "support/rays.h"

namespace alidade {
namespace {

using testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;
constexpr ImageSize kOutput{160, 100};  // of the tests over all models
constexpr std::array kProjections = {ViewProjection::kRectilinear, ViewProjection::kCylindrical,
                                     ViewProjection::kEquirectangular};

AnyCamera lens() {
  return AnyCamera::make("radtan", std::vector<double>{533, 535, 342, 234, -0.28, 0.08, 1e-3, -5e-4, 0});
}

ViewChoice choose(const AnyCamera& camera, ImageSize size, ViewExtent extent,
                  ViewProjection projection = ViewProjection::kRectilinear,
                  std::optional<ImageSize> output = {}) {
  return chooseView(
      camera, size,
      {.projection = projection, .extent = extent, .horizontal_field_rad = 90 * kDegree, .size = output});
}

TEST(UndistortionView, KeepsFocalLengthAxisAndSize) {
  const OutputView view = choose(lens(), kVga, ViewExtent::kSameScale).view;
  EXPECT_EQ(view.size, kVga);
  EXPECT_EQ(view.scale_px, Eigen::Vector2d(533, 535));
  EXPECT_EQ(view.axis_px, Eigen::Vector2d(342, 234));
  const AnyCamera pinhole = pinholeOf(view);
  EXPECT_EQ(pinhole.modelId(), "pinhole");
  EXPECT_THAT(std::vector<double>(pinhole.parameters().begin(), pinhole.parameters().end()),
              testing::ElementsAre(533, 535, 342, 234));
}

TEST(UndistortionView, KeepsTheFieldInAnotherSize) {
  const OutputView view =
      choose(lens(), kVga, ViewExtent::kSameScale, ViewProjection::kRectilinear, ImageSize{1280, 900}).view;
  EXPECT_EQ(view.size, (ImageSize{1280, 900}));
  EXPECT_NEAR(view.scale_px.x(), 2 * 533, 1e-9);
  EXPECT_NEAR(view.axis_px.x(), 2 * 342.5 - 0.5, 1e-9);
  EXPECT_NEAR(view.axis_px.y(), 2 * 234.5 - 0.5 - 30, 1e-9) << "60 rows less, half of them above";
}

TEST(UndistortionView, HasSquarePixelsWhereAnglesAreShown) {
  const OutputView view = choose(lens(), kVga, ViewExtent::kSameScale, ViewProjection::kEquirectangular).view;
  EXPECT_NEAR(view.scale_px.x(), std::sqrt(533.0 * 535.0), 1e-9);
  EXPECT_EQ(view.scale_px.x(), view.scale_px.y());
}

TEST(UndistortionView, ShowsTheFieldThatIsAskedFor) {
  int num_checked = 0;
  for (const ViewProjection projection : kProjections) {
    const OutputView view = choose(lens(), kVga, ViewExtent::kFieldOfView, projection).view;
    EXPECT_NEAR(view.horizontalFieldRad(), 90 * kDegree, 1e-12);
    EXPECT_EQ(view.axis_px, Eigen::Vector2d(319.5, 239.5));
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 3);
}

std::string complaint(const ViewRequest& request, const AnyCamera& camera = lens()) {
  try {
    (void)chooseView(camera, kVga, request);
  } catch (const Error& error) {
    return std::to_string(static_cast<int>(error.code())) + ": " + error.what();
  }
  return "none";
}

TEST(UndistortionView, RefusesWhatItCannotShow) {
  ViewRequest request{.extent = ViewExtent::kFieldOfView, .size = {}};
  int num_refused = 0;
  for (const double degrees : {0.0, -10.0, 150.1, 180.0, std::nan("")}) {
    request.horizontal_field_rad = degrees * kDegree;
    EXPECT_THAT(complaint(request), AllOf(HasSubstr("2: "), HasSubstr("at most 150 degrees")));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 5);
  request.horizontal_field_rad = 150 * kDegree;
  EXPECT_EQ(complaint(request), "none");
  request.projection = ViewProjection::kEquirectangular;
  request.horizontal_field_rad = 361 * kDegree;
  EXPECT_THAT(complaint(request), HasSubstr("at most 360 degrees"));
  request.horizontal_field_rad = 360 * kDegree;
  EXPECT_EQ(complaint(request), "none");
  for (const ImageSize size :
       {ImageSize{1, 100}, ImageSize{100, 0}, ImageSize{32767, 100}, ImageSize{30000, 30000}}) {
    request.size = size;
    EXPECT_THAT(complaint(request), AllOf(HasSubstr("2: "), HasSubstr("output size")));
    ++num_refused;
  }
  EXPECT_EQ(num_refused, 9);
  EXPECT_THROW((void)chooseView(lens(), {40000, 100}, {.size = ImageSize{100, 100}}), Error)
      << "more than OpenCV takes";
  const auto lookingAside = [](double cx) {
    return AnyCamera::make("pinhole", std::vector<double>{500, 500, cx, 240});
  };
  EXPECT_THAT(complaint({.extent = ViewExtent::kValid, .size = {}}, lookingAside(-2000)),
              AllOf(HasSubstr("1: "), HasSubstr("no ray in the middle of the image")));
  for (const ViewExtent extent : {ViewExtent::kAll, ViewExtent::kValid})
    EXPECT_EQ(complaint({.extent = extent, .size = {}}, lookingAside(-100)), "none");
}

TEST(UndistortionView, AllOfAPinholeCameraIsThePinholeCamera) {
  const AnyCamera pinhole = AnyCamera::make("pinhole", std::vector<double>{500, 500, 300, 250});
  const OutputView view = choose(pinhole, kVga, ViewExtent::kAll).view;
  EXPECT_NEAR(view.scale_px.x(), 500, 1e-5);
  EXPECT_LT((view.axis_px - Eigen::Vector2d(300, 250)).norm(), 1e-5);
}

TEST(UndistortionView, ValidOfAPinholeCameraIsThePinholeCamera) {
  int num_checked = 0;
  for (const Eigen::Vector2d& axis : {Eigen::Vector2d(300, 250), {500, 20}, {-100, 240}, {900, 700}}) {
    const AnyCamera pinhole = AnyCamera::make("pinhole", std::vector<double>{500, 500, axis.x(), axis.y()});
    const OutputView view = choose(pinhole, kVga, ViewExtent::kValid).view;
    EXPECT_NEAR(view.scale_px.x(), 500, 0.05);
    EXPECT_LT((view.axis_px - axis).norm(), 0.1);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 4);
}

// Lenses with the axis off the centre. The source of a pixel is computed here.
TEST(UndistortionView, ValidIsTheLargestWindowWhereverItsCentreIs) {
  Random random(61);
  constexpr int kNumLenses = 20;
  constexpr double kGrowth = 1.01;
  int num_checked = 0;
  for (int lens = 0; lens < kNumLenses; ++lens) {
    const double f = random.uniform(400, 1500);
    const std::vector<double> params = {f,
                                        f * random.uniform(0.99, 1.01),
                                        320 + random.uniform(-120, 120),
                                        240 + random.uniform(-90, 90),
                                        random.uniform(-0.25, 0.25),
                                        random.uniform(0, 0.1),
                                        random.uniform(-2e-3, 2e-3),
                                        random.uniform(-2e-3, 2e-3),
                                        0};
    const auto hasSource = [&](const Eigen::Vector2d& plane) {
      const double x = plane.x(), y = plane.y(), r2 = plane.squaredNorm();
      const double a = 1 + r2 * (params[4] + r2 * params[5]);
      const double u = params[0] * (x * a + 2 * params[6] * x * y + params[7] * (r2 + 2 * x * x)) + params[2];
      const double v = params[1] * (y * a + params[6] * (r2 + 2 * y * y) + 2 * params[7] * x * y) + params[3];
      return u > -1e-6 && v > -1e-6 && u < kVga.width - 1 + 1e-6 && v < kVga.height - 1 + 1e-6;
    };
    const auto numBlack = [&](double scale, const Eigen::Vector2d& axis) {
      int count = 0;
      for (int y = 0; y < kVga.height; ++y) {
        for (int x = 0; x < kVga.width; ++x) {
          const bool is_border = x == 0 || y == 0 || x + 1 == kVga.width || y + 1 == kVga.height;
          if (is_border || (x % 7 == 0 && y % 7 == 0))
            count += hasSource((Eigen::Vector2d(x, y) - axis) / scale) ? 0 : 1;
        }
      }
      return count;
    };
    const OutputView view = choose(AnyCamera::make("radtan", params), kVga, ViewExtent::kValid).view;
    ASSERT_EQ(view.scale_px.x(), view.scale_px.y());
    EXPECT_EQ(numBlack(view.scale_px.x(), view.axis_px), 0) << "lens " << lens;
    // A view that shows 1 % more on each side, moved by up to 8 pixels.
    const Eigen::Vector2d middle(0.5 * (kVga.width - 1), 0.5 * (kVga.height - 1));
    for (int dy = -8; dy <= 8; dy += 4) {
      for (int dx = -8; dx <= 8; dx += 4) {
        const Eigen::Vector2d axis = middle + (view.axis_px - middle) / kGrowth + Eigen::Vector2d(dx, dy);
        EXPECT_GT(numBlack(view.scale_px.x() / kGrowth, axis), 0)
            << "lens " << lens << ", " << dx << ", " << dy;
      }
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, kNumLenses);
}

TEST(UndistortionView, SaysWhatIsCut) {
  // 160 degrees wide: the outer 5 on both sides are too far out for a plane.
  const double focal = 0.5 * kVga.width / std::tan(80 * kDegree);
  const AnyCamera wide = AnyCamera::make("pinhole", std::vector<double>{focal, focal, 319.5, 239.5});
  const ViewChoice all = choose(wide, kVga, ViewExtent::kAll);
  EXPECT_GT(all.cut_share, 0.3);
  EXPECT_LT(all.cut_share, 0.7);
  // The image holds all rays of up to 75 degrees; the output's height is the smaller side.
  EXPECT_NEAR(all.view.scale_px.y() * std::tan(75 * kDegree), 239.5, 2);
  EXPECT_EQ(choose(wide, kVga, ViewExtent::kAll, ViewProjection::kEquirectangular).cut_share, 0);
  const ViewChoice valid = choose(wide, kVga, ViewExtent::kValid);
  EXPECT_TRUE(valid.is_limited_by_projection);
  EXPECT_FALSE(choose(lens(), kVga, ViewExtent::kValid).is_limited_by_projection);
}

class UndistortionViewOfModel : public OfModel {};
INSTANTIATE_TEST_SUITE_P(, UndistortionViewOfModel, testing::ValuesIn(modelIds()), nameOfModel);

TEST_P(UndistortionViewOfModel, ValidIsTheLargestWindowWithoutABlackPixel) {
  std::size_t num_checked = 0;
  std::size_t num_enlarged = 0;
  for (const AnyCamera& camera : cameras()) {
    for (const ViewProjection projection : kProjections) {
      const ViewChoice choice = choose(camera, kTestImage, ViewExtent::kValid, projection, kOutput);
      EXPECT_EQ(makeRemapTable(camera, kTestImage, choice.view).num_without_source, 0u)
          << projectionName(projection);
      ++num_checked;
      if (choice.is_limited_by_projection) continue;
      OutputView enlarged = choice.view;
      enlarged.scale_px /= 1.02;
      EXPECT_GT(makeRemapTable(camera, kTestImage, enlarged).num_without_source, 0u)
          << projectionName(projection);
      ++num_enlarged;
    }
  }
  EXPECT_EQ(num_checked, 3 * cameras().size());
  EXPECT_GT(num_enlarged, 0u);
}

// Rays of all pixels of the border, and of one in 361 inside.
std::vector<std::optional<Eigen::Vector3d>> raysAllOver(const AnyCamera& camera) {
  std::vector<std::optional<Eigen::Vector3d>> rays;
  const auto look = [&](int x, int y) { rays.push_back(camera.unproject({x, y})); };
  for (int x = 0; x < kTestImage.width; ++x) {
    look(x, 0);
    look(x, kTestImage.height - 1);
  }
  for (int y = 0; y < kTestImage.height; ++y) {
    look(0, y);
    look(kTestImage.width - 1, y);
    for (int x = y / 19 % 19; y % 19 == 5 && x < kTestImage.width; x += 19) look(x, y);
  }
  return rays;
}

bool isWithinKeptAngle(const OutputView& view, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d plane = view.planeFromPixel(pixel);
  if (view.projection == ViewProjection::kEquirectangular) return true;
  const double slope = view.projection == ViewProjection::kRectilinear ? plane.norm() : std::abs(plane.y());
  return std::atan(slope) <= kMaxTangentAngleRad;
}

TEST_P(UndistortionViewOfModel, AllHoldsEverySourcePixelAndHardlyMore) {
  std::size_t num_views = 0;
  std::size_t num_tight = 0;
  std::vector<AnyCamera> lenses = cameras();
  lenses.push_back(
      AnyCamera::make(GetParam(), startParameters(GetParam(), 2000, kTestImage)));  // a narrow one
  for (const AnyCamera& camera : lenses) {
    const auto rays = raysAllOver(camera);
    const bool is_all_forward =
        std::all_of(rays.begin(), rays.end(), [](const auto& ray) { return ray && ray->z() > 0; });
    for (const ViewProjection projection : kProjections) {
      const ViewChoice choice = choose(camera, kTestImage, ViewExtent::kAll, projection, kOutput);
      const OutputView& view = choice.view;
      const Eigen::Array2d last(view.size.width - 1, view.size.height - 1);
      Eigen::Array2d low = last;
      Eigen::Array2d high = Eigen::Array2d::Zero();
      std::size_t num_outside = 0;
      std::size_t num_shown = 0;
      for (const auto& ray : rays) {
        const auto pixel = ray ? pixelFromRay(view, *ray) : std::nullopt;
        if (!pixel || !isWithinKeptAngle(view, *pixel)) continue;
        low = low.min(pixel->array());
        high = high.max(pixel->array());
        const bool is_inside = (pixel->array() >= 0).all() && (pixel->array() <= last).all();
        ++(is_inside ? num_shown : num_outside);
      }
      EXPECT_EQ(num_outside, 0u) << projectionName(projection);
      EXPECT_GT(num_shown, 1000u);
      // Where all pixels have rays that go forward and none is cut, the image's border, all of which was
      // looked at, touches that of the view on both sides along one coordinate.
      if (choice.cut_share == 0 && is_all_forward) {
        EXPECT_TRUE(((low < 1e-3) && (high > last - 1e-3)).any())
            << projectionName(projection) << " " << low.transpose() << " " << high.transpose();
        ++num_tight;
      }
      ++num_views;
    }
  }
  EXPECT_EQ(num_views, 3 * lenses.size());
  EXPECT_GT(num_tight, 0u);
}

}  // namespace
}  // namespace alidade
