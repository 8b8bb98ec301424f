// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/judge/evidence.h"

namespace alidade::detail {

// Each adds the diagnoses for which there is a reason. A further diagnosis is a function in one of the files
// X_diagnoses.cc, its name in the list at the end of the file, and a row of kDiagnosisKinds.

void diagnoseFit(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void diagnoseLens(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void diagnoseViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
/// Errors that all views have in common, and what differs between views although it should not.
void diagnoseErrorPatterns(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void diagnoseBoards(const Evidence& of, std::vector<Diagnosis>& diagnoses);

}  // namespace alidade::detail
