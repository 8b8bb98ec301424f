// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace alidade {

/// What is known of one member of a population: its measured parameters, and the covariance of that
/// measurement (zero: exact).
struct PopulationSample {
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
};

/// A population of parameter vectors that are normally distributed about a mean, each measured with an error
/// of its own.
struct Population {
  Eigen::VectorXd mean;
  Eigen::MatrixXd mean_covariance;  ///< of the mean's estimate, as if `between` were known
  Eigen::MatrixXd between;          ///< covariance between members, their measurement errors removed
  std::vector<bool> is_member;      ///< one per sample: it took part; the others lie too far from the rest

  [[nodiscard]] std::size_t numMembers() const;
  /// Of one more member, as far as it can be predicted: `between` and the uncertainty of the mean.
  [[nodiscard]] Eigen::MatrixXd predictive() const { return between + mean_covariance; }
};

/// The standard deviations between so many members are known to 2 %.
inline constexpr std::size_t kMostForSpread = 2000;

/// The fewest samples from which outliers among them can be told.
[[nodiscard]] std::size_t fewestForOutliers(std::size_t num_parameters);

/// Random-effects estimate of a population from several parameters at once: restricted maximum likelihood by
/// the EM algorithm (Dempster, Laird and Rubin 1977; restricted likelihood: Harville 1977), started from
/// the method of moments of DerSimonian and Laird (1986) in its matrix form (Jackson, White and Thompson
/// 2010, with equal weights). The mean is weighted by the inverse of each sample's whole covariance.
///
/// Samples that do not belong to the population are left out: the estimate begins with the three quarters of
/// the samples that are nearest to each other (concentration steps as in the MCD estimate of Rousseeuw and
/// Van Driessen 1999) and takes in all others that the result explains at a level of 1 in 1000. With fewer
/// than fewestForOutliers(), all take part.
///
/// The spread is estimated from at most kMostForSpread members, evenly chosen, the mean from all.
///
/// A parameter that is the same in all samples keeps its value and has no variance.
/// @param samples  two or more, of one length, finite
[[nodiscard]] Population estimatePopulation(std::span<const PopulationSample> samples);

/// The share of a sample's whole covariance that is spread between members, 0 to 1.
[[nodiscard]] double betweenShare(const Population& population, const PopulationSample& sample);

}  // namespace alidade
