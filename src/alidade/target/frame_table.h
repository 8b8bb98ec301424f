// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace alidade {

/// Images of a rig's cameras that were taken at the same time, as stated by the user.
struct FrameTable {
  std::vector<std::string> cameras = {};            ///< names
  std::vector<std::vector<std::string>> rows = {};  ///< one frame each: the image of each camera; empty: none
  std::string path = {};                            ///< of the file, for messages; empty if there is no file
  std::vector<std::size_t> lines = {};              ///< line number of each row in the file, from 1; may be
                                                    ///< empty

  [[nodiscard]] bool empty() const { return rows.empty(); }
};

}  // namespace alidade
