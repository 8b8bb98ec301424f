// SPDX-License-Identifier: MIT
#include "alidade/core/statistics.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace alidade {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Statistics, StudentsTAsTabulated) {
  EXPECT_NEAR(studentT95(3), 3.1824463, 1e-6);
  EXPECT_NEAR(studentT95(5), 2.5705818, 1e-6);
  EXPECT_NEAR(studentT95(10), 2.2281389, 1e-6);
  EXPECT_NEAR(studentT95(1e9), kNormal95, 1e-8);
  EXPECT_NEAR(studentT95(kInfinity), kNormal95, 1e-12);
  EXPECT_TRUE(std::isinf(studentT95(1.9)));
  EXPECT_TRUE(std::isinf(studentT95(kNan)));
  EXPECT_NEAR(studentTOneSided95(1), 6.3137515, 1e-6);
  EXPECT_NEAR(studentTOneSided95(4), 2.1318468, 1e-6);
  EXPECT_NEAR(studentTOneSided95(1e9), 1.6448536, 1e-6);
}

TEST(Statistics, StudentsTAsANormalVariable) {
  EXPECT_NEAR(normalOfStudentT(2.306004135033371, 8), kNormal95, 1e-9);
  EXPECT_NEAR(normalOfStudentT(-5.893429532923186, 5), -kNormalOneInThousand, 1e-9);
  EXPECT_NEAR(normalOfStudentT(3, 1e9), 3, 1e-6);
  EXPECT_EQ(normalOfStudentT(3, kInfinity), 3);
  EXPECT_EQ(normalOfStudentT(0, 3), 0);
  EXPECT_TRUE(std::isnan(normalOfStudentT(kNan, 3)));
}

TEST(Statistics, MeanSquareAsTabulated) {
  // The sums of 1, 2 and 10 squares that are exceeded once in a thousand cases.
  EXPECT_NEAR(normalOfMeanSquare(10.827566170662733, 1), kNormalOneInThousand, 1e-9);
  EXPECT_NEAR(normalOfMeanSquare(13.815510557964274 / 2, 2), kNormalOneInThousand, 1e-9);
  EXPECT_NEAR(normalOfMeanSquare(29.58829844507442 / 10, 10), kNormalOneInThousand, 1e-9);
  for (const double normal : {-3.0, -1.0, 0.0, 2.0, 8.0})
    EXPECT_NEAR(normalOfMeanSquare(meanSquareOfNormal(normal, 7.5), 7.5), normal, 1e-9) << normal;
  EXPECT_TRUE(std::isnan(normalOfMeanSquare(kNan, 3)));
  EXPECT_TRUE(std::isnan(normalOfMeanSquare(1, 0)));
}

TEST(Statistics, FAsTabulated) {
  EXPECT_NEAR(normalOfF(5.1282634246623395, 5, 40), kNormalOneInThousand, 1e-9);
  EXPECT_NEAR(normalOfF(4.474184809637748, 3, 12), kNormal95, 1e-9);
  EXPECT_NEAR(normalOfF(3.129968572272079, 9, 1000), kNormalOneInThousand, 1e-9);
  EXPECT_NEAR(normalOfF(0.8682926874669954, 4, 20), 0, 1e-9);
  for (const double normal : {-1.0, 0.0, 2.0, 3.09})
    EXPECT_NEAR(normalOfF(fOfNormal(normal, 6, 30), 6, 30), normal, 1e-9) << normal;
  EXPECT_NEAR(normalOfF(4, 5, 1e11), normalOfF(4, 5, kInfinity), 1e-6);
  EXPECT_NEAR(fOfNormal(3, 5, 1e11), fOfNormal(3, 5, kInfinity), 1e-6);
  EXPECT_TRUE(std::isnan(normalOfF(kNan, 3, 3)));
  EXPECT_TRUE(std::isnan(fOfNormal(3, 3, 0)));
}

// Where the share of the cases is too small for a number, and where it is zero.
TEST(Statistics, NormalVariablesGoOnBeyondWhatSharesCanTell) {
  double last_t = 0;
  double last_square = 0;
  double last_f = 0;
  for (double x = 1; x < 1e12; x *= 1.5) {
    const double t = normalOfStudentT(x, 300);
    const double square = normalOfMeanSquare(x, 3);
    const double f = normalOfF(x, 9, 400);
    EXPECT_GE(t, last_t) << x;
    EXPECT_GE(square, last_square) << x;
    EXPECT_GE(f, last_f) << x;
    last_t = t;
    last_square = square;
    last_f = f;
  }
  EXPECT_GT(last_t, 90);
  EXPECT_GT(last_square, 1e6);
  EXPECT_GT(last_f, 90);
  EXPECT_TRUE(std::isfinite(last_t) && std::isfinite(last_square) && std::isfinite(last_f));
  EXPECT_NEAR(normalOfMeanSquare(0, 5), -37, 0.1);
  EXPECT_NEAR(normalOfF(0, 5, 5), -37, 0.1);
}

}  // namespace
}  // namespace alidade
