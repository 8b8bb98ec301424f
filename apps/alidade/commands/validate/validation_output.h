// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "alidade/report/data/validation_data.h"

namespace alidade {

/// The number of files with this outcome: failed, passed with warnings, or passed.
[[nodiscard]] std::size_t numWith(const ValidationResult& result, Severity outcome);

/// "40 files: 38 passed (2 with warnings), 2 failed".
[[nodiscard]] std::string totalsText(const ValidationResult& result);
/// One line for each file, or only for those that failed.
[[nodiscard]] std::string filesText(const ValidationResult& result, bool only_failed);
/// One line for each check of each file.
[[nodiscard]] std::string checksText(const ValidationResult& result);
/// JUnit XML: a test case for each file; those without a camera are skipped.
[[nodiscard]] std::string junitText(const ValidationResult& result);

/// All results for programs: one JSON document.
[[nodiscard]] std::string judgementJson(const ValidationResult& result);
/// The same with the errors of all corners and the comparison camera; the report page embeds it.
[[nodiscard]] nlohmann::json validationEvidence(const ValidationResult& result);

}  // namespace alidade
