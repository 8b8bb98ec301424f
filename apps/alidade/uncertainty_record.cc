// SPDX-License-Identifier: MIT
#include "uncertainty_record.h"

#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "alidade/core/text.h"

namespace alidade {
namespace {

double rounded(double value) {
  return std::isfinite(value) ? *parseDouble(fmt::format("{:.4g}", value)) : value;
}

}  // namespace

std::vector<double> lowerTriangle(const Eigen::MatrixXd& matrix) {
  std::vector<double> triangle;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) triangle.push_back(matrix(i, j));
  }
  return triangle;
}

Eigen::MatrixXd fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n) {
  Eigen::MatrixXd full(n, n);
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) full(i, j) = full(j, i) = lower_triangle[k++];
  }
  return full;
}

std::optional<Eigen::MatrixXd> statedCovariance(const CameraFile& file) {
  if (!file.calibration || file.calibration->covariance.empty()) return std::nullopt;
  const CalibrationRecord& record = *file.calibration;
  return fullMatrix(record.stated_covariance.empty() ? record.covariance : record.stated_covariance,
                    static_cast<Eigen::Index>(file.camera.parameters().size()));
}

bool isStatedByViews(const CameraFile& file) {
  return file.calibration && !file.calibration->stated_covariance.empty();
}

std::optional<ProjectionStdRecord> projectionRecord(const UncertaintyGrid& grid) {
  if (!std::isfinite(grid.worst_px)) return std::nullopt;
  ProjectionStdRecord record{.center_px = rounded(grid.center_px),
                             .worst_px = rounded(grid.worst_px),
                             .worst_pixel = grid.worst_pixel,
                             .columns = grid.columns,
                             .rows = grid.rows,
                             .std_px = {}};
  for (const double std : grid.std_px) record.std_px.push_back(rounded(std));
  return record;
}

}  // namespace alidade
