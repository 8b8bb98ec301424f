// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace alidade::detail {

/// A file of another kind that people take for a camera file.
struct ForeignFile {
  std::string what;       ///< what it seems to be: "a HEIC photograph"
  std::string next_step;  ///< how to get a camera file
};

/// The kind of a file by bytes and words that only this kind has. Nothing for text that may be anything.
[[nodiscard]] std::optional<ForeignFile> knownForeignFile(std::string_view content, std::string_view file);

/// The notation of a text that is none of the notations of camera files: TOML, INI, a table. Nothing if it
/// resembles none.
[[nodiscard]] std::optional<ForeignFile> foreignText(std::string_view text);

/// The numbers of a text under names of camera parameters, and its first camera matrix: "fx 1398.03, fy
/// 1398.03, cx 1080.5, cy 625.88 (from line 2)". Empty if there are none.
[[nodiscard]] std::string cameraNumbersIn(std::string_view text);

}  // namespace alidade::detail
