// SPDX-License-Identifier: MIT
#include "alidade/simulate/observe.h"

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "alidade/camera/batch.h"
#include "alidade/geometry/curve_centroid.h"
#include "alidade/record/scene.h"
#include "alidade/target/board_turns.h"

namespace alidade {

namespace {

bool isInside(const Projection& p, ImageSize size) {
  return p.ok() && p.pixel.x() >= -0.5 && p.pixel.x() < size.width - 0.5 && p.pixel.y() >= -0.5 &&
         p.pixel.y() < size.height - 0.5;
}

// The centroid of the image of a disc; nothing if a part of the disc is not visible.
std::optional<Eigen::Vector2d> discCentroid(const AnyCamera& camera, ImageSize size, const Board& board,
                                            const SE3& camera_from_board, int id) {
  constexpr int kPoints = 32;
  static const auto circle = unitCircle<kPoints>();
  Eigen::Matrix<double, 2, kPoints> rim;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d offset(board.discRadius() * circle(0, i), board.discRadius() * circle(1, i), 0);
    const Projection p = camera.projectPoint(camera_from_board * (board.corner(id) + offset));
    if (!isInside(p, size)) return std::nullopt;
    rim.col(i) = p.pixel;
  }
  return centroidWithin(rim).at;
}

}  // namespace

View exactView(const AnyCamera& camera, ImageSize size, const Board& board, const SE3& camera_from_board,
               std::string image_name) {
  View view{.image = std::move(image_name), .size = size, .corners = {}};
  if (!seesPrintedSide(camera_from_board)) return view;
  std::vector<Eigen::Vector3d> points = board.corners();
  for (Eigen::Vector3d& point : points) point = camera_from_board * point;
  std::vector<Projection> projections(points.size());
  projectBatch(camera, points, projections);
  for (int id = 0; id < board.numCorners(); ++id) {
    const Projection& p = projections[static_cast<std::size_t>(id)];
    if (!isInside(p, size)) continue;
    if (board.discRadius() == 0) {
      view.corners.push_back({.id = id, .pixel = p.pixel});
    } else if (const auto centroid = discCentroid(camera, size, board, camera_from_board, id)) {
      view.corners.push_back({.id = id, .pixel = *centroid});
    }
  }
  return view;
}

void addCornerNoise(View& view, double sigma_px, Random& random) {
  detail::checkOption("sigma_px", sigma_px, 0, std::numeric_limits<double>::max());
  for (Corner& corner : view.corners) {
    // Two statements, because the order of draws must be fixed and arguments of a call are evaluated in any
    // order.
    corner.pixel.x() += sigma_px * random.normal();
    corner.pixel.y() += sigma_px * random.normal();
    corner.sigma_px = sigma_px;
  }
}

}  // namespace alidade
