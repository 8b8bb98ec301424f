// SPDX-License-Identifier: MIT
#include "alidade/record/camera_record.h"

#include <utility>

#include "alidade/camera/image_domain.h"
#include "alidade/core/error.h"

namespace alidade {

CameraRecord bareRecord(const AnyCamera& camera, ImageSize size, std::string created_by) {
  const DomainCertificate domain = certifyDomain(camera, size);
  return {.camera = camera,
          .image_size = size,
          .domain = DomainClaim{.max_angle_rad = domain.cone.max_angle_rad, .full_image = domain.full_image},
          .self_check = makeSelfCheck(camera, size),
          .created_by = std::move(created_by)};
}

std::vector<double> lowerTriangle(const Eigen::MatrixXd& matrix) {
  std::vector<double> triangle;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) triangle.push_back(matrix(i, j));
  }
  return triangle;
}

DenseMatrix fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n) {
  expect(static_cast<Eigen::Index>(lower_triangle.size()) == n * (n + 1) / 2, "a whole lower triangle");
  Eigen::MatrixXd full(n, n);
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) full(i, j) = full(j, i) = lower_triangle[k++];
  }
  return full;
}

std::optional<DenseMatrix> statedCovariance(const CameraRecord& record) {
  if (!record.calibration || record.calibration->covariance.empty()) return std::nullopt;
  return fullMatrix(record.calibration->covariance,
                    static_cast<Eigen::Index>(record.camera.parameters().size()));
}

}  // namespace alidade
