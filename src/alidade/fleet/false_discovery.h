// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace alidade {

/// The share of all cases in which a standard normal variable exceeds this one.
[[nodiscard]] double shareAbove(double normal);

/// Which of many tests are positive, so that of the positive ones at most this share is expected to be false
/// (Benjamini and Hochberg 1995). Where nothing is to be found, that is also the chance of any false alarm.
/// @param p_values  of the tests; NaN: it could not be made, and is negative
[[nodiscard]] std::vector<bool> falseDiscoveryTest(std::span<const double> p_values, double share);

}  // namespace alidade
