// SPDX-License-Identifier: MIT
#include "alidade/calibrate/judge/judge.h"

#include <algorithm>
#include <cmath>

#include "alidade/adjust/errors.h"
#include "alidade/calibrate/judge/diagnoses.h"

namespace alidade {
namespace {

using Judgement = void (*)(const Evidence&, std::vector<Diagnosis>&);

// A further diagnosis is a function and its line here. Among equals, this is the order in which they are
// told.
constexpr Judgement kJudgements[] = {
    notConverged,
    notSettled,
    cornersOutsideDomain,
    foldsInImage,
    principalPointOutside,
    undetermined,
    viewsDisagree,
    inaccurate,
    misfit,
    modelTooLean,
    lensDeviates,
    fewViews,
    ambiguousOptimum,
    focalChanged,
    rollingShutter,
    boardNotSquare,
    oddAspect,
    bentBoard,
    bendIgnored,
    influentialViews,
    poorCoverage,
    illConditioned,
    parameterAtLimit,
    pixelsWithoutRay,
    bendUnknown,
    mirroredViews,
    viewsLeftOut,
    outliers,
    repeatedViews,
};

}  // namespace

double Evidence::smoothness() const {
  return weightedRms(fit) / std::sqrt(2.0) / uncertainty.local_sigma_px;
}

std::vector<Diagnosis> judge(const Evidence& evidence) {
  std::vector<Diagnosis> diagnoses;
  for (const Judgement judgement : kJudgements) judgement(evidence, diagnoses);
  std::stable_sort(diagnoses.begin(), diagnoses.end(),
                   [](const Diagnosis& a, const Diagnosis& b) { return a.severity > b.severity; });
  return diagnoses;
}

}  // namespace alidade
