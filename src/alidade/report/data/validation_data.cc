// SPDX-License-Identifier: MIT
#include "alidade/report/data/validation_data.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/mapped.h"
#include "alidade/report/data/utf8.h"

namespace alidade {
namespace {

// The message of a check or an error ends with the next step.
Diagnosis diagnosisFrom(Severity severity, DiagnosisId id, const std::string& raw_message) {
  constexpr std::string_view kNext = "\n  next: ";
  const std::string message = validUtf8(raw_message);
  const std::size_t end = message.find(kNext);
  Diagnosis check{.id = id, .severity = severity, .cause = message.substr(0, end)};
  if (end != std::string::npos) check.next_step = message.substr(end + kNext.size());
  for (std::string* const text : {&check.cause, &check.next_step}) std::ranges::replace(*text, '\n', ' ');
  return check;
}

std::vector<Diagnosis> diagnosesFrom(const std::vector<FileCheck>& checks) {
  return mapped(
      checks, [](const FileCheck& check) { return diagnosisFrom(check.severity, check.id, check.message); });
}

// The 95 % error of distant points according to the covariance.
Accuracy accuracyByCovariance(const AnyCamera& camera, const ImageSize& size,
                              const Eigen::MatrixXd& covariance) {
  const ProjectionUncertainty projection(camera, size, std::numeric_limits<double>::infinity());
  Accuracy accuracy{.columns = projection.columns(), .rows = projection.rows()};
  accuracy.worst_px = 0;
  for (std::size_t i = 0; i < projection.pixels().size(); ++i) {
    const auto index = static_cast<int>(i);
    double error_px = std::numeric_limits<double>::quiet_NaN();
    if (projection.hasRay(index)) {
      const auto A = projection.jacobian(index);
      error_px = radius95(Eigen::Matrix2d(A * covariance * A.transpose()));
    }
    accuracy.error_px.push_back(error_px);
    if (!(error_px > accuracy.worst_px)) continue;
    accuracy.worst_px = error_px;
    accuracy.worst_pixel = projection.pixels()[i];
  }
  accuracy.is_covered.resize(accuracy.error_px.size());
  return accuracy;
}

// The camera and the statements of its file.
ReportData statedData(const CameraJudgement& judgement, double tolerance_px) {
  ReportData data{.camera = *judgement.camera, .size = *judgement.image_size, .tolerance_px = tolerance_px};
  const std::size_t count = data.camera.parameters().size();
  data.parameter_std.assign(count, std::numeric_limits<double>::quiet_NaN());
  if (const auto& stated = judgement.calibration) {
    if (stated->parameter_std.size() == count) data.parameter_std = stated->parameter_std;
    if (stated->covariance.size() == count * (count + 1) / 2)
      data.covariance = fullMatrix(stated->covariance, static_cast<Eigen::Index>(count)).view();
  }
  if (data.covariance && data.covariance->allFinite())
    data.accuracy = accuracyByCovariance(data.camera, data.size, *data.covariance);
  return data;
}

void addHeldOutViews(const HeldOutJudgement& held_out, const std::vector<Board>& boards,
                     JudgedCamera& camera) {
  ReportData& data = *camera.data;
  for (std::size_t b = 0; b < boards.size(); ++b)
    data.boards.push_back({.target = held_out.freed ? held_out.freed->fit.boards[b].target : boards[b]});
  for (const HeldOutView& tested : held_out.views) {
    ReportedView view{.image = validUtf8(tested.image), .board = tested.board, .rms_px = tested.rms_px};
    if (tested.corners.empty()) {
      camera.untested.push_back(std::move(view.image));
      continue;
    }
    view.camera_from_board = tested.camera_from_board;
    view.corners = tested.corners;
    for (const CornerError& corner : view.corners)
      view.max_error_px = std::max(view.max_error_px, corner.error_px.norm());
    camera.tested.push_back(&tested);
    data.views.push_back(std::move(view));
  }
  data.rms_px = held_out.held_out_rms_px;
  data.coordinate_sigma_px = held_out.noise_sigma_px;
}

}  // namespace

std::vector<JudgedFile> judgedFiles(const ValidationResult& result) {
  std::vector<JudgedFile> files;
  std::size_t num_views = 0;
  for (const FileJudgement& judgement : result.files) {
    JudgedFile file{.judgement = &judgement,
                    .name = validUtf8(judgement.file),
                    .status = result.outcomeOf(judgement),
                    .rig_checks = diagnosesFrom(judgement.rig_checks)};
    if (!judgement.error.empty())
      file.error = diagnosisFrom(Severity::kFailure, "unreadable", judgement.error);
    for (const CameraJudgement& judged : judgement.cameras) {
      JudgedCamera camera{
          .judgement = &judged, .name = validUtf8(judged.name), .checks = diagnosesFrom(judged.checks)};
      if (judged.camera && judged.image_size) {
        camera.data = statedData(judged, result.tolerance_px);
        if (judged.held_out) addHeldOutViews(*judged.held_out, result.boards, camera);
        camera.data->first_view = num_views;
        num_views += camera.data->views.size();
      }
      file.cameras.push_back(std::move(camera));
    }
    files.push_back(std::move(file));
  }
  return files;
}

}  // namespace alidade
