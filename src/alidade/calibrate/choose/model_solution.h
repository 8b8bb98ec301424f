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
  std::vector<AnyCamera> rivals = {};  ///< other models that predict the corners equally well
};

/// Fits a camera to the views; all corners count by the robust loss alone.
/// @param options  must name a model
/// @throws Error (kInput) if no camera of the model explains the views
[[nodiscard]] ModelSolution fittedPlainly(const PreparedViews& given, const CalibratorOptions& options);

/// Settles the data: board bends, outliers, views that do not fit, weights. Regularises a lens that the views
/// do not determine.
[[nodiscard]] ModelSolution withDataSettled(ModelSolution solution, const PreparedViews& given,
                                            const CalibratorOptions& options);

/// Chooses the smallest model beside which none with further parameters has significantly smaller held-out
/// errors, by a share that is worth them, among those that the views determine. Where it folds inside the
/// image, fisheye models come into question too, and a model that does not fold is taken in its place if the
/// errors that this adds are below a warning (CalibratorOptions::tolerance_px). See docs/model_choice.md.
///
/// Models that other models contain are given up where a few steps of the larger one take less off the cost
/// than would count.
///
/// All candidates are compared on the same corners with the same weights, those that the smallest model which
/// fits as well as any settles on: a lean model would leave out as outliers what a better one explains.
/// The chosen model then settles by itself what an outlier is, as if it had been named.
/// @throws Error (kInput) if neither a perspective nor a fisheye lens explains the views
[[nodiscard]] ModelSolution chooseModel(const PreparedViews& given, const CalibratorOptions& options);

}  // namespace alidade
