// SPDX-License-Identifier: MIT
#include "alidade/calibrate/record_of.h"

#include <cmath>
#include <utility>

#include "alidade/adjust/errors.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

void takeUncertainty(const Calibration& of, CalibrationRecord& record) {
  if (!of.uncertainty.covariance) return;
  for (int i = 0; i < of.uncertainty.covariance->rows(); ++i) {
    record.parameter_std.push_back(of.uncertainty.parameterStd(i));
    if (of.uncertainty.by_views && std::isfinite(of.uncertainty.by_views->effectiveStd(i)))
      record.parameter_std_by_view.push_back(of.uncertainty.by_views->effectiveStd(i));
  }
  // All or none.
  if (record.parameter_std_by_view.size() != record.parameter_std.size())
    record.parameter_std_by_view.clear();
  record.covariance = lowerTriangle(*of.uncertainty.covariance);
  const Eigen::MatrixXd stated = of.uncertainty.statedCovariance();
  if (stated != *of.uncertainty.covariance) record.stated_covariance = lowerTriangle(stated);
  if (of.uncertainty.projection_far) record.projection_std = projectionRecord(*of.uncertainty.projection_far);
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

CalibrationRecord calibrationRecord(const Calibration& of, const Checkerboard& board,
                                    std::vector<Setting> settings) {
  CalibrationRecord record;
  record.holdout_rms_px = of.uncertainty.holdout.rms_px;
  if (of.choice.model) record.model_choice = modelRecords(*of.choice.model);
  record.rms_px = rms(of.fit);
  record.verdict = of.verdict();
  record.num_views = static_cast<int>(of.fit.views.size());
  record.num_corners = static_cast<int>(numCorners(of.fit));
  record.num_outliers = static_cast<int>(of.dropped.outliers.size());
  record.termination =
      std::string(terminationName(of.fit.summary.termination)) + ": " + of.fit.summary.reason;
  record.board = specText(board);
  record.settings = std::move(settings);
  if (isShapeEstimated(of.fit)) record.warp = WarpRecord{onlyBoard(of.fit).shape, of.uncertainty.bend_std_m};
  takeUncertainty(of, record);
  for (const Diagnosis& diagnosis : of.diagnoses) record.findings.push_back(diagnosis.id);
  const std::vector<ViewSummary> summaries = viewSummaries(of);
  for (std::size_t v = 0; v < summaries.size(); ++v) {
    record.views.push_back({.image = summaries[v].image,
                            .num_corners = summaries[v].num_corners,
                            .rms_px = summaries[v].rms_px,
                            .camera_from_board = cameraFromBoard(of.fit, of.fit.views[v])});
  }
  return record;
}

}  // namespace

CameraRecord recordOf(const Calibration& calibration, RecordDetails details) {
  AnyCamera camera = calibration.camera();
  std::vector<SelfCheckPoint> self_check = makeSelfCheck(camera, calibration.imageSize());
  return {.camera = std::move(camera),
          .image_size = calibration.imageSize(),
          .domain = DomainClaim{.max_angle_rad = calibration.domain.cone.max_angle_rad,
                                .full_image = calibration.domain.full_image},
          .self_check = std::move(self_check),
          .calibration = calibrationRecord(calibration, details.board, std::move(details.settings)),
          .created_by = std::move(details.created_by)};
}

}  // namespace alidade
