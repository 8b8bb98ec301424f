// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/choose/model_solution.h"

namespace alidade {

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
