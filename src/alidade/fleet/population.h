// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// One member of a population: its measured parameters, and the covariance of that measurement (zero: exact).
struct PopulationSample {
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
};

/// A population of parameter vectors that are normally distributed about a mean, each measured with its own
/// error.
struct Population {
  Eigen::VectorXd mean;
  Eigen::MatrixXd mean_covariance;  ///< of the mean's estimate, as if `between` were known
  Eigen::MatrixXd between;          ///< covariance between members, without their measurement errors
  std::vector<bool> is_member;      ///< one per sample; false: too far from the rest, excluded

  [[nodiscard]] std::size_t numMembers() const;
  /// Covariance of the prediction of a further member: `between` plus the uncertainty of the mean.
  [[nodiscard]] Eigen::MatrixXd predictive() const { return between + mean_covariance; }
};

/// With this many members, standard deviations between members are accurate to 2 %.
inline constexpr std::size_t kMostForSpread = 2000;

/// The fewest samples among which outliers can be detected.
[[nodiscard]] std::size_t fewestForOutliers(std::size_t num_parameters);

/// Random-effects estimate of a population from several parameters at once: restricted maximum likelihood by
/// the EM algorithm (Dempster, Laird and Rubin 1977; restricted likelihood: Harville 1977), started from
/// the method of moments of DerSimonian and Laird (1986) in its matrix form (Jackson, White and Thompson
/// 2010, with equal weights). The mean is weighted by the inverse of each sample's whole covariance.
///
/// Outliers are excluded: the estimate begins with the three quarters of the samples that are nearest to each
/// other (concentration steps as in the MCD estimate of Rousseeuw and Van Driessen 1999) and adds all others
/// that are consistent with the result at a level of 1 in 1000. With fewer than fewestForOutliers() samples,
/// all are used.
///
/// The spread is estimated from at most kMostForSpread members, evenly chosen, the mean from all.
///
/// A parameter that is equal in all samples keeps its value and has no variance.
/// @param samples  two or more, of equal length, finite
[[nodiscard]] Population estimatePopulation(std::span<const PopulationSample> samples);

/// The share of a sample's whole covariance that is spread between members, 0 to 1.
[[nodiscard]] double betweenShare(const Population& population, const PopulationSample& sample);

}  // namespace alidade
