// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibration_result.h"

#include <cmath>
#include <limits>

namespace alidade {

double CalibrationResult::parameterStd(int i) const {
  if (!covariance) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt((*covariance)(i, i));
}

bool CalibrationResult::isNoiseExceeded() const {
  constexpr double kExactPx = 1e-4;  // corners without noise: rounding is no disagreement
  return by_views && coordinate_sigma_px > kExactPx && by_views->excess_sigmas > kBeyondChance;
}

Eigen::MatrixXd CalibrationResult::statedCovariance() const {
  const bool is_other = shape.ignored && shape.ignored->covariance;
  Eigen::MatrixXd stated = isNoiseExceeded() ? by_views->larger
                           : is_other        ? *shape.ignored->covariance
                                             : *covariance;
  if (shape.ignored) stated += shape.ignored->params_step * shape.ignored->params_step.transpose();
  // Inverses are symmetric but for rounding, which a nearly singular covariance carries to the digits of
  // pixels. Files state the lower triangle, and whoever recomputes from it shall find the same.
  return stated.selfadjointView<Eigen::Lower>();
}

double CalibrationResult::statedStd(int i) const {
  if (!covariance) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(statedCovariance()(i, i));
}

std::optional<CalibrationResult::Correlation> CalibrationResult::strongestCorrelation() const {
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

double CalibrationResult::outlierShare() const {
  const auto num_out = static_cast<double>(outliers.size());
  return num_out / (num_out + num_corners);
}

bool CalibrationResult::hasBias() const {
  constexpr double kBiasSigmas = 0.3;  // of a corner's coordinate: less is no harm
  return image_bias.isSeen() && image_bias.rms_px > kBiasSigmas * coordinate_sigma_px;
}

double CalibrationResult::smoothness() const {
  return weighted_rms_px / std::sqrt(2.0) / local_sigma_px;
}

}  // namespace alidade
