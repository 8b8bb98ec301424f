// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <variant>

namespace alidade {

/// A part of the SPEC of a kind of board, after the name and counts, in the same order; the key is that of a
/// board file. A member of type double is a length unless it is a share.
template <class Kind>
struct BoardField {
  std::string_view key;
  std::variant<double Kind::*, int Kind::*, std::string Kind::*> member;
  bool is_share = false;     ///< a plain number
  bool is_optional = false;  ///< only the last field; zero or empty if omitted
};

/// Words for the parts of a kind of board, for messages.
struct BoardWords {
  std::string_view counted;             ///< counted in columns and rows: "inner corners"
  std::string_view points;              ///< points that are found: "corners"
  std::string_view marker = {};         ///< part that has an id; empty if there is none
  std::string_view other_markers = {};  ///< advice for printing another board of the kind with other ids
  std::string_view certain = {};        ///< boards of this kind that never look the same after a rotation;
                                        ///< empty if all are unambiguous
};

/// Patterns of boards. Without markers, boards with the same pattern and counts look alike.
enum class BoardPattern { kSquares, kTags, kDiscs, kStaggeredDiscs };

/// The markers of a board: ids of a family in which each id stands for one pattern.
struct MarkerIds {
  std::string family;
  int first = 0;
  int last = 0;
  friend bool operator==(const MarkerIds&, const MarkerIds&) = default;
};

/// The arrangement of the points of a board; metres.
struct PointLayout {
  int columns = 0;
  int rows = 0;
  double spacing_m = 0;      ///< shortest distance between neighbours
  double margin_m = 0;       ///< from the outermost points to the edge of the print
  double disc_radius_m = 0;  ///< see Board::discRadius()
  int symmetry_step = 4;     ///< see Board::symmetryStep()
};

/// Reason why a board cannot exist.
struct BoardFault {
  std::string found;
  std::string expected;
  std::string next_step = {};
};

}  // namespace alidade
