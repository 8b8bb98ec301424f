// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "support/user_views.h"

namespace alidade {

/// One field of view of one model, of which several sets are drawn.
struct SweepCell {
  std::string model;
  double fov_deg = 0;
};

/// The fields that each model is made for, 20 to 200 degrees across the longer side of the image.
[[nodiscard]] std::vector<SweepCell> sweepCells();

/// A calibration without any guess beside the optimum that is next to the truth.
struct SweepOutcome {
  DrawnCamera drawn;
  UserSet set;
  Calibration result;
  double cost_from_truth = 0;  ///< of the same loss, solved from the true camera and poses; NaN without
  /// Do the views determine the parameters? If not (the solver does not come to rest even from the truth, or
  /// the information is singular to working precision), there is no optimum to be found, only a valley.
  bool is_determined = true;
  double seconds = 0;  ///< CPU time of the calibration
  std::string error;   ///< what calibrate() said instead of a result; `result` is then the truth

  [[nodiscard]] bool usesEverything() const;  ///< every view and corner
  /// Uses everything, and the cost is that of the true optimum to 1e-6 relative, or lower.
  [[nodiscard]] bool isAtOptimum() const;
  /// Uses everything, and the result says that the views do not determine the model (`ill_conditioned`).
  [[nodiscard]] bool isHeld() const;
  /// Did the user learn that something is wrong? Views that are few are no such warning.
  [[nodiscard]] bool isWarned() const;
};

/// Draws set `number` of a cell (8 to 40 views, noise of 0.1 px) and calibrates it.
[[nodiscard]] SweepOutcome runSweepSet(const SweepCell& cell, std::uint64_t number);

}  // namespace alidade
