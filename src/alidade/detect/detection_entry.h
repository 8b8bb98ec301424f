// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "alidade/detect/board/detection.h"
#include "alidade/target/board.h"

// The outcome of a search as an entry of a cache.

namespace alidade {

/// The key of the outcome for an image, a board and this version of the search.
[[nodiscard]] std::string entryKey(const std::string& image_identity, const Board& board);

/// All of an outcome but its name, as JSON; the numbers read back are the same.
[[nodiscard]] std::string entryText(const ImageOutcome& outcome);

/// Nothing for a text that no search for this board gives.
[[nodiscard]] std::optional<ImageOutcome> parseEntry(std::string_view text, const Board& board);

}  // namespace alidade
