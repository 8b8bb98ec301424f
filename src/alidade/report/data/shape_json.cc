// SPDX-License-Identifier: MIT
#include "alidade/report/data/shape_json.h"

#include "alidade/core/mapped.h"

namespace alidade {

json fittedShapeJson(const Fit& fit, std::size_t board) {
  const FitBoard& of_board = fit.boards[board];
  const bool is_estimated = !of_board.is_shape_fixed;
  const BoardShape bend = is_estimated ? of_board.shape : BoardShape{};
  json document = {{"estimated", is_estimated},
                   {"bend_x_m", bend.bend_x_m},
                   {"bend_y_m", bend.bend_y_m},
                   {"uneven", of_board.isUneven()}};
  if (of_board.isUneven()) {
    const Eigen::Vector2d rms_m = offsetRms(of_board.shape);
    document["offsets_m"] =
        mapped(of_board.shape.offsets_m, [](const Eigen::Vector3d& offset) { return vectorJson(offset); });
    document["offset_rms_in_plane_m"] = rms_m.x();
    document["offset_rms_across_m"] = rms_m.y();
  }
  if (fit.boards.size() > 1) {
    document["board"] = of_board.target.spec();
    document["num_views"] = numViews(fit, board);
  }
  return document;
}

}  // namespace alidade
