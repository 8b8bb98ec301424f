// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "alidade/core/diagnosis.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// The check "projection_std": are the stated standard deviations of pixels (at infinity, the best rotation
/// taken out) those that the covariance leads to? They are recomputed (see ProjectionUncertainty) and may
/// differ by what four digits round, and by what double precision loses where large sigmas cancel.
///
/// Without a covariance there is nothing to recompute from, so that what is stated is a warning, as is a
/// covariance without it.
/// @returns nothing where neither is stated
[[nodiscard]] std::optional<Diagnosis> checkProjectionStd(const CameraRecord& record);

}  // namespace alidade
