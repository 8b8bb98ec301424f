// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/uncertainty.h"

#include <algorithm>

#include "alidade/core/statistics.h"

namespace alidade {
namespace {

double shareOf(const Accuracy& accuracy, double tolerance_px, bool is_of_covered) {
  std::size_t num_all = 0;
  std::size_t num_within = 0;
  for (std::size_t i = 0; i < accuracy.error_px.size(); ++i) {
    const double error = accuracy.error_px[i];
    if (std::isnan(error) || (is_of_covered && !accuracy.is_covered[i])) continue;
    ++num_all;
    num_within += error <= tolerance_px ? 1 : 0;
  }
  return num_all == 0 ? 0.0 : static_cast<double>(num_within) / static_cast<double>(num_all);
}

}  // namespace

double ViewCovariance::effectiveStd(int i) const {
  const double variance = is_pooled ? larger(i, i) : covariance(i, i);
  const double inflated =
      is_pooled || !(variance > 0) ? 1.0 : studentT95(freedom[static_cast<std::size_t>(i)]) / kNormal95;
  const double by_views = inflated * std::sqrt(std::max(0.0, variance));
  return common_error.rows() > 0 ? std::hypot(by_views, common_error(i, 0)) : by_views;
}

double ParameterUncertainty::parameterStdByNoise(int i) const {
  if (!covariance) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt((*covariance)(i, i));
}

bool ParameterUncertainty::isNoiseExceeded() const {
  constexpr double kExactPx = 1e-4;  // for corners without noise, where rounding is not disagreement
  return by_views && coordinate_sigma_px > kExactPx && by_views->excess_sigmas > kBeyondChance;
}

DenseMatrix ParameterUncertainty::statedCovariance() const {
  const bool is_other = ignored_bend && ignored_bend->covariance;
  Eigen::MatrixXd stated = isNoiseExceeded() ? by_views->larger
                           : is_other        ? *ignored_bend->covariance
                                             : *covariance;
  if (ignored_bend) stated += ignored_bend->params_step.view() * ignored_bend->params_step.view().transpose();
  if (ignored_stretches.rows() > 0) stated += ignored_stretches.view() * ignored_stretches.view().transpose();
  // Inverses are symmetric except for rounding, which a nearly singular covariance amplifies to visible
  // digits of pixels. Files state the lower triangle, and recomputing from the file gives the same result.
  return Eigen::MatrixXd(stated.selfadjointView<Eigen::Lower>());
}

double ParameterUncertainty::parameterStd(int i) const {
  if (!covariance) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(statedCovariance()(i, i));
}

std::optional<ParameterUncertainty::Correlation> ParameterUncertainty::strongestCorrelation() const {
  constexpr double kStrong = 0.95;
  constexpr double kSame = 1 - 1e-9;
  if (!covariance) return std::nullopt;
  const Eigen::MatrixXd stated = statedCovariance();
  Correlation strongest;
  for (int i = 0; i < stated.rows(); ++i) {
    for (int j = 0; j < i; ++j) {
      const double value = stated(i, j) / std::sqrt(stated(i, i) * stated(j, j));  // NaN if one is held
      if (std::abs(value) > std::abs(strongest.value) && std::abs(value) < kSame)
        strongest = {.first = j, .second = i, .value = value};
    }
  }
  if (!(std::abs(strongest.value) > kStrong)) return std::nullopt;
  return strongest;
}

bool Uncertainty::hasBias() const {
  constexpr double kBiasSigmas = 0.3;  // of a corner's coordinate; less is harmless
  return image_bias.isSeen() && image_bias.rms_px > kBiasSigmas * coordinate_sigma_px;
}

double Accuracy::shareWithin(double tolerance_px) const {
  return shareOf(*this, tolerance_px, false);
}

double Accuracy::coveredShareWithin(double tolerance_px) const {
  return shareOf(*this, tolerance_px, true);
}

}  // namespace alidade
