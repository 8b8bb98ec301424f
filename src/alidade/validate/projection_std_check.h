// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include "alidade/camera/any_camera.h"
#include "alidade/validate/camera_checks.h"

namespace alidade {

/// The check "projection_std": are the stated standard deviations of pixels (at infinity, the best rotation
/// taken out) those that the covariance leads to? They are recomputed (see ProjectionUncertainty) and may
/// differ by what four digits round, and by what double precision loses where large sigmas cancel.
///
/// @param covariance  of the parameters to go by, lower triangle row by row; empty: there is nothing to
///                    recompute from, and what is stated is a warning
/// @param claim       nothing: not stated, which is a warning beside a covariance
/// @returns nothing where neither is stated
[[nodiscard]] std::optional<Check> checkProjectionStd(const AnyCamera& camera, ImageSize size,
                                                      std::span<const double> covariance,
                                                      const std::optional<ProjectionStdClaim>& claim);

}  // namespace alidade
