// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <string_view>
#include <vector>

#include "alidade/core/diagnosis.h"

namespace alidade {

// Which diagnosis to read first.

/// Whether the photographs or the settings themselves are wrong, so that more photographs of the same kind
/// cannot help.
[[nodiscard]] constexpr bool isWrongInput(std::string_view id) {
  return id == "two_cameras" || id == "model_too_lean" || id == "views_disagree" || id == "focal_changed" ||
         id == "corners_outside_domain" || id == "not_simultaneous" || id == "camera_moved" ||
         id == "same_images";
}

/// Whether it follows from others as a rule: large errors of any cause.
[[nodiscard]] constexpr bool isConsequence(std::string_view id) {
  return id == "misfit" || id == "inaccurate" || id == "poor_coverage" || id == "focal_uncertain" ||
         id == "centre_moves" || id == "focus_breathes" || id == "weak_link";
}

/// The most severe first; of equally severe ones causes before consequences.
inline void sortDiagnoses(std::vector<Diagnosis>& diagnoses) {
  const auto rank = [](const Diagnosis& d) { return isWrongInput(d.id) ? 0 : isConsequence(d.id) ? 2 : 1; };
  std::stable_sort(diagnoses.begin(), diagnoses.end(), [&](const Diagnosis& a, const Diagnosis& b) {
    return a.severity != b.severity ? a.severity > b.severity : rank(a) < rank(b);
  });
}

}  // namespace alidade
