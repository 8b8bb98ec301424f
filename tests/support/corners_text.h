// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

#include <fmt/format.h>

#include "support/simulated_set.h"

namespace alidade {

/// The first views of a simulated set as a corners file (docs/files.md).
inline std::string cornersText(const SimulatedSet& set, std::size_t num_views) {
  const Checkerboard& board = set.board;
  const std::string spec = fmt::format("checkerboard:{}x{}:{}m", board.columns, board.rows, board.square_m);
  std::string text = "camera,image,width,height,board,corner_id,col,row,u,v,sigma_px\n";
  for (std::size_t v = 0; v < num_views; ++v) {
    const View& view = set.views.at(v);
    for (const Corner& corner : view.corners) {
      text += fmt::format("camera,{},{},{},{},{},{},{},{},{},\n", view.image, set.size.width, set.size.height,
                          spec, corner.id, corner.id % board.columns, corner.id / board.columns,
                          corner.pixel.x(), corner.pixel.y());
    }
  }
  return text;
}

}  // namespace alidade
