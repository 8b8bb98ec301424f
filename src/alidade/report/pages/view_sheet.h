// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/report/data/report_data.h"

namespace alidade {

// Views of a page that can be opened.

/// Buttons with pictures that open the views, the largest error first, as HTML.
/// @param pictures  one per view, see viewPictures(); for an empty one its corners are drawn
[[nodiscard]] std::string viewSheet(const ReportData& data, const std::vector<std::string>& pictures);

/// The dialog in which the page's script shows a view, as HTML.
[[nodiscard]] std::string viewerHtml();

}  // namespace alidade
