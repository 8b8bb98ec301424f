// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/record/camera_record.h"
#include "alidade/validate/held_out/held_out_images.h"

namespace alidade {

/// Largest error of a camera that is not called wrong, px; docs/comparing.md derives it.
inline constexpr double kDefaultTolerancePx = 0.2;

/// Findings from held-out images as checks: `held_out_error`, whether the camera predicts corners, and
/// `images_agree`, whether it is the camera that the images show. A camera fails if it is off by more than
/// chance and, according to the images, by more than the tolerance. If the images cannot decide, the result
/// is a warning.
[[nodiscard]] std::vector<Diagnosis> heldOutChecks(const HeldOutJudgement& judgement, double tolerance_px);

/// The slip that `images_agree` names; nothing if it names none.
[[nodiscard]] const Slip* namedSlip(const HeldOutJudgement& judgement, double tolerance_px);

/// The check `stated_accuracy`: whether the camera is as close to the one that the images show as its file
/// states. A note if the images cannot decide.
[[nodiscard]] Diagnosis statedAccuracyCheck(double accuracy_px, const HeldOutJudgement& judgement);

/// The check `against`: the difference to another camera, after the best rotation.
[[nodiscard]] Diagnosis againstCheck(const ComparedCamera& camera, const ComparedCamera& other,
                                     double tolerance_px);

/// The check `own_images`: whether the camera was calibrated from these images. An image counts as one of
/// them if the mean of its corners lies within 0.5 px of a recorded one.
/// @param recorded  see CalibrationRecord::view_centers
[[nodiscard]] Diagnosis ownImagesCheck(std::span<const Eigen::Vector2d> recorded,
                                       std::span<const View> views);

}  // namespace alidade
