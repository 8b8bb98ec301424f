// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/verdict.h"

namespace alidade {

enum class Severity {
  kPass,     ///< a check that found nothing wrong
  kNote,     ///< worth knowing; the result does not suffer
  kWarning,  ///< a reservation: the result may be worse than it looks
  kFailure,  ///< the result is not to be used
};

/// What a calibration, a check of a file or a detection found out, for the user to act on.
struct Diagnosis {
  Severity severity = Severity::kWarning;
  std::string id;              ///< stable, for scripts: "fronto_parallel"
  std::string cause;           ///< what is wrong
  std::string evidence = {};   ///< the value that was found; may be empty
  std::string limit = {};      ///< the value that is accepted; empty where there is none
  std::string next_step = {};  ///< what to do about it; may be empty
  /// The data cannot tell: more views could, and as far as they say something it is in the covariance.
  bool is_undecided = false;

  /// Cause and evidence in one sentence.
  [[nodiscard]] std::string message() const { return evidence.empty() ? cause : cause + ": " + evidence; }
};

/// Stable name for JSON.
[[nodiscard]] constexpr std::string_view severityName(Severity severity) {
  switch (severity) {
    case Severity::kPass:
      return "pass";
    case Severity::kNote:
      return "note";
    case Severity::kWarning:
      return "warning";
    case Severity::kFailure:
      return "failure";
  }
  return "unknown";
}

/// The worst diagnosis decides.
[[nodiscard]] constexpr Verdict verdictOf(const std::vector<Diagnosis>& diagnoses) {
  Verdict verdict = Verdict::kTrustworthy;
  for (const Diagnosis& diagnosis : diagnoses) {
    if (diagnosis.severity == Severity::kFailure) return Verdict::kNo;
    if (diagnosis.severity == Severity::kWarning) verdict = Verdict::kReservations;
  }
  return verdict;
}

}  // namespace alidade
