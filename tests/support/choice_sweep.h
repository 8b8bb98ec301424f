// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/calibrate/calibrator.h"
#include "support/user_views.h"

namespace alidade {

/// Views by a lens of a known model, in the fields that it is made for: perspective models 60 to 110 degrees
/// across the longer side, the others 110 to 190 (fov, which bends more and more, to 150). 12 to 40 views,
/// noise of 0.1 px. The true lens does not fold inside the image: no calibration that does is trusted.
struct ChoiceSet {
  DrawnCamera drawn;
  double fov_deg = 0;
  UserSet set;
};

/// @param num_views  instead of those drawn
[[nodiscard]] ChoiceSet drawChoiceSet(std::string_view model_id, std::uint64_t seed, std::uint64_t number,
                                      std::optional<int> num_views = std::nullopt);

/// Is `small` the same lens as `large` with parameters of `large` at zero (or where they do nothing)?
[[nodiscard]] bool isNested(std::string_view small, std::string_view large);

/// Models that cannot follow most lenses of this one.
[[nodiscard]] std::vector<std::string> modelsTooLeanFor(std::string_view model_id);

/// What was chosen, beside the truth.
enum class ChoiceVerdict {
  kTrue,    ///< the model that the views were drawn with
  kNested,  ///< one that it contains, which predicts corners as well
  kEqual,   ///< another one with no more parameters, which predicts corners as well
  kOther
};

[[nodiscard]] ChoiceVerdict judgeChoice(std::string_view true_model, const Calibration& result);

/// Of the image, the part where a calibration is wrong beyond what it states: far points more than 1 px
/// and 3 stated sigmas from where the true camera has them, the rotation taken out that fits where corners
/// were. NaN where it states no uncertainty.
[[nodiscard]] double shareAstray(const AnyCamera& truth, std::span<const View> views,
                                 const Calibration& result);

[[nodiscard]] bool hasFinding(const Calibration& result, std::string_view id);

}  // namespace alidade
