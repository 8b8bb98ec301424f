// SPDX-License-Identifier: MIT
#include "command.h"

#include <string_view>

#include <fmt/format.h>

#include "alidade/core/error_text.h"

namespace alidade {

Error missingError(const std::string& command, const std::string& found, const std::string& expected) {
  // For a missing flag, its value is the next step; for an input, the help.
  return usageError({.where = command,
                     .found = found,
                     .expected = expected,
                     .next_step = found.starts_with("no --") ? "" : "alidade " + command + " --help"});
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
