// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace alidade {

// The text files of assets/, which the build turns into strings.

[[nodiscard]] std::string_view paletteCss();  ///< colours, for bright and dark
[[nodiscard]] std::string_view figureCss();   ///< classes of drawings
[[nodiscard]] std::string_view pageCss();     ///< everything else of the page
[[nodiscard]] std::string_view pageScript();  ///< opens views, tells values

}  // namespace alidade
