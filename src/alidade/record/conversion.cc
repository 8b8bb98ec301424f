// SPDX-License-Identifier: MIT
#include "alidade/record/conversion.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "alidade/camera/image_domain.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/size_groups.h"

namespace alidade {
namespace {

std::string rectText(const PixelRect& rect) {
  return std::to_string(rect.x) + "," + std::to_string(rect.y) + "," + std::to_string(rect.width) + "," +
         std::to_string(rect.height);
}

// The lower triangle of a covariance after a change of the parameters; empty stays empty.
std::vector<double> carried(const std::vector<double>& triangle, const Eigen::MatrixXd& J_new_old) {
  if (triangle.empty()) return {};
  return lowerTriangle(J_new_old * fullMatrix(triangle, J_new_old.cols()).view() * J_new_old.transpose());
}

// One sigma each. Every new parameter is an old one times a factor, so no covariance is needed.
std::vector<double> carriedStd(const std::vector<double>& std, const Eigen::MatrixXd& J_new_old) {
  if (std.empty()) return {};
  const Eigen::VectorXd result =
      J_new_old.cwiseAbs() * Eigen::Map<const Eigen::VectorXd>(std.data(), J_new_old.cols());
  return {result.begin(), result.end()};
}

// The calibration of the camera of an edited image. Covariances follow the edit exactly. Lengths in pixels
// refer to the new size; if the axes were resized unequally, they are scaled by the geometric mean. Counts,
// board and findings stay. The images differ from those of the calibration, so their centres are left out.
// @param edit  from the calibrated camera to the new one, all steps in one
CalibrationRecord editedRecord(const CalibrationRecord& record, const AnyCamera& calibrated,
                               const EditedCamera& edit) {
  CalibrationRecord edited = record;
  const auto before = calibrated.parameters();
  const auto after = edit.camera.parameters();
  const double scale = std::sqrt(after[0] * after[1] / (before[0] * before[1]));
  edited.rms_px *= scale;
  edited.holdout_rms_px *= scale;
  edited.accuracy_px *= scale;
  if (edit.camera.pupil() != calibrated.pupil()) {
    edited.pupil_std.clear();
    if (std::isfinite(record.accuracy_distance_m))
      edited.accuracy_px = std::numeric_limits<double>::quiet_NaN();
  }
  edited.parameter_std = carriedStd(record.parameter_std, edit.J_new_old);
  edited.covariance = carried(record.covariance, edit.J_new_old);
  if (edit.J_new_old.view() != Eigen::MatrixXd::Identity(edit.J_new_old.rows(), edit.J_new_old.cols()))
    edited.view_centers.clear();
  return edited;
}

// The record for a camera of a different model that replaces the old one with an error of `fit_rms_px`. The
// covariance of the old parameters is left out; the errors of both models are combined.
CalibrationRecord refittedRecord(CalibrationRecord record, double fit_rms_px) {
  record.rms_px = std::hypot(record.rms_px, fit_rms_px);
  record.accuracy_px += fit_rms_px;
  record.holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
  record.parameter_std.clear();
  record.covariance.clear();
  return record;
}

std::vector<ConversionProblem> problemsOf(const CameraRecord& source, const Conversion& conversion) {
  std::vector<ConversionProblem> problems;
  if (source.calibration && source.calibration->verdict == Verdict::kNo)
    problems.push_back(ConversionProblem::kSourceUntrustworthy);
  if (!conversion.fit) return problems;
  const ModelFit& fit = *conversion.fit;
  if (fit.unreachedShare() > kMaxUnreachedShare) problems.push_back(ConversionProblem::kUnreachedPixels);
  if (fit.is_exact) return problems;
  if (fit.rms_px > conversion.max_error_px) problems.push_back(ConversionProblem::kModelRms);
  if (fit.max_error_px > kMaxErrorFactor * conversion.max_error_px)
    problems.push_back(ConversionProblem::kModelError);
  return problems;
}

}  // namespace

std::string_view problemId(ConversionProblem problem) {
  constexpr std::array<std::string_view, 4> kIds = {"source_untrustworthy", "unreached_pixels", "model_rms",
                                                    "model_error"};
  return kIds.at(static_cast<std::size_t>(problem));
}

Conversion convertCamera(const CameraRecord& source, const ConversionRequest& request) {
  Conversion conversion{.edit = rotateCamera(source.camera, source.image_size, 0),
                        .steps = {},
                        .fit = {},
                        .max_error_px = request.max_error_px,
                        .problems = {}};
  const auto take = [&conversion](const char* name, std::string value, const EditedCamera& next) {
    EditedCamera& all = conversion.edit;
    all = {.camera = next.camera,
           .size = next.size,
           .new_from_old = next.new_from_old * all.new_from_old,
           .J_new_old = next.J_new_old.view() * all.J_new_old.view()};
    conversion.steps.push_back({name, std::move(value), next.size});
  };
  const EditedCamera& now = conversion.edit;
  if (request.crop) take("crop", rectText(*request.crop), cropCamera(now.camera, now.size, *request.crop));
  if (request.bin) take("bin", std::to_string(*request.bin), binCamera(now.camera, now.size, *request.bin));
  if (request.resize)
    take("resize", sizeText(*request.resize), resizeCamera(now.camera, now.size, *request.resize));
  if (request.rotate_deg)
    take("rotate", std::to_string(*request.rotate_deg),
         rotateCamera(now.camera, now.size, *request.rotate_deg / 90));
  if (request.drops_pupil && !now.camera.pupil().isFixed()) {
    conversion.edit.camera = now.camera.withPupil({});
    conversion.steps.push_back({"drop", "pupil", now.size});
  }
  const bool is_dropped = request.drops_correction && now.camera.correction() != nullptr;
  if (is_dropped) conversion.steps.push_back({"drop", "correction", now.size});
  if (!request.model.empty() || is_dropped) {
    const std::string model = request.model.empty() ? std::string(now.camera.modelId()) : request.model;
    conversion.fit = fitModel(now.camera, now.size, model, request.absent);
    conversion.steps.push_back({"model", model, now.size});
  }
  conversion.problems = problemsOf(source, conversion);
  return conversion;
}

CameraRecord convertedRecord(const CameraRecord& source, const Conversion& conversion,
                             std::string created_by) {
  const AnyCamera& camera = conversion.camera();
  const ImageSize size = conversion.edit.size;
  const DomainCertificate domain = conversion.fit ? conversion.fit->domain : certifyDomain(camera, size);
  CameraRecord record{
      .camera = camera,
      .image_size = size,
      .name = source.name,
      .domain = DomainClaim{.max_angle_rad = domain.cone.max_angle_rad, .full_image = domain.full_image},
      .self_check = makeSelfCheck(camera, size),
      .created_by = std::move(created_by),
      .user_keys = source.user_keys};
  // A model that reaches no pixel has no error. The file still needs a number, and its finding explains it.
  const double fit_rms_px =
      conversion.fit && std::isfinite(conversion.fit->rms_px) ? conversion.fit->rms_px : 0.0;
  if (source.calibration) {
    record.calibration = editedRecord(*source.calibration, source.camera, conversion.edit);
    if (conversion.fit && (!conversion.fit->is_exact || camera.modelId() != source.camera.modelId()))
      record.calibration = refittedRecord(*std::move(record.calibration), fit_rms_px);
  }
  if (!conversion.problems.empty()) {
    // A file kept despite a problem states it, even if it has no calibration.
    if (!record.calibration) {
      record.calibration.emplace();
      record.calibration->rms_px = fit_rms_px;
    }
    record.calibration->verdict = Verdict::kNo;
    for (const ConversionProblem problem : conversion.problems)
      record.calibration->findings.emplace_back(problemId(problem));
  }
  return record;
}

}  // namespace alidade
