// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/core/verdict.h"

namespace alidade {

enum class Severity {
  kPass,     ///< a check that found no problem
  kNote,     ///< for information; the result is not affected
  kWarning,  ///< a reservation: the result may be worse than it looks
  kFailure,  ///< the result must not be used
};

/// What a calibration, a file check or a detection found, and what the user should do about it.
struct Diagnosis {
  Severity severity = Severity::kWarning;
  std::string id;              ///< stable, for scripts: "fronto_parallel"
  std::string cause;           ///< what is wrong
  std::string evidence = {};   ///< the computed value; may be empty
  std::string limit = {};      ///< the limit for it; empty if there is no limit
  std::string next_step = {};  ///< what to do about it; may be empty
  /// By how many pixels (95 %) the cause may displace projected points in the part of the image that the
  /// views cover; NaN if that is not the question.
  double effect_px = std::numeric_limits<double>::quiet_NaN();
  /// The data do not decide this, but more views could. The covariance includes what the data do show.
  bool is_undecided = false;

  /// Cause and evidence in one sentence.
  [[nodiscard]] std::string message() const { return evidence.empty() ? cause : cause + ": " + evidence; }
};

/// The severity of a cause that may displace projected points by `effect_px`, for a user who accepts
/// `tolerance_px`: a note below a quarter of it, a failure above five times it. NaN: a note.
[[nodiscard]] constexpr Severity severityOf(double effect_px, double tolerance_px) {
  constexpr double kWarningShare = 0.25;
  constexpr double kFailureFactor = 5;
  if (effect_px > kFailureFactor * tolerance_px) return Severity::kFailure;
  return effect_px >= kWarningShare * tolerance_px ? Severity::kWarning : Severity::kNote;
}

/// Stable name for JSON.
[[nodiscard]] constexpr std::string_view severityName(Severity severity) {
  constexpr std::array<std::string_view, 4> kNames = {"pass", "note", "warning", "failure"};
  return kNames[static_cast<std::size_t>(severity)];
}

/// The verdict that follows from the most severe diagnosis.
[[nodiscard]] constexpr Verdict verdictOf(const std::vector<Diagnosis>& diagnoses) {
  Verdict verdict = Verdict::kTrustworthy;
  for (const Diagnosis& diagnosis : diagnoses) {
    if (diagnosis.severity == Severity::kFailure) return Verdict::kNo;
    if (diagnosis.severity == Severity::kWarning) verdict = Verdict::kReservations;
  }
  return verdict;
}

}  // namespace alidade
