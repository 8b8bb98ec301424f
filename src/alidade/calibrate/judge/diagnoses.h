// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/calibrate/judge/evidence.h"

namespace alidade::detail {

// Each function adds the diagnoses that apply. A further diagnosis is a function in one of the files
// X_diagnoses.cc, its name in the list at the end of the file, and a row of kDiagnosisKinds.

void diagnoseFit(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void diagnoseLens(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void diagnoseViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
/// Errors common to all views, and variation between views that should not exist.
void diagnoseErrorPatterns(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void diagnoseBoards(const Evidence& of, std::vector<Diagnosis>& diagnoses);

}  // namespace alidade::detail
