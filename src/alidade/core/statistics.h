// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace alidade {

/// The value that the magnitude of a standard normal variable exceeds in 5 % of all cases.
inline constexpr double kNormal95 = 1.959963984540054;
/// The value that a standard normal variable exceeds in 1 of 1000 cases.
inline constexpr double kNormalOneInThousand = 3.090232306167813;

/// The smallest of these values that is at least as large as 95 % of them.
/// @pre one or more, finite
[[nodiscard]] double quantile95(std::vector<double> values);

/// The value that the magnitude of a variable of Student's t distribution exceeds in 5 % of all cases;
/// infinity below 2 degrees of freedom, where it is too large to be useful.
[[nodiscard]] double studentT95(double freedom);

/// The value that a variable of Student's t distribution exceeds in 5 % of all cases.
[[nodiscard]] double studentTOneSided95(double freedom);

// The normal variables below are exact up to a magnitude of 37. Beyond, where the probability underflows,
// they are the signed root of the deviance, a few tenths off; none is below -37.1.

/// The normal variable that is exceeded as often as `t` in Student's t distribution; it has the same sign.
[[nodiscard]] double normalOfStudentT(double t, double freedom);

/// The normal variable that is exceeded as often as this mean of `count` squares of normal variables.
[[nodiscard]] double normalOfMeanSquare(double mean, double count);
/// The inverse in `mean`: the mean of `count` squares that is exceeded as often as a normal variable exceeds
/// `normal`.
[[nodiscard]] double meanSquareOfNormal(double normal, double count);

/// The normal variable that is exceeded as often as `f` in the F distribution with these degrees of freedom
/// above and below the line.
[[nodiscard]] double normalOfF(double f, double above, double below);
/// The inverse in `f`.
[[nodiscard]] double fOfNormal(double normal, double above, double below);

}  // namespace alidade
