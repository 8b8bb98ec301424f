// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "alidade/adjust/board/pose_search.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"

namespace alidade {

struct Start {
  PosedCamera camera;  ///< of the requested model
  /// Other optima of about the same cost, from other shapes of the lens; only all views can decide between
  /// them.
  std::vector<PosedCamera> rivals;
  StartReport report;
};

struct StartOptions {
  int jobs = 1;  ///< threads, 0: one per processor; the start is bit-identical
  const CancelFlag* cancel = nullptr;
};

/// A start from a given camera, with poses by the corners' rays. Nothing if it explains fewer than three
/// views.
/// @param views  the corners of each view
[[nodiscard]] std::optional<Start> startFrom(std::string_view model_id, std::vector<double> params,
                                             std::span<const std::vector<Observation>> views, ImageSize size);

/// Finds a camera and poses to start from, without an initial guess, for lenses of 15 to 210 degrees.
///
/// A spread of the views is first solved for a lens whose optimum is reached reliably: without distortion for
/// models without, `radtan` for the models that contain it, and the polynomial `kannala_brandt` for all
/// others. It starts from several fields of view with the principal point in the image's middle; poses come
/// from the corners' rays. Then all lenses of the model that resemble this one are solved in turn
/// (lensShapes), and the one with the lowest robust cost wins. Corners count equally, whatever their sigma,
/// because a start need not be precise. Nothing if no start explains the views.
/// @param views  the corners of each view
[[nodiscard]] std::optional<Start> findStart(std::string_view model_id,
                                             std::span<const std::vector<Observation>> views, ImageSize size,
                                             const StartOptions& options = {});

}  // namespace alidade
