// SPDX-License-Identifier: MIT
#include "alidade/core/error.h"

#include <cstddef>

namespace alidade {
namespace {

std::string compose(const ErrorDetail& d) {
  std::string text = d.where;
  // Escaped, because a file name must not be able to forge a line of the message.
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos;) text.replace(i, 1, "\\x0a");
  if (!d.found.empty()) text += (text.empty() ? "" : ": ") + d.found;
  if (!d.expected.empty()) text += (text.empty() ? "expected " : "; expected ") + d.expected;
  if (!d.next_step.empty()) text += "\n  next: " + d.next_step;
  // Escaped, because what() would end at a zero byte from the input.
  for (std::size_t i = 0; (i = text.find('\0', i)) != std::string::npos;) text.replace(i, 1, "\\0");
  return text;
}

}  // namespace

Error::Error(ErrorCode code, const ErrorDetail& detail) : std::runtime_error(compose(detail)), code_(code) {}

void expect(bool condition, const char* message) {
  if (!condition) throw std::logic_error(std::string("broken precondition: ") + message);
}

}  // namespace alidade
