// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/validate/camera_checks.h"

namespace alidade {

/// All that `validate` found out.
struct ValidationResult {
  std::vector<FileJudgement> files;
  std::vector<std::string> other_files;  ///< in folders; not camera files
  bool is_strict = false;                ///< a warning fails a file

  [[nodiscard]] bool isFailed(const FileJudgement& file) const;
};

/// A line for each file, and the totals. With `is_verbose`, each check has a line too.
[[nodiscard]] std::string judgementText(const ValidationResult& result, bool is_verbose);

/// A line for each file that failed; empty if there is none.
[[nodiscard]] std::string failuresText(const ValidationResult& result);

[[nodiscard]] std::string judgementJson(const ValidationResult& result);

/// JUnit XML: a test case for each file.
[[nodiscard]] std::string junitText(const ValidationResult& result);

}  // namespace alidade
