// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A corner as used by the fit: a board point and its observed pixel.
struct Observation {
  Eigen::Vector3d p_board;
  Eigen::Vector2d pixel;
  double sigma_px = std::numeric_limits<double>::quiet_NaN();  ///< same as Corner::sigma_px
  double weight = 1.0;  ///< relative inverse variance, see CornerNoise; weighted error = error * sqrt(weight)
  int id = 0;           ///< of the board point
  /// If above 0, the pixel is the centroid of the image of a disc about p_board, parallel to the board's
  /// plane; metres.
  double radius_m = 0;
};

/// All corners of a view on the flat board, with weight 1.
[[nodiscard]] inline std::vector<Observation> observationsOf(const Board& board, const View& view) {
  std::vector<Observation> corners;
  corners.reserve(view.corners.size());
  for (const Corner& corner : view.corners) {
    corners.push_back({.p_board = board.corner(corner.id),
                       .pixel = corner.pixel,
                       .sigma_px = corner.sigma_px,
                       .id = corner.id,
                       .radius_m = board.discRadius()});
  }
  return corners;
}

/// Huber's loss on a corner's squared weighted error s = weight (dx^2 + dy^2): rho(s) = s up to threshold^2,
/// then linear in the error.
struct HuberLoss {
  double threshold_px;  ///< for a corner of weight 1

  [[nodiscard]] double rho(double s) const {
    if (s <= threshold_px * threshold_px) return s;
    return 2 * threshold_px * std::sqrt(s) - threshold_px * threshold_px;
  }
  /// d rho / d s, the factor on the weight of the corner.
  [[nodiscard]] double weight(double s) const {
    return s <= threshold_px * threshold_px ? 1.0 : threshold_px / std::sqrt(s);
  }
};

inline constexpr HuberLoss kNoLoss{.threshold_px = std::numeric_limits<double>::infinity()};

}  // namespace alidade
