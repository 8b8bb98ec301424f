// SPDX-License-Identifier: MIT
#include "converted_record.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace alidade {
namespace {

Eigen::MatrixXd fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n) {
  Eigen::MatrixXd full(n, n);
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) full(i, j) = full(j, i) = lower_triangle[k++];
  }
  return full;
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
  if (!record.parameter_std.empty()) {
    // Every new parameter is one old one times a factor, so that the sigmas need no covariance.
    const Eigen::VectorXd std =
        edit.J_new_old.cwiseAbs() *
        Eigen::Map<const Eigen::VectorXd>(record.parameter_std.data(), edit.J_new_old.cols());
    edited.parameter_std.assign(std.begin(), std.end());
  }
  if (!record.covariance.empty()) {
    const Eigen::MatrixXd covariance =
        edit.J_new_old * fullMatrix(record.covariance, edit.J_new_old.cols()) * edit.J_new_old.transpose();
    edited.covariance.clear();
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
      for (Eigen::Index j = 0; j <= i; ++j) edited.covariance.push_back(covariance(i, j));
    }
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
  record.views.clear();
  return record;
}

}  // namespace alidade
