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

/// The slip that `images_agree` names; nothing if it names none.
[[nodiscard]] const Slip* namedSlip(const HeldOutJudgement& judgement, double tolerance_px);

/// The check `stated_accuracy`: whether the camera is as near to the one that the images show as its file
/// states. A note where the images cannot tell.
[[nodiscard]] Diagnosis statedAccuracyCheck(double accuracy_px, const HeldOutJudgement& judgement);

/// The check `against`: the difference to another camera, the rotation taken out.
[[nodiscard]] Diagnosis againstCheck(const ComparedCamera& camera, const ComparedCamera& other,
                                     double tolerance_px);

/// The check `own_images`: whether the camera was calibrated from these images. It is assumed of an image
/// whose mean of the corners lies within 0.5 px of a recorded one.
/// @param recorded  see CalibrationRecord::view_centers
[[nodiscard]] Diagnosis ownImagesCheck(std::span<const Eigen::Vector2d> recorded,
                                       std::span<const View> views);

}  // namespace alidade
