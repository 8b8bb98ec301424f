// SPDX-License-Identifier: MIT
#include "alidade/calibrate/calibrator.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/adjust/noise/larger_model.h"
#include "alidade/calibrate/choose/model_solution.h"
#include "alidade/calibrate/clean/outliers.h"
#include "alidade/calibrate/clean/turned_views.h"
#include "alidade/calibrate/correct/correction_choice.h"
#include "alidade/calibrate/judge/judge.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/calibrate/uncertainty/uncertainty_of.h"
#include "alidade/camera/image_domain.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// Normalised until it no longer changes, as in the reader, so that a file reads back exactly as written.
SE3 settled(SE3 pose) {
  constexpr int kEnough = 16;  // rounds; each converges with a probability of about 1/2
  for (int i = 0; i < kEnough; ++i) {
    const SO3 next = SO3::fromQuaternion(pose.rotation.quaternion());
    if (next.quaternion().coeffs() == pose.rotation.quaternion().coeffs()) break;
    pose.rotation = next;
  }
  return pose;
}

// The fit of a model that the options name.
ModelSolution solutionOf(const PreparedViews& given, const CalibratorOptions& options) {
  return withDataSettled(fittedPlainly(given, options), given, options);
}

Calibration calibrationOf(ModelSolution solution, const PreparedViews& given,
                          const CalibratorOptions& options) {
  Fit& fit = solution.fit;
  Choice& choice = solution.choice;
  Uncertainty uncertainty = uncertaintyOf(solution, options);
  Dropped dropped = droppedFrom(fit, given, options.cancel);
  for (FitPlacement& placement : fit.placements) placement.rig_from_body = settled(placement.rig_from_body);
  if (!choice.model) choice.better_model = neededModel(fit, options.cancel);
  // Restore the caller's view indices.
  for (FitView& view : fit.views) view.source = given.sources[view.source];
  for (Outlier& outlier : dropped.outliers) outlier.source = given.sources[outlier.source];
  choice.is_pupil_undetermined = options.num_pupil.value_or(0) > 0 && !onlyCamera(fit).hasPupil();
  const AnyCamera camera = cameraOf(fit);
  DomainCertificate domain = certifyDomain(camera, onlyCamera(fit).size);
  Calibration result{.fit = std::move(fit),
                     .dropped = std::move(dropped),
                     .choice = std::move(choice),
                     .uncertainty = std::move(uncertainty),
                     .domain = std::move(domain)};
  result.diagnoses = judge(result, options.tolerance_px);
  return result;
}

// The models that predict corners no worse than the chosen one beyond chance, by less error than a warning
// needs; the best first.
std::vector<ModelCandidate> alternativesTo(const ModelCandidate& chosen, const ModelChoice& choice,
                                           double tolerance_px) {
  constexpr std::size_t kMost = 3;
  std::vector<ModelCandidate> others;
  for (const ModelCandidate& c : choice.candidates) {
    const double further =
        c.holdout_rms_px * c.holdout_rms_px - chosen.holdout_rms_px * chosen.holdout_rms_px;
    if (c.verdict == "larger" && std::isfinite(further) && std::isfinite(c.excess) &&
        severityOf(std::sqrt(std::max(0.0, further)), tolerance_px) == Severity::kNote)
      others.push_back(c);
  }
  std::ranges::stable_sort(others, {}, &ModelCandidate::excess);
  if (others.size() > kMost) others.resize(kMost);
  return others;
}

// True if the camera may be used, although each failure of the other one is among its diagnoses: it is a
// matter of degree, and the model does not hide the cause.
bool isUsableDespite(const Calibration& calibration, const std::vector<Diagnosis>& failed) {
  return calibration.isUsable() && std::ranges::all_of(failed, [&](const Diagnosis& d) {
           return d.severity != Severity::kFailure ||
                  std::ranges::find(calibration.diagnoses, d.id, &Diagnosis::id) !=
                      calibration.diagnoses.end();
         });
}

// The choice if another model is taken because the chosen one's camera failed.
ModelChoice withInstead(ModelChoice choice, std::string_view other, const Diagnosis& failure) {
  for (ModelCandidate& c : choice.candidates) {
    if (c.verdict == "chosen") {
      c.verdict = "rejected";
      c.reason = failure.id;
    } else if (c.id == other) {
      c.verdict = "chosen";
      c.reason = "";
    }
  }
  return choice;
}

// The model that predicts corners best may still give a camera that must not be used, where another one, not
// distinguishable by these views, gives a usable one.
Calibration calibrationOfChoice(const PreparedViews& given, const CalibratorOptions& options) {
  ModelSolution solution = chooseModel(given, options);
  std::vector<AnyCamera> rivals = solution.rivals;
  Calibration first = calibrationOf(std::move(solution), given, options);
  const auto is_beyond_models = [](const Diagnosis& d) {
    return d.severity != Severity::kFailure || isOfSpec(d);
  };
  if (std::ranges::all_of(first.diagnoses, is_beyond_models)) return first;
  const auto chosen = std::ranges::find(first.choice.model->candidates, "chosen", &ModelCandidate::verdict);
  rivals.push_back(first.camera());
  for (const ModelCandidate& other : alternativesTo(*chosen, *first.choice.model, options.tolerance_px)) {
    CalibratorOptions own = options;
    own.model = other.id;
    try {
      ModelSolution instead = solutionOf(given, own);
      std::ranges::copy_if(rivals, std::back_inserter(instead.rivals),
                           [&](const AnyCamera& rival) { return rival.modelId() != other.id; });
      instead.choice.model = withInstead(*first.choice.model, other.id, first.diagnoses.front());
      Calibration usable = calibrationOf(std::move(instead), given, own);
      if (isUsableDespite(usable, first.diagnoses)) return usable;
    } catch (const Error&) {  // no camera of this model explains the views
      continue;
    }
  }
  return first;
}

// True if a fit of the same images has clearly smaller errors, or about the same on clearly more corners.
bool explainsMore(const Fit& fit, const Fit& other) {
  constexpr double kMore = 1.02;
  constexpr double kSmaller = 0.97;
  constexpr double kAboutSame = 1.1;
  const double errors = weightedRms(fit) / weightedRms(other);
  const double corners = static_cast<double>(numCorners(fit)) / static_cast<double>(numCorners(other));
  return (errors < kSmaller && corners > 1 / kMore) || (errors < kAboutSame && corners > kMore);
}

// Rounded to a tenth of a pixel: enough to recognise an image by.
std::vector<Eigen::Vector2d> viewCenters(const Fit& fit) {
  constexpr double kTenths = 10;
  std::vector<Eigen::Vector2d> centers;
  for (const FitView& view : fit.views) {
    if (centers.size() == CalibrationRecord::kMaxViewCenters) break;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Observation& corner : view.corners) sum += seenPixel(onlyCamera(fit), corner.pixel);
    const Eigen::Vector2d mean = sum / static_cast<double>(view.corners.size());
    centers.emplace_back((kTenths * mean).array().round() / kTenths);
  }
  return centers;
}

// Rounded to three digits.
double rounded(double value) {
  return std::isfinite(value) ? *parseDouble(numberText("%.3g", value)) : value;
}

// Adds the boards that the views show.
void addBoards(const Calibration& of, CalibrationRecord& record) {
  for (std::size_t b = 0; b < of.fit.boards.size(); ++b) {
    const FitBoard& board = of.fit.boards[b];
    if (numViews(of.fit, b) == 0) continue;
    if (!board.is_shape_fixed && of.uncertainty.bend_std_m[b].allFinite()) {  // else it is unknown
      record.warps.push_back({.board = record.boards.size(),
                              .shape = {.bend_x_m = board.shape.bend_x_m, .bend_y_m = board.shape.bend_y_m},
                              .std_m = of.uncertainty.bend_std_m[b]});
    }
    record.boards.push_back(board.target.spec());
  }
}

CalibrationRecord calibrationRecord(const Calibration& of) {
  const Uncertainty& known = of.uncertainty;
  CalibrationRecord record{.verdict = of.verdict(),
                           .rms_px = rms(of.fit),
                           .holdout_rms_px = known.holdout.rms_px,
                           .num_views = static_cast<int>(of.fit.views.size()),
                           .num_corners = static_cast<int>(numCorners(of.fit)),
                           .boards = {},
                           .view_centers = viewCenters(of.fit)};
  if (known.accuracy) {
    record.accuracy_px = rounded(known.accuracy->covered_px);
    record.accuracy_distance_m = known.accuracy->distance_m;
    record.covered_share = rounded(known.accuracy->covered_share);
  }
  addBoards(of, record);
  for (const Diagnosis& diagnosis : of.diagnoses) {
    if (std::ranges::find(record.findings, std::string_view(diagnosis.id)) == record.findings.end())
      record.findings.emplace_back(diagnosis.id);
  }
  if (!known.covariance) return record;
  record.covariance = lowerTriangle(known.statedCovariance());
  record.is_covariance_by_views = known.isNoiseExceeded();
  for (int i = 0; i < known.covariance->rows(); ++i) record.parameter_std.push_back(known.parameterStd(i));
  record.pupil_std = known.pupil_std_m;
  return record;
}

// True if the views of a wide lens show that its rays do not meet at one point.
bool showsMovingPupil(const Calibration& of) {
  constexpr double kWideRad = 45 * std::numbers::pi / 180;  // off the axis
  constexpr double kSure = 4;
  const auto& errors = of.uncertainty.common_errors;
  const auto pupil = std::ranges::find(errors, CommonCause::kPupil, &CommonError::cause);
  if (pupil == errors.end() || !(pupil->sigmas() > kSure)) return false;
  return std::ranges::any_of(of.fit.views, [&](const FitView& view) {
    const SE3 pose = cameraFromBoard(of.fit, view);
    return std::ranges::any_of(view.corners, [&](const Observation& corner) {
      const Eigen::Vector3d p = pose * corner.p_board;
      return std::atan2(p.head<2>().norm(), p.z()) > kWideRad;
    });
  });
}

// True if the last number of the entrance pupil is certain and predicts corners significantly better.
bool needsPupil(Calibration& of, const CalibratorOptions& options) {
  constexpr double kSure = 4;
  FitCamera camera = onlyCamera(of.fit);
  const std::vector<double>& std_m = of.uncertainty.pupil_std_m;
  const double value_m = camera.params.back();
  if (std_m.empty() || EntrancePupil::complaint(value_m) || !(std::abs(value_m) > kSure * std_m.back()))
    return false;
  camera.params.pop_back();
  Fit without = of.fit;
  onlyCamera(without) = camera;
  without = solve(std::move(without), {.cancel = options.cancel});
  const auto errors = heldOutErrors(of.fit, options.jobs, options.cancel);
  const auto errors_without = heldOutErrors(without, options.jobs, options.cancel);
  if (!errors || !errors_without) return false;
  of.choice.pupil_excess = excessOf(scoreOf(*errors_without, without), scoreOf(*errors, of.fit));
  return of.choice.pupil_excess->is_significant;
}

// Of a pupil that was requested.
void requireLikelyPupil(const EntrancePupil& pupil) {
  for (const double value_m : {pupil.s1_m, pupil.s2_m}) {
    if (!EntrancePupil::complaint(value_m)) continue;
    throw inputError({.where = "entrance pupil",
                      .found = "a lens whose pupil would move by " + numberText("%.2g", value_m) + " m",
                      .expected = "millimetres",
                      .next_step = "check the board's size, or take the pupil as fixed: --pupil 0"});
  }
}

// Gives the camera of a calibration of corners that are free of a field this field.
void setCorrection(CorrectionPointer field, Calibration& calibration) {
  FitCamera& camera = onlyCamera(calibration.fit);
  camera.correction = std::move(field);
  for (Outlier& outlier : calibration.dropped.outliers) outlier.pixel = seenPixel(camera, outlier.pixel);
  calibration.domain = certifyDomain(calibration.camera(), camera.size);
}

// The choice if another model, which was worse alone, is taken with a field.
ModelChoice withField(ModelChoice choice, std::string_view model) {
  for (ModelCandidate& c : choice.candidates) {
    if (c.id == model) {
      c.verdict = "chosen";
      c.reason = "";
    } else if (c.verdict == "chosen") {
      c.verdict = "larger";
      c.reason = "not needed with a correction field";
    }
  }
  return choice;
}

// The models with which a field may be needed, the smallest first. A model that was chosen for its many
// parameters may bend them to what a field explains with less.
std::vector<std::string> modelsToCorrect(const Calibration& of) {
  std::vector<std::string> models;
  const std::string chosen = onlyCamera(of.fit).model;
  if (!of.choice.model) return {chosen};
  for (const ModelCandidate& c : of.choice.model->candidates) {
    constexpr double kNear = 3;  // times the errors; a field is no distortion
    const auto num_params = static_cast<std::size_t>(c.num_params);
    const bool is_smaller = num_params > kNumAffine && num_params < parameterNames(chosen).size();
    if (is_smaller && !modelTraits(c.id).is_stiff && c.rms_px < kNear * weightedRms(of.fit))
      models.push_back(c.id);
  }
  models.push_back(chosen);
  return models;
}

// A fit with a field, and how it was found.
struct Corrected {
  CorrectedFit with;
  Choice choice;
  std::vector<std::vector<double>> close_params;  // of other optima without the field
};

// With the smallest of these models that needs a field and then predicts corners better; nothing if none
// does.
std::optional<Corrected> neededCorrection(const Calibration& result, const PreparedViews& given,
                                          CalibratorOptions options) {
  const std::string chosen = onlyCamera(result.fit).model;
  const bool is_requested = options.correction_cells.has_value();
  if (!is_requested && !result.uncertainty.image_bias.isSeen()) return std::nullopt;
  for (const std::string& model : is_requested ? std::vector{chosen} : modelsToCorrect(result)) {
    try {
      CorrectionReport report;
      options.model = model;
      const Calibration base =
          model == chosen ? result : calibrationOf(solutionOf(given, options), given, options);
      std::optional<CorrectedFit> with = chooseCorrection(base.fit, options, report);
      if (!with || (model != chosen && !(report.holdout_rms_px < result.uncertainty.holdout.rms_px)))
        continue;
      Corrected corrected{.with = *std::move(with),
                          .choice = base.choice,
                          .close_params = mapped(base.uncertainty.other_optima, &OtherOptimum::params)};
      corrected.choice.correction = report;
      if (result.choice.model) corrected.choice.model = withField(*result.choice.model, model);
      return corrected;
    } catch (const Error&) {  // no camera of this model explains the views
      continue;
    }
  }
  return std::nullopt;
}

// Estimates a correction field if the lens needs one. Offsets of boards that corners free of it show change
// the field in turn.
void correct(Calibration& result, PreparedViews given, const CalibratorOptions& options) {
  auto corrected = neededCorrection(result, given, options);
  if (!corrected) return;
  CorrectedFit& with = corrected->with;
  for (FitView& view : with.fit.views) {  // back to the order of the prepared views
    const auto at = std::ranges::find(given.sources, view.source) - given.sources.begin();
    view.source = static_cast<std::size_t>(at);
  }
  constexpr int kRounds = 4;
  constexpr double kSettledPx = 0.01;
  ModelSolution solution{.fit = {}, .choice = corrected->choice, .close_params = corrected->close_params};
  for (int round = 0; round < kRounds; ++round) {
    solution.fit = with.fit;
    solution = withDataResettled(std::move(solution), options);
    if (round == kRounds - 1) break;
    CorrectedFit next = withCorrection(solution.fit, with.field->grid(), with.field, options.cancel);
    if (next.field == nullptr) return;
    double change_px = 0;
    for (const FitView& view : solution.fit.views) {
      for (const Observation& corner : view.corners)
        change_px = std::max(change_px, (next.field->at(corner.pixel) - with.field->at(corner.pixel)).norm());
    }
    if (change_px < kSettledPx) break;
    with = std::move(next);
  }
  given.views = freeOf(*with.field, given.views);
  with.fit = solution.fit;
  solution.holdout = holdoutReport(heldOutErrors(with, options.jobs, options.cancel));
  Calibration found = calibrationOf(std::move(solution), given, options);
  includeCorrection(with, found.uncertainty);
  measureCorrection(with, *found.choice.correction);
  setCorrection(with.field, found);
  found.diagnoses = judge(found, options.tolerance_px);
  const bool is_better = found.uncertainty.holdout.rms_px < result.uncertainty.holdout.rms_px;
  if (!options.correction_cells && (!is_better || (result.isUsable() && !found.isUsable()))) return;
  result = std::move(found);
}

void requireCells(const CalibratorOptions& named) {
  if (!named.correction_cells) return;
  const auto [columns, rows] = *named.correction_cells;
  const bool is_none = columns == 0 && rows == 0;
  if (!is_none && (std::min(columns, rows) < 1 || std::max(columns, rows) > kMaxCorrectionCells)) {
    throw usageError(
        {.where = "cells of the correction field",
         .found = std::to_string(columns) + " by " + std::to_string(rows),
         .expected = "1 to " + std::to_string(kMaxCorrectionCells) + " each way, or 0 by 0 for none"});
  }
}

// The field of a lens that is given whole; one to start from starts without.
CorrectionPointer keptCorrection(CalibratorOptions& named) {
  if (!named.initial) return nullptr;
  AnyCamera& initial = named.initial->camera;
  const bool is_whole =
      named.model == initial.modelId() && constraintOf(named).held.size() == initial.parameters().size();
  CorrectionPointer kept = is_whole ? initial.correction() : nullptr;
  initial = initial.withCorrection(nullptr);
  if (kept) named.correction_cells = {0, 0};
  return kept;
}

}  // namespace

Calibration calibrate(std::span<const Board> boards, std::vector<View> views,
                      const CalibratorOptions& options) {
  CalibratorOptions named = options;
  named.model = namedModel(options);
  if (named.model != kAutoModel)
    static_cast<void>(parameterNames(named.model));  // throws for an unknown model
  if (named.num_pupil.value_or(0) > EntrancePupil::kSize) {
    throw usageError({.where = "numbers of the entrance pupil",
                      .found = std::to_string(*named.num_pupil),
                      .expected = "0, 1 or 2"});
  }
  if (const std::size_t num_params = named.model == kAutoModel ? 0 : parameterNames(named.model).size();
      named.initial && constraintOf(named).held.size() == num_params)
    named.num_pupil = numPupil(named.initial->camera);  // a given lens keeps its pupil
  requireCells(named);
  const CorrectionPointer kept = keptCorrection(named);
  static_cast<void>(constraintOf(named));
  PreparedViews given = prepareViews(boards, std::move(views));
  if (kept) given.views = freeOf(*kept, std::move(given.views));
  const auto calibrated = [&] {
    return named.model == kAutoModel ? calibrationOfChoice(given, named)
                                     : calibrationOf(solutionOf(given, named), given, named);
  };
  constexpr int kMaxRevisions = 4;
  Calibration result = calibrated();
  for (int i = 0; i < kMaxRevisions; ++i) {
    if (!reviseGaps(result.fit, result.uncertainty.common_errors, boards, given.boards)) break;
    result = calibrated();
  }
  if (!named.num_pupil && showsMovingPupil(result)) {
    for (const std::size_t num_pupil : {1U, 2U}) {
      named.num_pupil = num_pupil;
      try {
        Calibration moving = calibrated();
        if (!needsPupil(moving, named) || (result.isUsable() && !moving.isUsable())) break;
        result = std::move(moving);
      } catch (const Error&) {  // no camera with a moving pupil explains the views
        break;
      }
      // A stiff model leaves its misfit to every further number.
      if (modelTraits(onlyCamera(result.fit).model).is_stiff) break;
    }
    named.num_pupil = result.uncertainty.pupil_std_m.size();
  }
  Fit last = result.fit;
  PreparedViews accepted = given;  // of the result
  for (int i = 0; i < kMaxRevisions && renumberTurnedViews(last, given); ++i) {
    try {
      Calibration renumbered = calibrated();
      last = renumbered.fit;
      if (!explainsMore(last, result.fit)) continue;
      result = std::move(renumbered);
      accepted = given;
    } catch (const Error&) {  // a doubtful numbering may leave no camera that explains the views
      break;
    }
  }
  requireLikelyPupil(result.camera().pupil());
  const bool is_requested = named.correction_cells && (*named.correction_cells)[0] > 0;
  if (is_requested || (!named.correction_cells && result.choice.model)) {
    try {
      correct(result, std::move(accepted), named);
    } catch (const Error&) {  // the camera without a field remains
      if (is_requested) throw;
    }
    result.choice.is_correction_undetermined = is_requested && !onlyCamera(result.fit).correction;
  }
  if (kept) {
    setCorrection(kept, result);
    result.diagnoses = judge(result, options.tolerance_px);
  }
  return result;
}

Calibration calibrate(const Board& board, std::vector<View> views, const CalibratorOptions& options) {
  return calibrate(std::span(&board, 1), std::move(views), options);
}

AnyCamera Calibration::camera() const {
  return cameraOf(fit);
}

std::vector<ViewSummary> viewSummaries(const Calibration& calibration) {
  std::vector<ViewSummary> summaries;
  auto outlier = calibration.dropped.outliers.begin();
  for (const FitView& view : calibration.fit.views) {
    ViewSummary summary{
        .image = view.image, .board = view.board, .num_corners = static_cast<int>(view.errors.size())};
    double sum = 0;
    for (const Eigen::Vector2d& error : view.errors) {
      sum += error.squaredNorm();
      summary.max_error_px = std::max(summary.max_error_px, error.norm());
    }
    summary.rms_px = std::sqrt(sum / summary.num_corners);
    // Outliers are in the order of their views.
    for (; outlier != calibration.dropped.outliers.end() && outlier->source == view.source; ++outlier)
      ++summary.num_outliers;
    summaries.push_back(std::move(summary));
  }
  return summaries;
}

std::vector<Diagnosis> judge(const Calibration& calibration, double tolerance_px) {
  return detail::judge({calibration.fit, calibration.dropped, calibration.choice, calibration.uncertainty,
                        calibration.domain, calibration.camera().withCorrection(nullptr), tolerance_px});
}

CameraRecord recordOf(const Calibration& calibration, std::string created_by, CameraName name) {
  AnyCamera camera = calibration.camera();
  std::vector<SelfCheckPoint> self_check = makeSelfCheck(camera, calibration.imageSize());
  return {.camera = camera,
          .image_size = calibration.imageSize(),
          .name = std::move(name),
          .domain = DomainClaim{.max_angle_rad = calibration.domain.cone.max_angle_rad,
                                .full_image = calibration.domain.full_image},
          .self_check = std::move(self_check),
          .calibration = calibrationRecord(calibration),
          .created_by = std::move(created_by)};
}

}  // namespace alidade
