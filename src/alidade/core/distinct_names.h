// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

/// Different names for files, one each: `names` if they are distinct and not empty, otherwise the names of
/// the nearest parent folders that differ ("cam0" of cam0/images). Nothing if no folders distinguish them.
/// @param paths  of the files, as many as names
[[nodiscard]] std::vector<std::string> distinctNames(std::vector<std::string> names,
                                                     std::span<const std::string> paths);

}  // namespace alidade
