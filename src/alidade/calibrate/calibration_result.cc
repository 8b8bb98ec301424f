// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibration_result.h"

#include <cmath>
#include <limits>

namespace alidade {

double CalibrationResult::outlierShare() const {
  const auto num_out = static_cast<double>(outliers.size());
  return num_out / (num_out + num_corners);
}

double CalibrationResult::smoothness() const {
  return weighted_rms_px / std::sqrt(2.0) / local_sigma_px;
}

}  // namespace alidade
