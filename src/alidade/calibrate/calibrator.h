// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/calibrate/calibration_result.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// A camera to start from.
struct InitialCamera {
  AnyCamera camera;  ///< of another model: the one in its place by fitModel()
  ImageSize size;
};

/// Whether the board's bend (BoardShape) is estimated.
enum class BoardShapeMode {
  kFlat,  ///< the board is taken as flat
  kWarp,  ///< the bend is estimated
  kAuto,  ///< the bend is estimated if a test says that there is one
};

struct CalibratorOptions {
  /// An id of the model list, or kAutoModel: that of the initial camera, or the one chosen by held-out error.
  std::string model = "radtan";
  std::optional<InitialCamera> initial = std::nullopt;  ///< nothing: a start is searched for
  /// Names of parameters that keep their value: that of `initial`; without one, the image's centre for cx and
  /// cy and 0 for the lens.
  std::vector<std::string> held = {};
  bool same_focal = false;  ///< fx = fy in pixels
  BoardShapeMode board_shape = BoardShapeMode::kAuto;
  int jobs = 1;  ///< threads; 0 = one per processor. The result does not depend on it.
  const CancelFlag* cancel = nullptr;
};

/// Fewest views from which a calibration is attempted. Two would determine four parameters, with nothing left
/// to notice a mistake by.
inline constexpr int kMinViews = 3;

/// Calibrates one camera from views of one board; no initial guess. The views may come in any order and are
/// put in order of their image names first, so that the result does not depend on it. Corners that state
/// different sigmas are weighted, see CornerNoise.
/// @throws Error (kInput): fewer than kMinViews views, views of different image sizes, two views of one
/// image, corner ids that the board does not have, corners that are not finite, negative sigmas, or views
/// that no camera explains, an initial camera of another image size. Error (kUsage): unknown model or
/// parameter to hold, or one that has no value to be held at. Cancelled. A poor result is no exception: see
/// CalibrationResult::findings.
[[nodiscard]] CalibrationResult calibrate(const Checkerboard& board, std::vector<View> views,
                                          const CalibratorOptions& options = {});

}  // namespace alidade
