// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/edge_model.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "alidade/core/random.h"
#include "alidade/detect/corner/edge_fit.h"

namespace alidade {
namespace {

EdgeModel someModel() {
  EdgeModel model;
  model.values = {0.3, -0.4, 0.2, 1.9, 0.004, -0.003, 1.1, 1.6, 120, -70, 6, 0.002, -0.003};
  return model;
}

// The model of edge_model.h word by word, in double precision.
double greyLevel(const EdgeModel& m, double x, double y) {
  double pattern = 1;
  for (std::size_t line = 0; line < 2; ++line) {
    const Eigen::Vector2d off = Eigen::Vector2d(x, y) - m.corner();
    const double u = off.dot(m.direction(line));
    const double distance = off.dot(m.normal(line)) - 0.5 * m[EdgeModel::kCurvature1 + line] * u * u;
    pattern *= std::erf(distance / (std::numbers::sqrt2 * m[EdgeModel::kBlur1 + line]));
  }
  const double shade = 1 + m[EdgeModel::kShadeX] * x + m[EdgeModel::kShadeY] * y;
  return shade * (m[EdgeModel::kMean] + m[EdgeModel::kAmplitude] * pattern +
                  m[EdgeModel::kTone] * (1 - pattern * pattern));
}

EdgePixels somePixels(int count) {
  EdgePixels pixels;
  Random random(1);
  for (int i = 0; i < count; ++i) {
    pixels.push(static_cast<float>(random.uniform(-15, 15)), static_cast<float>(random.uniform(-15, 15)),
                static_cast<float>(random.uniform(0, 255)));
  }
  return pixels;
}

TEST(EdgeKernel, SumsTheModelsResidualsAndDerivatives) {
  int num_checked = 0;
  for (const int count : {1, 7, 8, 9, 127, 128, 129, 1000, 3000}) {  // about the sizes of vectors and chunks
    const EdgePixels pixels = somePixels(count);
    const EdgeModel model = someModel();
    EdgeSums sums;
    sumNormalEquations(pixels, model, sums);
    EdgeSums expected;
    expected.hessian.setZero();
    expected.gradient.setZero();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const double x = pixels.x()[i];
      const double y = pixels.y()[i];
      Eigen::Matrix<double, EdgeModel::kNumParameters, 1> derivative;
      for (int p = 0; p < derivative.size(); ++p) {
        constexpr double kStep = 1e-5;
        EdgeModel above = model;
        EdgeModel below = model;
        above[static_cast<std::size_t>(p)] += kStep;
        below[static_cast<std::size_t>(p)] -= kStep;
        derivative(p) = (greyLevel(above, x, y) - greyLevel(below, x, y)) / (2 * kStep);
      }
      const double residual = pixels.grey()[i] - greyLevel(model, x, y);
      expected.hessian += derivative * derivative.transpose();
      expected.gradient += derivative * residual;
      expected.cost += residual * residual;
    }
    EXPECT_NEAR(sums.cost, expected.cost, 1e-5 * expected.cost);
    for (int i = 0; i < sums.gradient.size(); ++i) {
      const double scale = std::sqrt(expected.hessian(i, i));
      EXPECT_NEAR(sums.gradient(i), expected.gradient(i), 1e-4 * scale * std::sqrt(expected.cost) + 1e-4);
      for (int j = 0; j < sums.gradient.size(); ++j) {
        const double scales = scale * std::sqrt(expected.hessian(j, j));
        EXPECT_NEAR(sums.hessian(i, j), expected.hessian(i, j), 1e-4 * scales + 1e-3) << i << " " << j;
      }
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 9);
}

TEST(EdgeKernel, EvaluatesEachPixel) {
  const EdgePixels pixels = somePixels(133);
  const EdgeModel model = someModel();
  EdgeResiduals residuals;
  evaluateResiduals(pixels, model, residuals);
  int num_checked = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_NEAR(residuals.residual[i], pixels.grey()[i] - greyLevel(model, pixels.x()[i], pixels.y()[i]),
                1e-3);
    EXPECT_LE(std::abs(residuals.pattern[i]), 1.000001);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 133);
}

// A start sharper than the bound fits sharpened images better than any model within the bounds.
TEST(EdgeFit, FindsTheSameFromBlursBeyondItsBounds) {
  EdgeModel truth = someModel();
  truth[EdgeModel::kBlur1] = truth[EdgeModel::kBlur2] = 0.05;
  EdgePixels pixels;
  for (int y = -12; y <= 12; ++y) {
    for (int x = -12; x <= 12; ++x) {
      pixels.push(static_cast<float>(x), static_cast<float>(y), static_cast<float>(greyLevel(truth, x, y)));
    }
  }
  const EdgeSolverOptions options{.min_blur_px = 0.4, .max_blur_px = 2};
  const auto solveFrom = [&](double blur) {
    EdgeModel start = truth;
    start[EdgeModel::kX] += 0.15;
    start[EdgeModel::kY] -= 0.1;
    start[EdgeModel::kBlur1] = start[EdgeModel::kBlur2] = blur;
    return solveEdgeModel(pixels, start, {}, options);
  };
  const EdgeSolution within = solveFrom(0.4);
  EXPECT_TRUE(within.converged);
  int num_checked = 0;
  for (const double blur : {0.1, 0.2, 0.3, 1.0, 5.0}) {
    const EdgeSolution solution = solveFrom(blur);
    EXPECT_TRUE(solution.converged) << blur;
    EXPECT_LT((solution.model.corner() - within.model.corner()).norm(), 0.01) << blur;
    EXPECT_GE(solution.model[EdgeModel::kBlur1], options.min_blur_px) << blur;
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 5);
}

}  // namespace
}  // namespace alidade
