// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace alidade {

/// How many bytes all names begin with alike. UTF-8 characters and numbers stay whole.
[[nodiscard]] std::size_t sharedPrefix(const std::vector<std::string>& names);

/// The part of each name without the beginning and the file extension that all of them share: "01" for
/// left01.png. Names of which nothing would be left stay whole.
[[nodiscard]] std::vector<std::string> distinctParts(const std::vector<std::string>& names);

}  // namespace alidade
