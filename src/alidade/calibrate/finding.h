// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "alidade/core/verdict.h"

namespace alidade {

/// Something the user must know before trusting a result.
struct Finding {
  enum class Severity {
    kNote,     ///< worth knowing; the result does not suffer
    kWarning,  ///< a reservation: the result may be worse than it looks
    kFailure,  ///< the result is not to be used
  };
  Severity severity = Severity::kWarning;
  std::string id;         ///< stable, for scripts: "fronto_parallel"
  std::string cause;      ///< what is wrong, in a few words
  std::string evidence;   ///< the figures that show it; may be empty
  std::string next_step;  ///< what to do about it

  /// Cause and evidence in one sentence.
  [[nodiscard]] std::string message() const { return evidence.empty() ? cause : cause + ": " + evidence; }
};

/// Stable name for JSON.
[[nodiscard]] constexpr std::string_view severityName(Finding::Severity severity) {
  switch (severity) {
    case Finding::Severity::kNote:
      return "note";
    case Finding::Severity::kWarning:
      return "warning";
    case Finding::Severity::kFailure:
      return "failure";
  }
  return "unknown";
}

/// The worst finding decides.
[[nodiscard]] constexpr Verdict verdictOf(std::span<const Finding> findings) {
  Verdict verdict = Verdict::kTrustworthy;
  for (const Finding& finding : findings) {
    if (finding.severity == Finding::Severity::kFailure) return Verdict::kNo;
    if (finding.severity == Finding::Severity::kWarning) verdict = Verdict::kReservations;
  }
  return verdict;
}

}  // namespace alidade
