// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

namespace alidade {

// The text files of assets/, which the build converts to strings.

[[nodiscard]] std::string_view paletteCss();  ///< colours, light and dark
[[nodiscard]] std::string_view figureCss();   ///< classes of drawings
[[nodiscard]] std::string_view pageCss();     ///< rest of the page's style
[[nodiscard]] std::string_view pageScript();  ///< opens views, shows values

}  // namespace alidade
