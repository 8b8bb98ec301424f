// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/record/camera_record.h"

namespace alidade {

enum class CheckStatus { kPass, kWarn, kFail };

/// "PASS", "WARN" or "FAIL".
[[nodiscard]] std::string_view checkStatusName(CheckStatus status);

/// One question asked of a camera, with its answer.
struct Check {
  std::string id;  ///< stable, for scripts
  CheckStatus status = CheckStatus::kPass;
  std::string value;          ///< what was found
  std::string limit;          ///< what is accepted
  std::string message;        ///< one sentence
  bool is_undecided = false;  ///< a warning, as what there is to judge by cannot tell
};

/// What to bear in mind about the file that a record comes from.
struct RecordContext {
  /// Does the file's format have room for a domain, self-check points, a covariance and a verdict? If not,
  /// they are not missed.
  bool can_say_more = true;
  /// The file does not state `image_size`: what rests on it is a warning at most.
  bool is_size_guessed = false;
};

/// Focal lengths, aspect, principal point, one-to-one over the image, the stated domain, self-check points,
/// covariance, the uncertainty of pixels, and what the calibration said of itself.
[[nodiscard]] std::vector<Check> checkCamera(const CameraRecord& record, const RecordContext& context = {});

}  // namespace alidade
