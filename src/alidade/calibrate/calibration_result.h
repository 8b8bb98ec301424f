// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/larger_model.h"
#include "alidade/calibrate/choose/model_candidate.h"
#include "alidade/calibrate/clean/outliers.h"
#include "alidade/calibrate/finding.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/calibrate/start/start.h"
#include "alidade/calibrate/uncertainty/uncertainty.h"
#include "alidade/camera/any_camera.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board_shape.h"

namespace alidade {

/// A view as the calibration left it.
struct ViewResult {
  std::string image;
  SE3 camera_from_board;
  int num_corners = 0;  ///< used, outliers left out
  int num_outliers = 0;
  double rms_px = 0;  ///< sqrt(mean over used corners of dx^2 + dy^2)
  double max_error_px = 0;
  ViewInfluence influence;  ///< on the parameters
};

/// The board's shape and what the views say of it.
struct EstimatedShape : ShapeReport {
  BoardShape shape;           ///< flat unless it was estimated
  bool is_estimated = false;  ///< with the camera; false: the board was held flat
  double bend_share = 0;      ///< the larger bend as a share of the board's extent along it
};

struct CalibrationResult : Uncertainty {
  explicit CalibrationResult(AnyCamera estimated) : camera(std::move(estimated)) {}

  AnyCamera camera;
  ImageSize image_size;
  std::vector<ViewResult> views;  ///< in order of image name
  std::vector<ExcludedView> excluded_views;
  std::vector<RepeatedView> repeated_views;
  std::size_t num_misfits = 0;  ///< of the excluded views, those that do not fit the camera of the others
  std::vector<Outlier> outliers;
  int num_corners = 0;  ///< used
  double rms_px = 0;    ///< sqrt(mean over used corners of dx^2 + dy^2)
  /// The same with each corner's square times its weight, see CornerNoise; the mean weight is 1.
  double weighted_rms_px = 0;
  int num_corners_outside = 0;  ///< used corners that the final camera says it cannot see
  DomainCertificate domain;
  std::vector<int> held;  ///< indices of parameters that were not estimated; their sigma is 0
  StartReport start;      ///< how the search for a start went
  SolveSummary solver;
  HuberLoss loss{.threshold_px = 0};
  bool is_settled = true;  ///< noise estimate and set of outliers came to rest in the rounds allowed
  EstimatedShape shape;
  WeakPrior weak_prior;                     ///< what holds a lens together that the views do not determine
  std::optional<BetterModel> better_model;  ///< where the model was named
  std::optional<ModelChoice> model_choice;  ///< where it was not
  std::vector<Finding> findings;

  /// Of the corners of the views in use, how many were left out.
  [[nodiscard]] double outlierShare() const;
  /// Errors over what neighbouring corners differ by: 1 for noise alone, more where they vary smoothly. NaN
  /// without neighbours.
  [[nodiscard]] double smoothness() const;
  [[nodiscard]] Verdict verdict() const { return verdictOf(findings); }
  /// False if any finding is a failure: the parameters are then not to be used.
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

/// Looks at everything but `findings` and says what is wrong with the result; pure judgement, no estimation.
[[nodiscard]] std::vector<Finding> judge(const CalibrationResult& result);

}  // namespace alidade
