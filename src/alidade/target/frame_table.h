// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace alidade {

/// Which images of a rig's cameras were taken at the same time, as the user says.
struct FrameTable {
  std::vector<std::string> cameras = {};            ///< names
  std::vector<std::vector<std::string>> rows = {};  ///< a frame each: the image of each camera; empty: none

  [[nodiscard]] bool empty() const { return rows.empty(); }
};

}  // namespace alidade
