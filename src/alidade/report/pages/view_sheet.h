// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/report/data/report_data.h"

namespace alidade {

// Views that open.

/// Buttons with pictures that open the views, the largest error first, as HTML.
/// @param pictures  one a view, see viewPictures(); its corners stand in the place of an empty one
[[nodiscard]] std::string viewSheet(const ReportData& data, const std::vector<std::string>& pictures);

/// The dialog in which the page's script shows a view, as HTML.
[[nodiscard]] std::string viewerHtml();

}  // namespace alidade
