// SPDX-License-Identifier: MIT
#include "alidade/calibrate/judge/judge.h"

#include <algorithm>
#include <iterator>

#include "alidade/calibrate/judge/diagnoses.h"

namespace alidade::detail {

std::vector<Diagnosis> judge(const Evidence& evidence) {
  std::vector<Diagnosis> diagnoses;
  for (const auto& diagnose :
       {diagnoseFit, diagnoseLens, diagnoseViews, diagnoseErrorPatterns, diagnoseBoards})
    diagnose(evidence, diagnoses);
  std::ranges::stable_sort(diagnoses, {}, [](const Diagnosis& diagnosis) {
    return std::ranges::find(kDiagnosisKinds, diagnosis.id, &DiagnosisKind::id) - std::begin(kDiagnosisKinds);
  });
  sortDiagnoses(diagnoses);
  return diagnoses;
}

}  // namespace alidade::detail
