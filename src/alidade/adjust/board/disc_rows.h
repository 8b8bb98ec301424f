// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

#include "alidade/adjust/board/corner_groups.h"
#include "alidade/adjust/board/view_rows.h"
#include "alidade/geometry/se3.h"

namespace alidade::detail {

/// True if the corners of a view are discs; a board has only one kind.
[[nodiscard]] inline bool areDiscs(std::span<const CornerGroup> corners) {
  return !corners.empty() && corners.front().radius_m > 0;
}

/// The projection of discs: the centroid of a disc's image, which differs from the image of its centre,
/// follows from the images of points on its rim, see centroidWithin().
class DiscRows {
 public:
  DiscRows(const ViewRows& points, const double* params, const SE3& camera_from_board)
      : points_(points), params_(params), camera_from_board_(camera_from_board) {}

  /// Projected minus observed, px; NaN if a point of the rim does not project.
  [[nodiscard]] Eigen::Vector2d error(const CornerGroup& group, std::size_t lane) const;

  /// The rows of u and v as in ViewRows::rows(), but without the corner's weight; zero, and false, if a point
  /// of the rim does not project.
  bool write(const CornerGroup& group, std::size_t lane, double* rows) const;

 private:
  const ViewRows& points_;
  const double* params_;
  const SE3& camera_from_board_;
};

}  // namespace alidade::detail
