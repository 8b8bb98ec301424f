// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/calibrate/choose/model_choice.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/projection_uncertainty.h"

namespace alidade {

/// What the choice of the model decides, and no corner: where models that predict the corners equally well
/// put far points at different pixels. A covariance comes from one model and cannot know of this; where no
/// board was, a stiff model's sigmas are small and may be wrong many times over.
struct ModelSpread {
  std::string id;  ///< of the rival that differs over the largest part of the image
  /// Of the pixels at which the chosen camera has a ray, those that are more than kApartPx and more than 3
  /// stated sigmas apart. Where the rival sees nothing, it says nothing.
  double share_apart = 0;
  double worst_px =
      0;  ///< the largest difference; the rotation that fits best where corners were is taken out
  Eigen::Vector2d worst_pixel{0, 0};
};

/// A difference between models that counts, px.
inline constexpr double kApartPx = 1;

/// Nothing where there are no rivals, or none sees a pixel that the camera sees.
/// @param camera   of the chosen model, solved on the same corners as the rivals
/// @param corners  pixels of these corners
/// @param grid     the stated uncertainty of far points
[[nodiscard]] std::optional<ModelSpread> modelSpread(const AnyCamera& camera,
                                                     std::span<const RivalCamera> rivals,
                                                     std::span<const Eigen::Vector2d> corners,
                                                     const UncertaintyGrid& grid);

}  // namespace alidade
