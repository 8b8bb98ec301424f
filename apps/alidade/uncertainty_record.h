// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/io/camera_file.h"

namespace alidade {

/// A symmetric matrix as the camera file has it: the lower triangle, row by row.
[[nodiscard]] std::vector<double> lowerTriangle(const Eigen::MatrixXd& matrix);
[[nodiscard]] Eigen::MatrixXd fullMatrix(const std::vector<double>& lower_triangle, Eigen::Index n);

/// The covariance of the parameters to go by, N x N; nothing where the file states none.
[[nodiscard]] std::optional<Eigen::MatrixXd> statedCovariance(const CameraFile& file);

/// Whether that covariance takes only views for independent, or is that by the corners' noise alone.
[[nodiscard]] bool isStatedByViews(const CameraFile& file);

/// A grid as the camera file has it, with four digits: more would be read by nobody. Nothing if no pixel has
/// a ray, or a sigma is not finite.
[[nodiscard]] std::optional<ProjectionStdRecord> projectionRecord(const UncertaintyGrid& grid);

}  // namespace alidade
