// SPDX-License-Identifier: MIT
#include "alidade/record/converted_record.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "alidade/record/projection_record.h"

namespace alidade {
namespace {

// A covariance's lower triangle after a change of the parameters; empty if it was.
std::vector<double> carried(const std::vector<double>& triangle, const Eigen::MatrixXd& J_new_old) {
  if (triangle.empty()) return {};
  return lowerTriangle(J_new_old * fullMatrix(triangle, J_new_old.cols()).view() * J_new_old.transpose());
}

// One sigma each. Every new parameter is one old one times a factor, so that no covariance is needed.
std::vector<double> carriedStd(const std::vector<double>& std, const Eigen::MatrixXd& J_new_old) {
  if (std.empty()) return {};
  const Eigen::VectorXd result =
      J_new_old.cwiseAbs() * Eigen::Map<const Eigen::VectorXd>(std.data(), J_new_old.cols());
  return {result.begin(), result.end()};
}

SE3 pureRotation(const Eigen::Matrix3d& quarter_turns_about_z) {
  const double angle = std::atan2(quarter_turns_about_z(1, 0), quarter_turns_about_z(0, 0));
  return {.rotation = SO3::exp(Eigen::Vector3d(0, 0, angle))};
}

}  // namespace

CalibrationRecord editedRecord(const CalibrationRecord& record, const AnyCamera& calibrated,
                               const EditedCamera& edit) {
  CalibrationRecord edited = record;
  const auto before = calibrated.parameters();
  const auto after = edit.camera.parameters();
  const double scale = std::sqrt(after[0] * after[1] / (before[0] * before[1]));
  edited.rms_px *= scale;
  edited.holdout_rms_px *= scale;
  for (ModelRecord& model : edited.model_choice) {
    model.rms_px *= scale;
    model.holdout_rms_px *= scale;
  }
  edited.parameter_std = carriedStd(record.parameter_std, edit.J_new_old);
  edited.parameter_std_by_view = carriedStd(record.parameter_std_by_view, edit.J_new_old);
  edited.covariance = carried(record.covariance, edit.J_new_old);
  edited.stated_covariance = carried(record.stated_covariance, edit.J_new_old);
  // The image is another one, and so is the rotation that fits best over it.
  edited.projection_std.reset();
  const auto& stated = edited.stated_covariance.empty() ? edited.covariance : edited.stated_covariance;
  if (record.projection_std && !stated.empty()) {
    const ProjectionUncertainty uncertainty(edit.camera, edit.size, std::numeric_limits<double>::infinity());
    edited.projection_std = projectionRecord(uncertainty.grid(fullMatrix(stated, edit.J_new_old.rows())));
  }
  const SE3 new_from_old = pureRotation(edit.new_from_old);
  const bool is_turned = !edit.new_from_old.isIdentity();
  for (ViewRecord& view : edited.views) {
    view.rms_px *= scale;
    if (is_turned) view.camera_from_board = new_from_old * view.camera_from_board;
  }
  return edited;
}

CalibrationRecord refittedRecord(CalibrationRecord record, double fit_rms_px) {
  record.rms_px = std::hypot(record.rms_px, fit_rms_px);
  record.holdout_rms_px = std::numeric_limits<double>::quiet_NaN();
  record.model_choice.clear();
  record.parameter_std.clear();
  record.covariance.clear();
  record.parameter_std_by_view.clear();
  record.stated_covariance.clear();
  record.projection_std.reset();
  record.views.clear();
  return record;
}

}  // namespace alidade
