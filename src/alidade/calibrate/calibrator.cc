// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibrator.h"

#include <utility>

#include "alidade/calibrate/choose/model_choice.h"
#include "alidade/calibrate/judge/judge.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

void setAccuracy(std::vector<AnyCamera> alternatives, double distance_m, Calibration& now) {
  if (!now.uncertainty.covariance) return;
  for (const OtherOptimum& other : now.uncertainty.other_optima)
    alternatives.push_back(AnyCamera::make(onlyCamera(now.fit).model, other.params));
  now.uncertainty.accuracy = accuracyOf(now.fit, now.uncertainty, alternatives, distance_m);
}

// At rest under normalisation, which reading a file does: what was written is then read back the same.
SE3 settled(SE3 pose) {
  constexpr int kEnough = 16;  // each round has about an even chance
  for (int i = 0; i < kEnough; ++i) {
    const SO3 next = SO3::fromQuaternion(pose.rotation.quaternion());
    if (next.quaternion().coeffs() == pose.rotation.quaternion().coeffs()) break;
    pose.rotation = next;
  }
  return pose;
}

// As the caller knows the views: with their names, and by their indices among those that were given.
void nameViews(const PreparedViews& given, Calibration& calibration) {
  for (FitView& view : calibration.fit.views) {
    view.image = given.views[view.source].image;
    view.source = given.sources[view.source];
  }
  for (Outlier& outlier : calibration.dropped.outliers) outlier.source = given.sources[outlier.source];
}

// All but the diagnoses.
Calibration calibrationOf(ModelSolution solution, const PreparedViews& given,
                          const CalibratorOptions& options) {
  const bool is_flat = options.board_shape == BoardShapeMode::kFlat;
  Calibration now{.fit = std::move(solution.fit), .choice = std::move(solution.choice)};
  now.uncertainty =
      uncertaintyOf(now.fit, is_flat ? ignoredBend(now.fit) : std::nullopt,
                    mapped(now.choice.shapes, &ShapeReport::std_m), solution.close_params, options.cancel);
  const std::vector<std::string> names =
      mapped(now.fit.views, [&](const FitView& view) { return given.views[view.source].image; });
  const double sigma_px = now.uncertainty.coordinate_sigma_px;
  now.uncertainty.two_cameras = twoCameras(now.fit, names, sigma_px * sigma_px);
  now.dropped = droppedFrom(now.fit, given, options.cancel);
  now.domain = certifyDomain(now.camera(), now.imageSize());
  for (FitPlacement& placement : now.fit.placements)
    placement.rig_from_board = settled(placement.rig_from_board);
  return now;
}

Calibration chosenByHeldOutErrors(const PreparedViews& given, const CalibratorOptions& options) {
  ChosenModel chosen = chooseModel(given, options);
  Calibration now = calibrationOf(std::move(chosen.solution), given, options);
  setAccuracy(std::move(chosen.rivals), options.distance_m, now);
  now.choice.model = std::move(chosen.choice);
  return now;
}

Calibration ofNamedModel(const PreparedViews& given, const CalibratorOptions& options) {
  Calibration now =
      calibrationOf(withDataSettled(fittedPlainly(given, options), given, options), given, options);
  now.choice.better_model = neededModel(now.fit, options.cancel);
  setAccuracy({}, options.distance_m, now);
  return now;
}

}  // namespace

std::vector<Diagnosis> judge(const Calibration& calibration, double tolerance_px) {
  const AnyCamera camera = calibration.camera();
  return judge(Evidence{.fit = calibration.fit,
                        .dropped = calibration.dropped,
                        .choice = calibration.choice,
                        .uncertainty = calibration.uncertainty,
                        .domain = calibration.domain,
                        .camera = camera,
                        .tolerance_px = tolerance_px});
}

Calibration calibrate(std::span<const Board> boards, std::vector<View> views,
                      const CalibratorOptions& options) {
  CalibratorOptions named = options;
  named.model = namedModel(options);
  if (named.model != kAutoModel)
    static_cast<void>(parameterNames(named.model));  // throws for an unknown model
  static_cast<void>(constraintOf(named));
  const PreparedViews given = prepareViews(boards, std::move(views));
  Calibration now =
      named.model == kAutoModel ? chosenByHeldOutErrors(given, named) : ofNamedModel(given, named);
  nameViews(given, now);
  now.diagnoses = judge(now, options.tolerance_px);
  return now;
}

Calibration calibrate(const Board& board, std::vector<View> views, const CalibratorOptions& options) {
  return calibrate(std::span(&board, 1), std::move(views), options);
}

}  // namespace alidade
