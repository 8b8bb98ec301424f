// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include "flags.h"

namespace alidade {

/// A test case of a JUnit report.
struct TestCase {
  std::string kind;                         ///< "camera_file"; its class name
  std::string name;                         ///< of the file or camera
  std::optional<std::string> failure = {};  ///< the reason; nothing if it passed
  std::optional<std::string> skipped = {};  ///< why it was not tested; nothing if it was
  std::string text = {};                    ///< details
  std::optional<std::string> error = {};    ///< why there is no answer; nothing if there is one
};

/// A JUnit report as CI servers read it. @param suite  "alidade validate"
[[nodiscard]] std::string junitText(const std::string& suite, std::span<const TestCase> cases);

/// The flag --junit.
void addJunitFlag(Flags& flags, CommonOptions& options);

/// Checks that a report may be written here: a new file, or an earlier report.
/// @throws Error (kUsage)
void checkJunitPath(const std::string& path);

}  // namespace alidade
