// SPDX-License-Identifier: MIT
#pragma once

#include "alidade/calibrate/judge/judge.h"

namespace alidade {

// Each adds its diagnosis where there is reason to.

// How the fit came about and what its errors show.
void notConverged(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void notSettled(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void parameterAtLimit(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void misfit(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void modelTooLean(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void unsharp(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void systematicErrors(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void noiseExceeded(const Evidence& of, std::vector<Diagnosis>& diagnoses);

// The board.
void bentBoard(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void bendIgnored(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void bendUnknown(const Evidence& of, std::vector<Diagnosis>& diagnoses);

// The camera, and what the views leave open of it.
void cornersOutsideDomain(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void principalPointOutside(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void oddAspect(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void unobservable(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void fewViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void illConditioned(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void modelDependent(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void ambiguousOptimum(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void domainEndsInImage(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void poorCoverage(const Evidence& of, std::vector<Diagnosis>& diagnoses);

// Corners and views.
void outliers(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void viewsLeftOut(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void viewsDisagree(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void repeatedViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void influentialViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void mirroredViews(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void boardNotSquare(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void focalChanged(const Evidence& of, std::vector<Diagnosis>& diagnoses);
void rollingShutter(const Evidence& of, std::vector<Diagnosis>& diagnoses);

}  // namespace alidade
