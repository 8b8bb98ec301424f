// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// The number that a standard normal variable exceeds in size in 5 % of all cases.
inline constexpr double kNormal95 = 1.959963984540054;

/// The number that a variable of Student's t distribution exceeds in size in 5 % of all cases, to 1 % from
/// 2.5 degrees of freedom on and to 0.1 % from 4 on; infinity below 2, where it is too large to be of use.
/// Abramowitz and Stegun 1964, Handbook of Mathematical Functions, 26.7.5.
[[nodiscard]] double studentT95(double freedom);

/// The normal variable that is exceeded as often as this mean of `count` squares of normal variables (Wilson
/// and Hilferty 1931, The distribution of chi-square).
[[nodiscard]] double normalOfMeanSquare(double mean, double count);
/// The inverse in `mean`: the mean of `count` squares that is exceeded as often as a normal variable exceeds
/// `normal`.
[[nodiscard]] double meanSquareOfNormal(double normal, double count);

}  // namespace alidade
