// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/guide/coverage.h"

namespace alidade {

/// Where corners were seen, as a picture of the image in characters for a terminal: the darker a cell, the
/// more corners; a dot for none. One line per row of cells, with a line end each.
[[nodiscard]] std::string coveragePicture(const CoverageReport& coverage);

}  // namespace alidade
