// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace alidade {

/// Which images of a rig's cameras were taken at the same time, as the user says.
struct FrameTable {
  std::vector<std::string> cameras = {};            ///< names
  std::vector<std::vector<std::string>> rows = {};  ///< a frame each: the image of each camera; empty: none
  std::string path = {};                            ///< of the file, for messages; empty: from no file
  std::vector<std::size_t> lines = {};              ///< where each row stands in the file, from 1; or none

  [[nodiscard]] bool empty() const { return rows.empty(); }
};

}  // namespace alidade
