// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

/// Different names for files, one each: `names` if they are not empty and all differ, or else the names of
/// the folders nearest to the files that do ("cam0" of cam0/images). Nothing if no folders tell them apart.
/// @param paths  of the files, as many as names
[[nodiscard]] std::vector<std::string> distinctNames(std::vector<std::string> names,
                                                     std::span<const std::string> paths);

}  // namespace alidade
