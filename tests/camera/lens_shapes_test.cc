// SPDX-License-Identifier: MIT
#include "alidade/camera/lens_shapes.h"
#include "alidade/camera/same_lens.h"

#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

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

TEST(AxisFocal, HasTheDerivativesOfItsDifferences) {
  const AnyCamera fisheye =
      AnyCamera::make("kannala_brandt", std::vector<double>{230, 231, 322, 236, 0.02, -0.004, 0.001, 0});
  int num_checked = 0;
  for (const char* model :
       {"pinhole", "radtan", "kannala_brandt", "fov", "ucm", "omni", "eucm", "double_sphere"}) {
    const std::vector<double> params = lensShapes(model, fisheye, grid()).front().params;
    const Eigen::MatrixXd J = axisFocalJacobian(AnyCamera::make(model, params));
    ASSERT_EQ(J.cols(), static_cast<Eigen::Index>(params.size()));
    for (std::size_t i = 0; i < params.size(); ++i) {
      constexpr double kStep = 1e-5;
      const auto at = [&](double step) {
        std::vector<double> moved = params;
        moved[i] += step;
        return axisFocal(AnyCamera::make(model, moved));
      };
      const Eigen::Vector2d expected = (at(kStep) - at(-kStep)) / (2 * kStep);
      EXPECT_LE((J.col(static_cast<Eigen::Index>(i)) - expected).norm(), 1e-4 * (1 + expected.norm()))
          << model << i;
      ++num_checked;
    }
  }
  EXPECT_EQ(num_checked, 4 + 9 + 8 + 5 + 5 + 9 + 6 + 6);
}

}  // namespace
}  // namespace alidade
