// SPDX-License-Identifier: MIT
#include "alidade/simulate/observe.h"

#include <limits>
#include <utility>
#include <vector>

#include "alidade/record/scene.h"

namespace alidade {

bool seesPrintedSide(const SE3& camera_from_board) {
  return camera_from_board.inverse().translation.z() < 0;
}

View exactView(const AnyCamera& camera, ImageSize size, const Board& board, const SE3& camera_from_board,
               std::string image_name) {
  View view{.image = std::move(image_name), .size = size, .corners = {}};
  if (!seesPrintedSide(camera_from_board)) return view;
  std::vector<Eigen::Vector3d> points = board.corners();
  for (Eigen::Vector3d& point : points) point = camera_from_board * point;
  std::vector<Projection> projections(points.size());
  camera.project(points, projections);
  for (int id = 0; id < board.numCorners(); ++id) {
    const Projection& p = projections[static_cast<std::size_t>(id)];
    const bool is_inside = p.ok() && p.pixel.x() >= -0.5 && p.pixel.x() < size.width - 0.5 &&
                           p.pixel.y() >= -0.5 && p.pixel.y() < size.height - 0.5;
    if (is_inside) view.corners.push_back({.id = id, .pixel = p.pixel});
  }
  return view;
}

void addCornerNoise(View& view, double sigma_px, Random& random) {
  detail::checkOption("sigma_px", sigma_px, 0, std::numeric_limits<double>::max());
  for (Corner& corner : view.corners) {
    // Two statements: the order of evaluation of a call's arguments is not fixed, the order of draws must be.
    corner.pixel.x() += sigma_px * random.normal();
    corner.pixel.y() += sigma_px * random.normal();
    corner.sigma_px = sigma_px;
  }
}

}  // namespace alidade
