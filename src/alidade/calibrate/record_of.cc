// SPDX-License-Identifier: MIT
#include "alidade/calibrate/record_of.h"

#include <cmath>
#include <utility>

#include "alidade/record/projection_record.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

void takeUncertainty(const CalibrationResult& result, CalibrationRecord& record) {
  if (!result.covariance) return;
  for (int i = 0; i < result.covariance->rows(); ++i) {
    record.parameter_std.push_back(result.parameterStd(i));
    if (result.by_views && std::isfinite(result.by_views->effectiveStd(i)))
      record.parameter_std_by_view.push_back(result.by_views->effectiveStd(i));
  }
  // All or none.
  if (record.parameter_std_by_view.size() != record.parameter_std.size())
    record.parameter_std_by_view.clear();
  record.covariance = lowerTriangle(*result.covariance);
  const Eigen::MatrixXd stated = result.statedCovariance();
  if (stated != *result.covariance) record.stated_covariance = lowerTriangle(stated);
  if (result.projection_far) record.projection_std = projectionRecord(*result.projection_far);
}

std::vector<ModelRecord> modelRecords(const ModelChoice& choice) {
  std::vector<ModelRecord> records;
  for (const ModelCandidate& c : choice.candidates) {
    records.push_back({.model = c.id,
                       .num_parameters = c.num_params,
                       .rms_px = c.rms_px,
                       .holdout_rms_px = c.holdout_rms_px,
                       .excess = c.excess,
                       .excess_std = c.excess_std,
                       .verdict = c.verdict});
  }
  return records;
}

CalibrationRecord calibrationRecord(const CalibrationResult& result, const Checkerboard& board,
                                    std::vector<Setting> settings) {
  CalibrationRecord record;
  record.holdout_rms_px = result.holdout.rms_px;
  if (result.model_choice) record.model_choice = modelRecords(*result.model_choice);
  record.rms_px = result.rms_px;
  record.verdict = result.verdict();
  record.num_views = static_cast<int>(result.views.size());
  record.num_corners = result.num_corners;
  record.num_outliers = static_cast<int>(result.outliers.size());
  record.termination = std::string(terminationName(result.solver.termination)) + ": " + result.solver.reason;
  record.board = specText(board);
  record.settings = std::move(settings);
  if (result.shape.is_estimated) record.warp = WarpRecord{result.shape.shape, result.shape.std_m};
  takeUncertainty(result, record);
  for (const Finding& finding : result.findings) record.findings.push_back(finding.id);
  for (const ViewResult& view : result.views) {
    record.views.push_back({.image = view.image,
                            .num_corners = view.num_corners,
                            .rms_px = view.rms_px,
                            .camera_from_board = view.camera_from_board});
  }
  return record;
}

}  // namespace

CameraRecord recordOf(const CalibrationResult& result, RecordDetails details) {
  return {.camera = result.camera,
          .image_size = result.image_size,
          .domain = DomainClaim{.max_angle_rad = result.domain.cone.max_angle_rad,
                                .full_image = result.domain.full_image},
          .self_check = makeSelfCheck(result.camera, result.image_size),
          .calibration = calibrationRecord(result, details.board, std::move(details.settings)),
          .created_by = std::move(details.created_by)};
}

}  // namespace alidade
