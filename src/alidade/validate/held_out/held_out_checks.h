// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/record/camera_record.h"
#include "alidade/validate/held_out/held_out_images.h"

namespace alidade {

/// By how much a camera may be off before it is called wrong, px: see docs/comparing.md for where it comes
/// from.
inline constexpr double kDefaultTolerancePx = 0.2;

/// What held-out images say as checks: `held_out_error`, whether the camera predicts corners, and
/// `images_agree`, whether it is the camera that the images show. A camera fails where it is off by more than
/// chance and, as far as the images tell, by more than the tolerance; where they cannot tell, that is a
/// warning.
[[nodiscard]] std::vector<Diagnosis> heldOutChecks(const HeldOutJudgement& judgement, double tolerance_px);

/// The check `against`: the difference to another camera, the rotation taken out.
[[nodiscard]] Diagnosis againstCheck(const ComparedCamera& camera, const ComparedCamera& other,
                                     double tolerance_px);

/// The check `held_out_names`: whether images are those that the camera was made from, which is so where both
/// name (without folders) and pose of the board are those of a view that the file records.
/// @param recorded  the file's views, at least one
/// @param views     of the images, as the tested camera sees them
/// @param num_given  images with a board
[[nodiscard]] Diagnosis ownImagesCheck(std::span<const ViewRecord> recorded, const Checkerboard& board,
                                       std::span<const HeldOutView> views, int num_given);

}  // namespace alidade
