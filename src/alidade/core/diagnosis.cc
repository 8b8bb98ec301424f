// SPDX-License-Identifier: MIT
#include "alidade/core/diagnosis.h"

#include <algorithm>
#include <mutex>
#include <set>

namespace alidade {

DiagnosisId DiagnosisId::read(std::string_view id) {
  static std::mutex mutex;
  static std::set<std::string, std::less<>> others;  // diagnoses point into its text, so it is never
                                                     // destroyed
  const auto* const known = std::ranges::find(kDiagnosisKinds, id, &DiagnosisKind::id);
  DiagnosisId result;
  std::string_view& text = result;
  const std::lock_guard lock(mutex);
  text = known != std::end(kDiagnosisKinds) ? known->id : *others.emplace(id).first;
  return result;
}

DiagnosisKind DiagnosisId::kind() const {
  const auto* const known =
      std::ranges::find(kDiagnosisKinds, static_cast<std::string_view>(*this), &DiagnosisKind::id);
  return known == std::end(kDiagnosisKinds) ? DiagnosisKind{.id = *this, .subject = Subject::kTest} : *known;
}

Severity severityOf(double effect_px, double tolerance_px) {
  constexpr double kWarningShare = 0.25;
  constexpr double kFailureFactor = 5;
  if (effect_px > kFailureFactor * tolerance_px) return Severity::kFailure;
  return effect_px >= kWarningShare * tolerance_px ? Severity::kWarning : Severity::kNote;
}

Verdict verdictOf(const std::vector<Diagnosis>& diagnoses) {
  Severity worst = Severity::kPass;
  for (const Diagnosis& diagnosis : diagnoses) worst = std::max(worst, diagnosis.severity);
  return worst == Severity::kFailure   ? Verdict::kNo
         : worst == Severity::kWarning ? Verdict::kReservations
                                       : Verdict::kTrustworthy;
}

void sortDiagnoses(std::vector<Diagnosis>& diagnoses) {
  const auto rankOf = [](const Diagnosis& d) { return d.is_cause ? Rank::kCause : d.id.kind().rank; };
  std::ranges::stable_sort(diagnoses, [&](const Diagnosis& a, const Diagnosis& b) {
    return a.severity != b.severity ? a.severity > b.severity : rankOf(a) < rankOf(b);
  });
}

}  // namespace alidade
