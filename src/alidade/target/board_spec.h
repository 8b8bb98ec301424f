// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "alidade/target/board.h"

namespace alidade {

/// A kind of board as a SPEC names it.
struct BoardKindName {
  std::string name;
  std::string_view aliases;       ///< names in other programs, separated by blanks
  std::string example;            ///< with explanations of its parts
  std::vector<std::string> keys;  ///< of the parts after the counts
  std::size_t num_required = 0;   ///< number of keys that are required; the others may be omitted
};
[[nodiscard]] const std::vector<BoardKindName>& boardKinds();

/// The name of a kind that another program's word for it stands for; other words are returned.
[[nodiscard]] std::string boardKindOf(std::string_view word);

/// Reads a board SPEC such as "checkerboard:9x6:25mm": the kind, columns x rows, and the fields() of the
/// kind. Lengths carry a unit (mm, cm, m, in); a bare number is metres.
/// @throws Error (kUsage) saying which part is wrong, with an example that works.
[[nodiscard]] Board parseBoardSpec(std::string_view spec);

/// Reads a length with its unit, in metres. `where` names the place for the message.
/// @throws Error (kUsage)
[[nodiscard]] double parseLength(std::string_view text, const std::string& where);

}  // namespace alidade
