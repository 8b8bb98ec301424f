// SPDX-License-Identifier: MIT
#include "alidade/fleet/false_discovery.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace alidade {

double shareAbove(double normal) {
  return 0.5 * std::erfc(normal / std::numbers::sqrt2);
}

std::vector<bool> falseDiscoveryTest(std::span<const double> p_values, double share) {
  std::vector<double> sorted;
  for (const double p : p_values)
    if (!std::isnan(p)) sorted.push_back(p);
  std::ranges::sort(sorted);
  double limit = -1;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double allowed = share * static_cast<double>(i + 1) / static_cast<double>(sorted.size());
    if (sorted[i] <= allowed) limit = sorted[i];
  }
  std::vector<bool> positive;
  for (const double p : p_values) positive.push_back(p <= limit);
  return positive;
}

}  // namespace alidade
