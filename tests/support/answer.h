// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "alidade/calibrate/calibrator.h"

namespace alidade {

/// The error up to which a pixel is said to be good, and beyond which it is wrong.
inline constexpr double kTolerancePx = 1;

/// A calibration beside the true camera.
struct Answer {
  Verdict verdict = Verdict::kNo;
  std::size_t num_covered = 0;
  std::size_t num_within = 0;  // of the covered pixels, those with less than the stated error
  double worst_ratio = 0;      // true over stated error, of all pixels with a stated error
  double p95_px = 0;           // of the true errors of all pixels that are said to be within the tolerance
  double worst_px = 0;
  double stated_px = 0;  // where boards were seen
  std::vector<Diagnosis> diagnoses = {};

  [[nodiscard]] bool isNamed(const std::string& id) const {
    return std::ranges::any_of(diagnoses, [&](const Diagnosis& d) { return d.id == id; });
  }
};

[[nodiscard]] Answer answerOf(const Checkerboard& board, const std::vector<View>& views,
                              const CalibratorOptions& options, const AnyCamera& truth);

}  // namespace alidade
