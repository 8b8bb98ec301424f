// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "alidade/detect/board/detection.h"
#include "alidade/target/board.h"

// The outcome of a search as a cache entry.

namespace alidade {

/// The key of the outcome for an image, a board and this version of the search.
[[nodiscard]] std::string entryKey(const std::string& image_identity, const Board& board);

/// All of an outcome except its name, as JSON; numbers are read back exactly.
[[nodiscard]] std::string entryText(const ImageOutcome& outcome);

/// Nothing if the text is not an outcome of a search for this board.
[[nodiscard]] std::optional<ImageOutcome> parseEntry(std::string_view text, const Board& board);

}  // namespace alidade
