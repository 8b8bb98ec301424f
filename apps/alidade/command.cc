// SPDX-License-Identifier: MIT
#include "command.h"

#include <span>
#include <string_view>

#include <fmt/format.h>

#include "alidade/core/error_text.h"
#include "alidade/files/text/atomic_file.h"
#include "console.h"
#include "junit.h"

namespace alidade {

void Command::answer(const Answer& document, const Answer& text) {
  if (common_.json) {
    printResult(document());
    has_answered_ = true;
  } else if (!common_.quiet) {
    printResult(text());
  }
}

void Command::writeJunitError(const std::string& message) const {
  if (common_.junit.empty()) return;
  try {
    checkJunitPath(common_.junit);
    const TestCase failed{.kind = "command", .name = common_.command, .error = message};
    writeFileAtomically(common_.junit, junitText("alidade " + common_.command, std::span(&failed, 1)));
  } catch (const Error&) {
    return;  // the first error is the one to tell
  }
}

Error Command::missing(const std::string& found, const std::string& expected) const {
  // For a missing flag, its value is the next step; for an input, the help.
  return misuse(found, expected, found.starts_with("no --") ? "" : "alidade " + common_.command + " --help");
}

Error Command::misuse(const std::string& found, const std::string& expected,
                      const std::string& next_step) const {
  return usageError({.where = common_.command, .found = found, .expected = expected, .next_step = next_step});
}

std::string Command::maker() const {
  return programName() + " " + common_.command;
}

Error flagError(const std::string& flag, const std::string& found, const std::string& expected,
                const std::string& next_step) {
  return usageError({.where = flag, .found = found, .expected = expected, .next_step = next_step});
}

Error noneUsableError(std::size_t num_images, const std::string& complaint, const std::string& first_error) {
  constexpr std::string_view kNextLine = "\n  next: ";
  const std::size_t end = first_error.find(kNextLine);
  const bool has_next = end != std::string::npos;
  return inputError({.where = fmt::format("{} images", num_images),
                     .found = complaint + "; the first error: " + oneLine(first_error.substr(0, end)),
                     .next_step = has_next ? oneLine(first_error.substr(end + kNextLine.size())) : ""});
}

}  // namespace alidade
