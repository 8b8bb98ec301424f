// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/camera/any_camera.h"

namespace alidade {

/// A camera of one model that fits the views, and how it was found.
struct ModelSolution {
  Fit fit;
  Choice choice;  ///< except what concerns other models
  /// Parameters of other optima that were about as good on all views, for otherOptima().
  std::vector<std::vector<double>> close_params;
  std::vector<AnyCamera> rivals = {};         ///< other models that predict the corners equally well
  std::optional<HoldoutReport> holdout = {};  ///< of this fit, if it has been cross-validated
};

/// Fits a camera to the views; all corners count by the robust loss alone.
/// @param options  must name a model
/// @throws Error (kInput) if no camera of the model explains the views
[[nodiscard]] ModelSolution fittedPlainly(const PreparedViews& given, const CalibratorOptions& options);

/// Settles the data: board bends, outliers, views that do not fit, weights. Regularises a lens that the views
/// do not determine.
[[nodiscard]] ModelSolution withDataSettled(ModelSolution solution, const PreparedViews& given,
                                            const CalibratorOptions& options);

/// The same for a fit that was settled before its corners moved a little: which corners and views it uses,
/// and whether boards bend, stays decided.
[[nodiscard]] ModelSolution withDataResettled(ModelSolution solution, const CalibratorOptions& options);

/// Chooses, among the models that the views determine, the smallest one that no larger model beats
/// significantly, and by a worthwhile share, in held-out error. If it folds inside the image, fisheye models
/// are considered too, and a model that does not fold replaces it if that adds less error than a warning
/// needs (CalibratorOptions::tolerance_px). See docs/model_choice.md.
///
/// A larger model is skipped if a few steps of it from the smaller model that it contains lower the cost by
/// less than a significant amount.
///
/// All candidates are compared on the same corners with the same weights, from the smallest model that fits
/// as well as any: a simpler model would discard as outliers corners that a better one explains. The chosen
/// model then decides by itself which corners are outliers, as if the user had named it.
/// @throws Error (kInput) if neither a perspective nor a fisheye lens explains the views
[[nodiscard]] ModelSolution chooseModel(const PreparedViews& given, const CalibratorOptions& options);

}  // namespace alidade
