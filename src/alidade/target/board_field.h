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

/// What people call the parts of a kind of board, for messages.
struct BoardWords {
  std::string_view counted;             ///< what its columns and rows are: "inner corners"
  std::string_view points;              ///< what is found of it: "corners"
  std::string_view marker = {};         ///< what has an id; empty without
  std::string_view other_markers = {};  ///< how to print another board of the kind with other ids
  std::string_view certain = {};        ///< where a board may look the same after a rotation: which never do
};

/// Without markers, boards of one pattern and the same counts look alike.
enum class BoardPattern { kSquares, kTags, kDiscs, kStaggeredDiscs };

/// The markers of a board: ids of a family in which every id has one pattern.
struct MarkerIds {
  std::string family;
  int first = 0;
  int last = 0;
  friend bool operator==(const MarkerIds&, const MarkerIds&) = default;
};

/// The points of a board as a whole; metres.
struct PointLayout {
  int columns = 0;
  int rows = 0;
  double spacing_m = 0;      ///< between neighbours, the shortest
  double margin_m = 0;       ///< how far the print goes beyond the outermost ones
  double disc_radius_m = 0;  ///< see Board::discRadius()
  int symmetry_step = 4;     ///< see Board::symmetryStep()
};

/// Why a board cannot exist.
struct BoardFault {
  std::string found;
  std::string expected;
  std::string next_step = {};
};

}  // namespace alidade
