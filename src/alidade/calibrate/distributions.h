// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// The number that a standard normal variable exceeds in size in 5 % of all cases.
inline constexpr double kNormal95 = 1.959963984540054;

/// The number that a variable of Student's t distribution exceeds in size in 5 % of all cases, to 1 % from
/// 2.5 degrees of freedom on and to 0.1 % from 4 on; infinity below 2, where it is too large to be of use.
/// Abramowitz and Stegun 1964, Handbook of Mathematical Functions, 26.7.5.
[[nodiscard]] double studentT95(double freedom);

/// The normal variable that is exceeded as often as this one of Student's t distribution, up to 3 to 2 %
/// from 3 degrees of freedom on, by which it is too small (Wallace 1959, Bounds on normal approximations to
/// Student's and the chi-square distributions, Annals of Mathematical Statistics 30(4)); of the same sign.
[[nodiscard]] double normalOfStudentT(double t, double freedom);

/// The normal variable that is exceeded as often as this mean of `count` squares of normal variables (Wilson
/// and Hilferty 1931, The distribution of chi-square).
[[nodiscard]] double normalOfMeanSquare(double mean, double count);
/// The inverse in `mean`: the mean of `count` squares that is exceeded as often as a normal variable exceeds
/// `normal`.
[[nodiscard]] double meanSquareOfNormal(double normal, double count);

/// The normal variable that is exceeded as often as this one of the F distribution (Paulson 1942, An
/// approximate normalization of the analysis of variance distribution, Annals of Mathematical Statistics
/// 13(2)). Up to 3 it is too small by at most 0.05 from 10 degrees of freedom below on, and by 0.2 for 5;
/// more beyond.
[[nodiscard]] double normalOfF(double f, double above, double below);
/// The inverse in `f`; infinity where so few degrees of freedom below never reach it.
[[nodiscard]] double fOfNormal(double normal, double above, double below);

}  // namespace alidade
