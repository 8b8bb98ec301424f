// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/core/image.h"

namespace alidade {

/// The model name that stands for a choice among models by held-out error.
inline constexpr const char* kAutoModel = "auto";

/// A camera to start from.
struct InitialCamera {
  AnyCamera camera;  ///< converted by fitModel() if of another model
  ImageSize size;
};

/// Which parts of the board's shape (BoardShape) are estimated.
enum class BoardShapeMode {
  kFlat,      ///< nothing; the board is taken as flat
  kWarp,      ///< the bend
  kUneven,    ///< the bend if two tests detect it, and the offset of each point
  kFlexible,  ///< a bend for each view
  kAuto,      ///< the bend if two tests detect it; bends for each view, or offsets, if the errors show them
};
/// Their names, in the same order.
inline constexpr std::array<std::string_view, 5> kBoardShapeModes = {"flat", "warp", "uneven", "flexible",
                                                                     "auto"};
/// Nothing for another name.
[[nodiscard]] inline std::optional<BoardShapeMode> boardShapeMode(std::string_view name) {
  const auto at = std::ranges::find(kBoardShapeModes, name) - kBoardShapeModes.begin();
  if (at == std::ssize(kBoardShapeModes)) return std::nullopt;
  return static_cast<BoardShapeMode>(at);
}

/// The normal equations of a correction field grow with the fourth power of this.
inline constexpr int kMaxCorrectionCells = 24;

struct CalibratorOptions {
  /// One of modelIds(), or kAutoModel: that of the initial camera, or one chosen by cross-validation.
  std::string model = kAutoModel;
  std::vector<std::string_view> models = {};  ///< candidates for kAutoModel; empty = all of modelIds()
  std::optional<InitialCamera> initial = std::nullopt;  ///< empty: searched for automatically
  /// Names of parameters that keep their value: that of `initial`; without one, the image's centre for cx and
  /// cy and 0 for the lens. "radtan.k3" is k3 of that model only, whichever model is named or chosen.
  std::vector<std::string> held = {};
  bool same_focal = false;  ///< holds fx = fy in pixels
  BoardShapeMode board_shape = BoardShapeMode::kAuto;
  /// How many numbers of the entrance pupil (EntrancePupil) are estimated, 0 to 2. Nothing: those that a wide
  /// lens needs, by cross-validation.
  std::optional<std::size_t> num_pupil = {};
  /// Columns and rows of the CorrectionField; zeros: none. Nothing: the field that the lens needs, by
  /// cross-validation, if the model is chosen.
  std::optional<std::array<int, 2>> correction_cells = {};
  double tolerance_px = 1;  ///< the error of a projected point (95 %) that the user accepts; see judge()
  /// Distance of the points that the accuracy is for, metres; infinite: distant points. See Accuracy.
  double distance_m = std::numeric_limits<double>::infinity();
  int jobs = 1;  ///< threads; 0 = one per processor. The result does not depend on it.
  const CancelFlag* cancel = nullptr;
};

}  // namespace alidade
