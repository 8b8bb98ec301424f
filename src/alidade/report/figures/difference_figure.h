// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/report/canvas/figure_canvas.h"
#include "alidade/report/data/report_data.h"

namespace alidade {

/// Another camera, to compare the calibrated one with.
struct RivalCamera {
  std::string name;  ///< of its file
  AnyCamera camera;
  ImageSize size;
  std::optional<DenseMatrix> covariance = std::nullopt;  ///< of its parameters; empty: unknown
};

/// Where the other camera projects distant points after the best rotation, compared with the calibrated one.
/// @throws Error (kInput) for a camera whose image has another shape
[[nodiscard]] Figure differenceFigure(const ReportData& data, const RivalCamera& rival);

}  // namespace alidade
