// SPDX-License-Identifier: MIT
#include "alidade/calibrate/judge/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "alidade/calibrate/uncertainty/aligned_difference.h"
#include "alidade/camera/projection_uncertainty.h"

namespace alidade::detail {

void addByEffect(const Evidence& of, Diagnosis diagnosis, double effect_px, std::vector<Diagnosis>& diagnoses,
                 Severity worst) {
  diagnosis.effect_px = effect_px;
  diagnosis.severity = std::min(severityOf(effect_px, of.tolerance_px), worst);
  diagnoses.push_back(std::move(diagnosis));
}

double effectOfStep(const Evidence& of, const Eigen::VectorXd& params_step) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  if (!of.uncertainty.accuracy) return largest;
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  const ProjectionUncertainty projection(of.camera, onlyCamera(of.fit).size, accuracy.distance_m);
  for (std::size_t i = 0; i < accuracy.is_covered.size(); ++i) {
    const int at = static_cast<int>(i);
    if (accuracy.is_covered[i] && projection.hasRay(at))
      largest = std::fmax(largest, (projection.jacobian(at) * params_step).norm());
  }
  return largest;
}

double effectOfCamera(const Evidence& of, const AnyCamera& other) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  if (!of.uncertainty.accuracy) return largest;
  const Accuracy& accuracy = *of.uncertainty.accuracy;
  std::vector<Eigen::Vector2d> covered;
  for (std::size_t i = 0; i < accuracy.is_covered.size(); ++i) {
    if (accuracy.is_covered[i]) covered.push_back(accuracy.pixels[i]);
  }
  for (const double difference : alignedDifferences(of.camera, other, covered, covered, accuracy.distance_m))
    largest = std::fmax(largest, difference);
  return largest;
}

double coveredError(const Evidence& of) {
  return of.uncertainty.accuracy ? of.uncertainty.accuracy->covered_px
                                 : std::numeric_limits<double>::quiet_NaN();
}

double halfDiagonal(const Evidence& of) {
  const ImageSize size = onlyCamera(of.fit).size;
  return 0.5 * std::hypot(size.width, size.height);
}

}  // namespace alidade::detail
