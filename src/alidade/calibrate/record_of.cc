// SPDX-License-Identifier: MIT
#include "alidade/calibrate/record_of.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

// To a tenth of a pixel: enough to recognise an image by.
std::vector<Eigen::Vector2d> viewCenters(const Fit& fit) {
  constexpr double kTenths = 10;
  std::vector<Eigen::Vector2d> centers;
  for (const FitView& view : fit.views) {
    if (centers.size() == CalibrationRecord::kMaxViewCenters) break;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Observation& corner : view.corners) sum += corner.pixel;
    const Eigen::Vector2d mean = sum / static_cast<double>(view.corners.size());
    centers.emplace_back((kTenths * mean).array().round() / kTenths);
  }
  return centers;
}

// Three digits.
double rounded(double value) {
  return std::isfinite(value) ? *parseDouble(numberText("%.3g", value)) : value;
}

// Of the boards that the views show.
void addBoards(const Calibration& of, CalibrationRecord& record) {
  for (std::size_t b = 0; b < of.fit.boards.size(); ++b) {
    const FitBoard& board = of.fit.boards[b];
    if (numViews(of.fit, b) == 0) continue;
    if (!board.is_shape_fixed) {
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
    if (std::find(record.findings.begin(), record.findings.end(), diagnosis.id) == record.findings.end())
      record.findings.push_back(diagnosis.id);
  }
  if (!known.covariance) return record;
  record.covariance = lowerTriangle(known.statedCovariance());
  record.is_covariance_by_views = known.isNoiseExceeded();
  for (int i = 0; i < known.covariance->rows(); ++i) record.parameter_std.push_back(known.parameterStd(i));
  return record;
}

}  // namespace

CameraRecord recordOf(const Calibration& calibration, RecordDetails details) {
  AnyCamera camera = calibration.camera();
  std::vector<SelfCheckPoint> self_check = makeSelfCheck(camera, calibration.imageSize());
  return {.camera = camera,
          .image_size = calibration.imageSize(),
          .name = std::move(details.name),
          .domain = DomainClaim{.max_angle_rad = calibration.domain.cone.max_angle_rad,
                                .full_image = calibration.domain.full_image},
          .self_check = std::move(self_check),
          .calibration = calibrationRecord(calibration),
          .created_by = std::move(details.created_by)};
}

}  // namespace alidade
