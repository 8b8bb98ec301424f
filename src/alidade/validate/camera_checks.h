// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/diagnosis.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// "PASS", "WARN" or "FAIL".
[[nodiscard]] std::string_view checkStatusName(Severity severity);

/// What to bear in mind about the file that a record comes from.
struct RecordContext {
  /// Does the file's format have room for a domain, self-check points, a covariance and a verdict? If not,
  /// they are not missed.
  bool can_say_more = true;
  /// The file does not state `image_size`: what rests on it is a warning at most.
  bool is_size_guessed = false;
};

/// A diagnosis for each question asked of a camera, with what was found and what is accepted. Focal lengths,
/// aspect, principal point, one-to-one over the image, the stated domain, self-check points,
/// covariance, the uncertainty of pixels, and what the calibration said of itself.
[[nodiscard]] std::vector<Diagnosis> checkCamera(const CameraRecord& record,
                                                 const RecordContext& context = {});

}  // namespace alidade
