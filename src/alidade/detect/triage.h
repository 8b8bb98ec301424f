// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/detect/survey.h"

namespace alidade {

/// Looks at the images of one camera together and takes the corners from those that must not be used, see
/// surveyImages(). Images much more blurred than the others keep their corners and are named.
/// @param outcomes  in natural order of their names
std::vector<SurveyNote> triage(std::span<ImageOutcome> outcomes, const Checkerboard& board);

}  // namespace alidade
