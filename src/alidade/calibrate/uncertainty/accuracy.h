// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/camera/any_camera.h"

namespace alidade {

struct Uncertainty;

/// The error of the pixel of a scene point that is not exceeded with a probability of 95 %, over the whole
/// image: of distant points after alignment by the best rotation, of points at a finite distance after
/// alignment by the best pose. It adds up
///
/// - the stated covariance, or if larger, the difference to another camera that explains the corners as well,
///   or outside the region that boards covered, the covariance of a more flexible model at the same lens: a
///   stiff model extrapolates with a small covariance, and wrongly. For stiff models inside too, about that
///   other camera; and
/// - the deviation of the lens from its model that all views have in common (ImageBias).
struct Accuracy {
  double distance_m = std::numeric_limits<double>::infinity();  ///< of the points
  int columns = 0;                                              ///< of the grid, from border to border
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels = {};  ///< row by row
  std::vector<double> error_px = {};         ///< 95 %, one per pixel; NaN if the pixel has no ray
  std::vector<bool> is_covered = {};         ///< within the corners of some view
  double covered_share = 0;                  ///< of the pixels with a ray
  double covered_px = std::numeric_limits<double>::quiet_NaN();  ///< the largest error where boards were seen
  double worst_px = std::numeric_limits<double>::quiet_NaN();    ///< the largest error of all
  Eigen::Vector2d worst_pixel{0, 0};
  double deviation_px = 0;  ///< of the lens from its model, 95 %; included

  /// Share of the pixels with a ray whose error is at most `tolerance_px`.
  [[nodiscard]] double shareWithin(double tolerance_px) const;
  /// The same of the covered pixels.
  [[nodiscard]] double coveredShareWithin(double tolerance_px) const;
};

/// The radius about the mean that a normal variable in the plane stays within with a probability of 95 %.
[[nodiscard]] double radius95(const Eigen::Matrix2d& covariance);

/// @param fit    of one camera, solved
/// @param known  with a covariance and the image bias
/// @param alternatives  cameras that explain the corners as well
/// @param distance_m  of the points, positive; may be infinite
[[nodiscard]] Accuracy accuracyOf(const Fit& fit, const Uncertainty& known,
                                  std::span<const AnyCamera> alternatives,
                                  double distance_m = std::numeric_limits<double>::infinity());

}  // namespace alidade
