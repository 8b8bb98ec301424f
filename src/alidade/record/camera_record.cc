// SPDX-License-Identifier: MIT
#include "alidade/record/camera_record.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"

namespace alidade {

CameraRecord bareRecord(const AnyCamera& camera, ImageSize size, std::string created_by) {
  const DomainCertificate domain = certifyDomain(camera, size);
  return {.camera = camera,
          .image_size = size,
          .domain = DomainClaim{.max_angle_rad = domain.cone.max_angle_rad, .full_image = domain.full_image},
          .self_check = makeSelfCheck(camera, size),
          .created_by = std::move(created_by)};
}

std::optional<ProjectionStdRecord> projectionRecord(const UncertaintyGrid& grid) {
  if (!std::isfinite(grid.worst_px)) return std::nullopt;
  const auto rounded = [](double px) {
    return std::isfinite(px) ? *parseDouble(numberText("%.4g", px)) : px;
  };
  ProjectionStdRecord record{.center_px = rounded(grid.center_px),
                             .worst_px = rounded(grid.worst_px),
                             .worst_pixel = grid.worst_pixel,
                             .columns = grid.columns,
                             .rows = grid.rows,
                             .std_px = {}};
  for (const double std : grid.std_px) record.std_px.push_back(rounded(std));
  return record;
}

std::vector<double> lowerTriangle(const Eigen::MatrixXd& matrix) {
  std::vector<double> triangle;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) triangle.push_back(matrix(i, j));
  }
  return triangle;
}

DenseMatrix fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n) {
  Eigen::MatrixXd full(n, n);
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) full(i, j) = full(j, i) = lower_triangle[k++];
  }
  return full;
}

std::optional<DenseMatrix> statedCovariance(const CameraRecord& record) {
  if (!record.calibration || record.calibration->covariance.empty()) return std::nullopt;
  const CalibrationRecord& calibration = *record.calibration;
  return fullMatrix(
      calibration.stated_covariance.empty() ? calibration.covariance : calibration.stated_covariance,
      static_cast<Eigen::Index>(record.camera.parameters().size()));
}

bool isStatedByViews(const CameraRecord& record) {
  return record.calibration && !record.calibration->stated_covariance.empty();
}

}  // namespace alidade
