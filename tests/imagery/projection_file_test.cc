// SPDX-License-Identifier: MIT
#include "alidade/imagery/projection_file.h"

#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

#include <stdexcept>
#include <vector>

namespace alidade {
namespace {

OutputView someView(ViewProjection projection) {
  return {.projection = projection,
          .size = {640, 480},
          .scale_px = Eigen::Vector2d::Constant(501.23 / 3),
          .axis_px = {319.25, 240.1}};
}

TEST(ProjectionFile, SaysAllOfTheView) {
  int num_checked = 0;
  for (const ViewProjection projection : {ViewProjection::kCylindrical, ViewProjection::kEquirectangular}) {
    const OutputView view = someView(projection);
    const YAML::Node root = YAML::Load(projectionFileText(view, "test"));
    EXPECT_EQ(root["alidade_projection"].as<int>(), 1);
    EXPECT_EQ(root["projection"].as<std::string>(), projectionName(projection));
    EXPECT_EQ(root["image_size"]["width"].as<int>(), 640);
    EXPECT_EQ(root["image_size"]["height"].as<int>(), 480);
    EXPECT_EQ(root["axis_pixel"]["u"].as<double>(), 319.25);
    EXPECT_EQ(root["axis_pixel"]["v"].as<double>(), 240.1);
    EXPECT_EQ(root["created_by"].as<std::string>(), "test");
    OutputView read = view;
    read.scale_px.setConstant(1 / root["radians_per_pixel"].as<double>());
    EXPECT_NEAR(read.scale_px.x(), view.scale_px.x(), 1e-12 * view.scale_px.x());
    ASSERT_EQ(root["self_check"].size(), 9u);
    for (const YAML::Node& check : root["self_check"]) {
      const auto pixel = check["pixel"].as<std::vector<double>>();
      const auto ray = check["ray"].as<std::vector<double>>();
      const Eigen::Vector3d expected = read.rayFromPixel({pixel[0], pixel[1]})->normalized();
      EXPECT_LT((expected - Eigen::Vector3d(ray[0], ray[1], ray[2])).norm(), 1e-15);
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 2);
  EXPECT_THROW((void)projectionFileText(someView(ViewProjection::kRectilinear), "test"), std::logic_error);
}

}  // namespace
}  // namespace alidade
