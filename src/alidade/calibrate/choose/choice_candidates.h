// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <exception>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/adjust/noise/model_soundness.h"
#include "alidade/calibrate/choose/model_solution.h"
#include "alidade/calibrate/start/reports.h"

namespace alidade {

/// A model considered for the choice.
struct Candidate {
  explicit Candidate(std::string_view model_id);

  std::string id;
  std::size_t num_params;  ///< free ones of lens and affine step; those held in all models count
  /// As fittedPlainly() leaves it. Nothing: see `unsoundness` and `not_better_than`; with neither, the model
  /// needs no search of its own.
  std::optional<ModelSolution> solution;
  ParamConstraint constraint;
  std::exception_ptr error;  ///< why no camera of the model explains the views
  std::optional<Unsoundness> unsoundness;
  std::string not_better_than;  ///< smaller model that fits the corners equally well after a few steps
  std::string fits_worse_than;  ///< the reference, so much better that cross-validation is pointless

  // Results on the common corners.
  std::vector<double> params;
  std::optional<HeldOutScore> score;
  double rms_px = std::numeric_limits<double>::quiet_NaN();
  double holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
};

using Candidates = std::vector<Candidate>;

/// Which models are considered.
enum class Lenses {
  kByField,  ///< fisheye models only for wide lenses: all programs read radtan and rational
  kAll,
};

/// True if the camera of a fit folds inside the image.
[[nodiscard]] bool foldsInsideImage(const Fit& fit);

/// Fits the models under consideration, by number of parameters.
/// @throws Error (kInput) if neither a perspective nor a fisheye lens explains the views
[[nodiscard]] Candidates fitCandidates(Lenses lenses, const PreparedViews& given,
                                       const CalibratorOptions& options, ModelChoice& choice);

/// The smallest of the fitted models that fits all corners about as well as any. @pre at least one is fitted.
[[nodiscard]] Candidate& fittest(Candidates& candidates, const PreparedViews& given);

}  // namespace alidade
