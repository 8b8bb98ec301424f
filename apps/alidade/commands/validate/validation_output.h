// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/data/validation_data.h"

namespace alidade {

struct ValidationTotals {
  std::size_t num_files = 0;
  std::size_t num_failed = 0;
  std::size_t num_warned = 0;  ///< passed, with warnings
  std::size_t num_others = 0;
};
[[nodiscard]] ValidationTotals totalsOf(const ValidationResult& result);

/// "40 files: 38 passed (2 with warnings), 2 failed".
[[nodiscard]] std::string totalsText(const ValidationTotals& totals);
/// One line for each file, or only for those that failed.
[[nodiscard]] std::string filesText(const ValidationResult& result, bool only_failed);
/// One line for each check of each file.
[[nodiscard]] std::string checksText(const ValidationResult& result);
/// JUnit XML: a test case for each file.
[[nodiscard]] std::string junitText(const ValidationResult& result);

/// The details of the footage check: the changes tried, and their results. Lines are indented.
[[nodiscard]] std::string footageLines(const FootageJudgement& judgement);
/// The same for programs.
[[nodiscard]] nlohmann::json footageJson(const FootageJudgement& judgement);

/// All results for programs: one JSON document.
[[nodiscard]] std::string judgementJson(const ValidationResult& result);
/// The same with the errors of all corners and the comparison camera; the report page embeds it.
[[nodiscard]] nlohmann::json validationEvidence(const ValidationResult& result);

}  // namespace alidade
