// SPDX-License-Identifier: MIT
#include "alidade/init/lens_shapes.h"

#include <vector>

#include <gtest/gtest.h>

namespace alidade {
namespace {

std::vector<Eigen::Vector2d> grid() {
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 60; y < 480; y += 90) {
    for (int x = 40; x < 640; x += 80) pixels.emplace_back(x, y);
  }
  return pixels;
}

TEST(LensShapes, TheFirstLooksLikeTheGivenCamera) {
  const AnyCamera fisheye =
      AnyCamera::make("kannala_brandt", std::vector<double>{230, 231, 322, 236, 0.02, -0.004, 0.001, 0});
  int num_models = 0;
  for (const char* model : {"ucm", "eucm", "double_sphere", "omni"}) {
    const auto shapes = lensShapes(model, fisheye, grid());
    ASSERT_FALSE(shapes.empty()) << model;
    const AnyCamera camera = AnyCamera::make(model, shapes.front().params);
    for (const Eigen::Vector2d& pixel : grid()) {
      const Projection p = camera.project(*fisheye.unproject(pixel));
      ASSERT_TRUE(p.ok()) << model;
      EXPECT_LE((p.pixel - pixel).norm(), 3.0) << model;
    }
    ++num_models;
  }
  EXPECT_EQ(num_models, 4);
}

TEST(LensShapes, OthersDifferInTheParameterThatMakesTheShape) {
  const AnyCamera fisheye =
      AnyCamera::make("kannala_brandt", std::vector<double>{230, 231, 322, 236, 0, 0, 0, 0});
  const auto shapes = lensShapes("double_sphere", fisheye, grid());
  ASSERT_GE(shapes.size(), 3U);
  EXPECT_FALSE(shapes[0].character);
  for (std::size_t i = 1; i < shapes.size(); ++i) {
    ASSERT_EQ(shapes[i].character, 4);
    EXPECT_GE(std::abs(shapes[i].params[4] - shapes[0].params[4]), 0.07);
    EXPECT_NO_THROW(static_cast<void>(AnyCamera::make("double_sphere", shapes[i].params)));
  }
  EXPECT_EQ(lensShapes("ucm", fisheye, grid()).size(), 1U) << "a shape alone has one best value";
}

TEST(LensShapes, QuotientsOfPolynomialsStartWithAndWithoutADenominator) {
  const AnyCamera plain =
      AnyCamera::make("radtan", std::vector<double>{500, 501, 320, 240, -0.2, 0.05, 1e-3, -1e-3, 0.01});
  const auto shapes = lensShapes("rational", plain, grid());
  ASSERT_EQ(shapes.size(), 4U);
  int num_checked = 0;
  for (const LensShape& shape : shapes) {
    const AnyCamera camera = AnyCamera::make("rational", shape.params);
    for (const Eigen::Vector2d& pixel : grid()) {
      EXPECT_LE((camera.project(*plain.unproject(pixel)).pixel - pixel).norm(), 0.5);
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4 * 40);
  EXPECT_EQ(shapes[0].params[9], 0.0);
  EXPECT_NE(shapes[1].params[9], 0.0);
}

TEST(ParametersByName, KeepsWhatBothModelsHave) {
  const AnyCamera plain = AnyCamera::make("pinhole", std::vector<double>{500, 501, 320, 240});
  EXPECT_EQ(parametersByName(plain.modelId(), plain.parameters(), "ucm"),
            (std::vector<double>{500, 501, 320, 240, 0}));
}

}  // namespace
}  // namespace alidade
