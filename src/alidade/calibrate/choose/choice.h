// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "alidade/adjust/noise/larger_model.h"
#include "alidade/calibrate/bend/board_bend.h"
#include "alidade/calibrate/bend/uneven_board.h"
#include "alidade/calibrate/start/start.h"

namespace alidade {

/// A model that was considered.
struct ModelCandidate {
  std::string id;
  int num_params = 0;
  double rms_px = std::numeric_limits<double>::quiet_NaN();  ///< weighted, on the corners in common
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
  /// How much larger its held-out RMS is than that of the best, as a share, and the standard error of that.
  double excess = std::numeric_limits<double>::quiet_NaN();
  double excess_std = std::numeric_limits<double>::quiet_NaN();
  /// chosen; worse; larger (no worse than the chosen one, but not needed); no_solution; not_allowed; or why
  /// it is no camera to recommend, see Unsoundness: not_converged, ill_conditioned, corners_outside_domain,
  /// folds_in_image, no_holdout.
  std::string verdict;
  std::string reason;  ///< the same for people
};

/// How a model was chosen.
struct ModelChoice {
  std::vector<ModelCandidate> candidates;  ///< by number of parameters
  std::string best;                        ///< the one with the least held-out error
  std::string reference;                   ///< the one that decided which corners are outliers
  /// Angle between the rays of the middles of the image's shorter sides, radians; infinite where these have
  /// none.
  double field_rad = 0;
  bool is_wide = false;  ///< fisheye models were considered
};

/// What was decided on the way to a fit.
struct Choice {
  StartReport start = {};
  std::vector<ShapeReport> shapes = {};  ///< one for each board of the fit
  UnevenReport points = {};              ///< of the boards
  bool is_settled = false;  ///< noise estimate and set of outliers came to rest in the rounds allowed
  std::optional<ModelChoice> model = {};         ///< where the model was not named
  std::optional<BetterModel> better_model = {};  ///< where it was
};

}  // namespace alidade
