// SPDX-License-Identifier: MIT
#include "alidade/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace alidade {
namespace {

using boost::math::complement;

// Arguments outside a function's domain give NaN or infinity instead of an exception. Computes in double, not
// long double, so that results are the same on every machine.
using Policy = boost::math::policies::policy<
    boost::math::policies::domain_error<boost::math::policies::ignore_error>,
    boost::math::policies::pole_error<boost::math::policies::ignore_error>,
    boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
    boost::math::policies::evaluation_error<boost::math::policies::ignore_error>,
    boost::math::policies::rounding_error<boost::math::policies::ignore_error>,
    boost::math::policies::promote_double<false>>;
using Normal = boost::math::normal_distribution<double, Policy>;
using StudentT = boost::math::students_t_distribution<double, Policy>;
using ChiSquared = boost::math::chi_squared_distribution<double, Policy>;
using FisherF = boost::math::fisher_f_distribution<double, Policy>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFarthest = 37.0471;   // exceeded with a probability of 1e-300
constexpr double kLeastShare = 1e-300;  // closer to zero, probabilities lose digits
// With more degrees of freedom below the line, the F distribution is that of a mean square.
constexpr double kManyBelow = 1e12;

// The normal variable with these probabilities below and above it. If the upper one underflows, it comes from
// the deviance.
double normalBetween(double below, double above, double deviance) {
  if (above < kLeastShare) return std::max(kFarthest, std::sqrt(deviance));
  if (above < below) return quantile(complement(Normal(), above));
  return below < kLeastShare ? -kFarthest : quantile(Normal(), below);
}

}  // namespace

double quantile95(std::vector<double> values) {
  const auto at = static_cast<std::ptrdiff_t>(std::ceil(0.95 * static_cast<double>(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

double studentT95(double freedom) {
  constexpr double kFewest = 2;
  if (!(freedom >= kFewest)) return kInfinity;
  return quantile(complement(StudentT(freedom), 0.025));
}

double studentTOneSided95(double freedom) {
  return quantile(complement(StudentT(freedom), 0.05));
}

double normalOfStudentT(double t, double freedom) {
  if (std::isinf(freedom) || std::isinf(t)) return t;
  const StudentT distribution(freedom);
  const double size = std::abs(t);
  return std::copysign(normalBetween(cdf(distribution, size), cdf(complement(distribution, size)),
                                     freedom * std::log1p(t * t / freedom)),
                       t);
}

double normalOfMeanSquare(double mean, double count) {
  if (std::isinf(mean)) return mean;
  const ChiSquared distribution(count);
  const double sum = mean * count;
  return normalBetween(cdf(distribution, sum), cdf(complement(distribution, sum)),
                       count * (mean - 1 - std::log(mean)));
}

double meanSquareOfNormal(double normal, double count) {
  const ChiSquared distribution(count);
  const double sum = normal > 0 ? quantile(complement(distribution, cdf(Normal(), -normal)))
                                : quantile(distribution, cdf(Normal(), normal));
  return sum / count;
}

double normalOfF(double f, double above, double below) {
  if (std::isinf(f)) return f;
  if (below > kManyBelow) return normalOfMeanSquare(f, above);
  const FisherF distribution(above, below);
  const double all = above + below;
  return normalBetween(cdf(distribution, f), cdf(complement(distribution, f)),
                       all * std::log((above * f + below) / all) - above * std::log(f));
}

double fOfNormal(double normal, double above, double below) {
  if (below > kManyBelow) return meanSquareOfNormal(normal, above);
  if (normal > 0) return 1 / fOfNormal(-normal, below, above);
  return quantile(FisherF(above, below), cdf(Normal(), normal));
}

}  // namespace alidade
