// SPDX-License-Identifier: MIT
#include "alidade/calibrate/distributions.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace alidade {
double studentT95(double freedom) {
  constexpr double kFewest = 2;
  if (!(freedom >= kFewest)) return std::numeric_limits<double>::infinity();
  constexpr double x = kNormal95;
  constexpr double x2 = x * x;
  const double n = freedom;
  const double g1 = x * (x2 + 1) / 4;
  const double g2 = x * ((5 * x2 + 16) * x2 + 3) / 96;
  const double g3 = x * (((3 * x2 + 19) * x2 + 17) * x2 - 15) / 384;
  const double g4 = x * ((((79 * x2 + 776) * x2 + 1482) * x2 - 1920) * x2 - 945) / 92160;
  return x + (g1 + (g2 + (g3 + g4 / n) / n) / n) / n;
}

double normalOfStudentT(double t, double freedom) {
  if (std::isinf(freedom)) return t;
  const double factor = (8 * freedom + 1) / (8 * freedom + 3);
  const double size = factor * std::sqrt(freedom * std::log1p(t * t / freedom));
  return std::copysign(size, t);
}

double normalOfMeanSquare(double mean, double count) {
  const double spread = 2 / (9 * count);
  return (std::cbrt(mean) - (1 - spread)) / std::sqrt(spread);
}

double meanSquareOfNormal(double normal, double count) {
  const double spread = 2 / (9 * count);
  const double root = 1 - spread + normal * std::sqrt(spread);
  return root * root * root;
}

double normalOfF(double f, double above, double below) {
  const double a = 2 / (9 * above);
  const double b = 2 / (9 * below);
  const double root = std::cbrt(f);
  return ((1 - b) * root - (1 - a)) / std::sqrt(b * root * root + a);
}

double fOfNormal(double normal, double above, double below) {
  // Paulson's formula, squared, is a parabola in the cube root of f.
  const double a = 2 / (9 * above);
  const double b = 2 / (9 * below);
  const double zz = normal * normal;
  const double second = (1 - b) * (1 - b) - zz * b;
  if (!(second > 0)) return std::numeric_limits<double>::infinity();
  const double first = (1 - a) * (1 - b);
  const double inside = first * first - second * ((1 - a) * (1 - a) - zz * a);
  const double root = (first + std::copysign(std::sqrt(std::max(0.0, inside)), normal)) / second;
  return root * root * root;
}

}  // namespace alidade
