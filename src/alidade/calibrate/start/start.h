// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "alidade/adjust/board/pose_search.h"
#include "alidade/calibrate/start/calibration_options.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/core/image.h"

namespace alidade {

/// Cameras of the requested model to start from, with a pose for each view that they explain.
struct Start {
  /// The best first. The others are optima of about the same cost, from other shapes of the lens; only all
  /// views can decide between them.
  std::vector<PosedCamera> optima;
  StartReport report = {};
};

/// Finds a camera and poses to start from, without an initial guess, for lenses of 15 to 210 degrees.
///
/// A spread of the views is first solved for a lens whose optimum is reached reliably: without distortion for
/// models without, `radtan` for the models that contain it, and the polynomial `kannala_brandt` for all
/// others. It starts from several fields of view with the principal point in the image's middle; poses come
/// from the corners' rays. Then all lenses of the model that resemble this one are solved in turn
/// (lensShapes), and the one with the lowest robust cost wins. Corners count equally, whatever their sigma,
/// because a start need not be precise. Nothing if no start explains the views.
///
/// With an initial camera, that one and poses by the corners' rays; nothing if it explains fewer than three
/// views.
/// @param views    the corners of each view
/// @param options  with a named model; the start is the same bit by bit with any number of threads
[[nodiscard]] std::optional<Start> findStart(std::span<const std::vector<Observation>> views, ImageSize size,
                                             const CalibratorOptions& options);

}  // namespace alidade
