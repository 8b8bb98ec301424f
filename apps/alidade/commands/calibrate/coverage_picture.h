// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/guide/coverage.h"

namespace alidade {

/// A text picture of the image for a terminal that shows where corners were seen: the darker a cell, the more
/// corners; a dot for none. One line per row of cells, each with a line end.
[[nodiscard]] std::string coveragePicture(const CoverageReport& coverage);

}  // namespace alidade
