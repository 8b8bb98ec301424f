// SPDX-License-Identifier: MIT
#include "alidade/compare/agreement.h"

namespace alidade {

bool isComparable(const ProjectionDifference& difference) {
  // Domains of different models end at slightly different places where the image circle does.
  constexpr double kMaxShareOfOne = 0.05;
  const double num_seen = difference.num_compared + difference.num_seen_by_one;
  return difference.is_converged && difference.num_compared > 0 &&
         difference.num_seen_by_one <= kMaxShareOfOne * num_seen;
}

Agreement agreementOf(const ProjectionDifference& difference,
                      const std::optional<DifferenceSignificance>& significance, double tolerance_px) {
  if (!isComparable(difference)) return Agreement::kNotComparable;
  if (difference.p95_px <= tolerance_px) return Agreement::kWithin;
  const bool is_sure = !significance || significance->isSignificant();
  return is_sure ? Agreement::kBeyond : Agreement::kUncertain;
}

}  // namespace alidade
