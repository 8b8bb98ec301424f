// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "alidade/camera/freed.h"
#include "alidade/compare/image_match.h"
#include "alidade/compare/projection_difference.h"

namespace alidade {

/// F, 2 rows per pixel, px of the finer image along a's axes: to first order F F^T is the covariance of the
/// differences caused by the uncertainty of the two cameras, with the alignment refitted for every change of
/// the parameters. A camera without covariance is assumed to be exact; without any covariance, F has no
/// columns.
/// @param pixels   of image a, all with a ray in either camera
/// @param weights  of the pixels in the alignment; empty: all equal
[[nodiscard]] Eigen::MatrixXd differenceFactor(const ComparedCamera& a, const ComparedCamera& b,
                                               const ImageMatch& match,
                                               std::span<const Eigen::Vector2d> pixels,
                                               std::optional<Freed> freed, std::span<const double> weights);

}  // namespace alidade
