// SPDX-License-Identifier: MIT
#include "alidade/validate/file_check.h"

namespace alidade {

std::string_view checkStatusName(Severity severity) {
  switch (severity) {
    case Severity::kPass:
      return "PASS";
    case Severity::kNote:
      return "NOTE";
    case Severity::kWarning:
      return "WARN";
    case Severity::kFailure:
      return "FAIL";
  }
  return "UNKNOWN";
}

FileCheck fileCheck(const Diagnosis& diagnosis) {
  std::string message = diagnosis.message();
  if (diagnosis.severity > Severity::kNote && !diagnosis.limit.empty())
    message += "; limit: " + diagnosis.limit;
  return {.severity = diagnosis.severity, .id = diagnosis.id, .message = std::move(message)};
}

}  // namespace alidade
