// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace alidade {

/// The probability that a standard normal variable exceeds this value.
[[nodiscard]] double shareAbove(double normal);

/// Which of many tests are positive, such that the expected share of false ones among them is at most this
/// (Benjamini and Hochberg 1995). If there is nothing to find, that is also the chance of any false alarm.
/// @param p_values  of the tests; NaN if a test could not be made, which counts as negative
[[nodiscard]] std::vector<bool> falseDiscoveryTest(std::span<const double> p_values, double share);

}  // namespace alidade
