// SPDX-License-Identifier: MIT
#include "alidade/detect/corner/disc_model.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "alidade/core/random.h"

namespace alidade {
namespace {

DiscModel someDisc() {
  DiscModel model;
  model.values << 0.05, -0.03, 1.2, 0.3, 0.9, 0.12, 120, 70, 0.02, -0.03;
  return model;
}

// The model of disc_model.h word by word, in double precision.
double discLevel(const DiscModel& m, const Eigen::Vector2d& at) {
  const double pattern = std::erf(m.distance(at) / (std::numbers::sqrt2 * m[DiscModel::kBlur]));
  return (1 + m[DiscModel::kShadeX] * at.x() + m[DiscModel::kShadeY] * at.y()) *
         (m[DiscModel::kMean] + m[DiscModel::kAmplitude] * pattern);
}

// On the rim.
bool isWithoutEffect(Eigen::Index parameter) {
  return parameter == DiscModel::kBlur || parameter == DiscModel::kAmplitude;
}

TEST(DiscKernel, SumsTheModelsResidualsAndDerivatives) {
  const DiscModel model = someDisc();
  int num_checked = 0;
  for (const int count : {1, 8, 9, 128, 129, 1000}) {  // about the sizes of vectors and chunks
    EdgePixels pixels;
    Random random(1);
    for (int i = 0; i < count; ++i) {  // on the rim, where the derivatives of the distance are exact
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
      const Eigen::Vector2d at = model.centre() + along / std::sqrt(along.dot(model.shape() * along));
      pixels.push(static_cast<float>(at.x()), static_cast<float>(at.y()),
                  static_cast<float>(random.uniform(0, 255)));
    }
    DiscSums sums;
    sumNormalEquations(pixels, model, sums);
    DiscSums expected;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const Eigen::Vector2d at(pixels.x()[i], pixels.y()[i]);
      DiscModel::Vector derivative;
      for (Eigen::Index p = 0; p < derivative.size(); ++p) {
        constexpr double kStep = 1e-6;
        DiscModel above = model;
        DiscModel below = model;
        above.values[p] += kStep;
        below.values[p] -= kStep;
        derivative[p] = (discLevel(above, at) - discLevel(below, at)) / (2 * kStep);
      }
      const double residual = pixels.grey()[i] - discLevel(model, at);
      expected.hessian += derivative * derivative.transpose();
      expected.gradient += derivative * residual;
      expected.cost += residual * residual;
    }
    EXPECT_NEAR(sums.cost, expected.cost, 1e-5 * expected.cost);
    for (Eigen::Index i = 0; i < sums.gradient.size(); ++i) {
      if (isWithoutEffect(i)) continue;
      const double scale = std::sqrt(expected.hessian(i, i));
      EXPECT_NEAR(sums.gradient[i], expected.gradient[i], 1e-4 * scale * std::sqrt(expected.cost) + 1e-2);
      for (Eigen::Index j = 0; j < sums.gradient.size(); ++j) {
        if (isWithoutEffect(j)) continue;
        const double scales = scale * std::sqrt(expected.hessian(j, j));
        EXPECT_NEAR(sums.hessian(i, j), expected.hessian(i, j), 1e-4 * scales + 1e-2) << i << " " << j;
      }
    }
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 6);
}

TEST(DiscKernel, EvaluatesEachPixel) {
  const DiscModel model = someDisc();
  EdgePixels pixels;
  Random random(2);
  for (int i = 0; i < 133; ++i) {
    pixels.push(static_cast<float>(random.uniform(-1.5, 1.5)), static_cast<float>(random.uniform(-1.5, 1.5)),
                static_cast<float>(random.uniform(0, 255)));
  }
  DiscResiduals residuals;
  evaluateResiduals(pixels, model, residuals);
  int num_checked = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_NEAR(residuals.residual[i], pixels.grey()[i] - discLevel(model, {pixels.x()[i], pixels.y()[i]}),
                1e-3);
    EXPECT_LE(std::abs(residuals.pattern[i]), 1.000001);
    ++num_checked;
  }
  EXPECT_EQ(num_checked, 133);
}

}  // namespace
}  // namespace alidade
