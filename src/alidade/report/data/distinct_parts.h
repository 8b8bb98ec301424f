// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace alidade {

/// The length in bytes of the common beginning of all names. UTF-8 characters and numbers stay whole.
[[nodiscard]] std::size_t sharedPrefix(const std::vector<std::string>& names);

/// The part of each name without the common beginning and file extension: "01" for left01.png. Names that
/// would become empty stay whole.
[[nodiscard]] std::vector<std::string> distinctParts(const std::vector<std::string>& names);

}  // namespace alidade
