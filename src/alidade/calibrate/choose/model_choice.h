// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/choose/model_solution.h"

namespace alidade {

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
