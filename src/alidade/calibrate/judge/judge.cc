// SPDX-License-Identifier: MIT
#include "alidade/calibrate/judge/judge.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <utility>

#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/camera/projection_uncertainty.h"

namespace alidade::detail {

void Evidence::add(Diagnosis diagnosis, double effect_px, Severity worst) {
  diagnosis.effect_px = effect_px;
  diagnosis.severity = std::min(severityOf(effect_px, tolerance_px), worst);
  diagnoses.push_back(std::move(diagnosis));
}

double effectOfStep(const Evidence& of, std::span<const double> params_step) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  if (!of.uncertainty.accuracy) return largest;
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  const Eigen::VectorXd step = Eigen::Map<const Eigen::VectorXd>(params_step.data(), std::ssize(params_step));
  const ProjectionUncertainty projection(of.camera, onlyCamera(of.fit).size, accuracy.distance_m);
  for (std::size_t i = 0; i < accuracy.is_covered.size(); ++i) {
    const int at = static_cast<int>(i);
    if (accuracy.is_covered[i] && projection.hasRay(at))
      largest = std::fmax(largest, (projection.jacobian(at) * step).norm());
  }
  return largest;
}

double effectOfCamera(const Evidence& of, const AnyCamera& other) {
  if (!of.uncertainty.accuracy) return std::numeric_limits<double>::quiet_NaN();
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  return largestDifference(of.camera, other, coveredPixels(accuracy.pixels, accuracy.is_covered),
                           accuracy.distance_m);
}

double halfDiagonal(const Evidence& of) {
  const ImageSize size = onlyCamera(of.fit).size;
  return 0.5 * std::hypot(size.width, size.height);
}

std::vector<Diagnosis> judge(Evidence evidence) {
  for (const auto& diagnose : {diagnoseLens, diagnoseViews, diagnoseBoards}) diagnose(evidence);
  // A lens that was given is not at fault for what these views do not tell.
  if (isFocalUnknown(evidence) && evidence.uncertainty.free_directions.cols() > 0) {
    for (Diagnosis& diagnosis : evidence.diagnoses) {
      if (diagnosis.id.kind().needs_focal) diagnosis.severity = Severity::kNote;
    }
  }
  std::ranges::stable_sort(evidence.diagnoses, {}, [](const Diagnosis& diagnosis) {
    return std::ranges::find(kDiagnosisKinds, diagnosis.id, &DiagnosisKind::id) - std::begin(kDiagnosisKinds);
  });
  sortDiagnoses(evidence.diagnoses);
  return std::move(evidence.diagnoses);
}

}  // namespace alidade::detail
