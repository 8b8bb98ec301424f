// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <variant>

namespace alidade {

/// What a SPEC says of a kind of board behind its name and counts, in its order; the key is that of a board
/// file. A member of type double is a length, if it is not a share.
template <class Kind>
struct BoardField {
  std::string_view key;
  std::variant<double Kind::*, int Kind::*, std::string Kind::*> member;
  bool is_share = false;     ///< a plain number
  bool is_optional = false;  ///< the last one may be; it is zero or empty where it is left out
};

/// Why a board cannot exist.
struct BoardFault {
  std::string found;
  std::string expected;
  std::string next_step = {};
};

}  // namespace alidade
