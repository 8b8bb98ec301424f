// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/diagnosis.h"

namespace alidade {

/// A number that a check computed or compared with. Its name ends in the unit: "fx_px"; shares have none.
struct CheckValue {
  std::string name;
  double value = 0;
};

/// A question that was asked of a camera file, and the answer.
struct FileCheck {
  Severity severity = Severity::kPass;
  std::string id;                       ///< stable, for scripts: "focal_length"
  std::string message;                  ///< the answer, with value and limit
  std::vector<CheckValue> values = {};  ///< what the message says in numbers
};

/// "PASS", "NOTE", "WARN" or "FAIL".
[[nodiscard]] std::string_view checkStatusName(Severity severity);

/// A diagnosis as a check without numbers.
[[nodiscard]] FileCheck fileCheck(const Diagnosis& diagnosis);

}  // namespace alidade
