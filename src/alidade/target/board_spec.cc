// SPDX-License-Identifier: MIT
#include "alidade/target/board_spec.h"

#include <array>
#include <cmath>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

constexpr int kMinCount = 3;
constexpr int kMaxCount = 200;
// A square of a tenth of a millimetre is under a microscope, one of two metres on a hangar's floor.
constexpr double kMinSquare = 1e-4;
constexpr double kMaxSquare = 2.0;
constexpr const char* kExample =
    "for example checkerboard:9x6:25mm (columns x rows of inner corners, then the side of a square)";

Error wrongSpec(std::string_view spec, const std::string& found, const std::string& expected,
                const std::string& next_step = kExample) {
  return usageError({.where = "board '" + std::string(spec) + "'",
                     .found = found,
                     .expected = expected,
                     .next_step = next_step});
}

int parseCount(std::string_view spec, std::string_view text) {
  const auto count = parseInt(text);
  if (!count) {
    throw wrongSpec(spec, "'" + std::string(text) + "' as a count of inner corners", "a whole number");
  }
  return *count;
}

}  // namespace

double parseLength(std::string_view text, const std::string& where) {
  struct Unit {
    std::string_view name;
    double per_metre;
  };
  // Divided, not multiplied by 0.001: 25 / 1000 is the double nearest to 0.025.
  constexpr std::array<Unit, 3> kUnits = {{{"mm", 1000.0}, {"cm", 100.0}, {"m", 1.0}}};
  std::string_view number = trim(text);
  double metres_per_unit = 1.0;
  double units_per_metre = 1.0;
  if (number.ends_with("in")) {
    number.remove_suffix(2);
    metres_per_unit = 0.0254;
  } else {
    for (const Unit& unit : kUnits) {
      if (!number.ends_with(unit.name)) continue;
      number.remove_suffix(unit.name.size());
      units_per_metre = unit.per_metre;
      break;
    }
  }
  const auto value = parseDouble(trim(number));
  if (!value || !std::isfinite(*value)) {
    throw usageError({.where = where,
                      .found = "'" + std::string(text) + "'",
                      .expected = "a length such as 25mm, 2.5cm, 0.025m or 1in"});
  }
  return *value * metres_per_unit / units_per_metre;
}

void checkBoard(const Checkerboard& board, const std::string& where) {
  for (const int count : {board.columns, board.rows}) {
    if (count >= kMinCount && count <= kMaxCount) continue;
    throw usageError(
        {.where = where,
         .found = std::to_string(board.columns) + "x" + std::to_string(board.rows) + " inner corners",
         .expected = "between " + std::to_string(kMinCount) + " and " + std::to_string(kMaxCount) +
                     " in each direction",
         .next_step = kExample});
  }
  if (board.square_m >= kMinSquare && board.square_m <= kMaxSquare) return;
  throw usageError(
      {.where = where,
       .found = "squares of " + exactText(board.square_m) + " m",
       .expected = "between 0.1 mm and 2 m",
       .next_step = board.square_m > kMaxSquare && board.square_m <= 1000 * kMaxSquare
                        ? "a bare number is metres: did you mean " + exactText(board.square_m) + "mm?"
                        : kExample});
}

Checkerboard parseBoardSpec(std::string_view spec) {
  const std::vector<std::string_view> parts = split(trim(spec), ':');
  const std::string kind(parts.front());
  if (kind != "checkerboard") {
    const std::vector<std::string> kinds = {"checkerboard"};
    throw wrongSpec(spec, "board kind '" + kind + "'",
                    "checkerboard, or a YAML file that describes the board",
                    didYouMean(kind, kinds, kExample));
  }
  if (parts.size() != 3) {
    throw wrongSpec(spec, std::to_string(parts.size()) + " part" + (parts.size() == 1 ? "" : "s"),
                    "three parts: checkerboard:COLUMNSxROWS:SQUARE");
  }
  const std::vector<std::string_view> counts = split(parts[1], 'x');
  if (counts.size() != 2) {
    throw wrongSpec(spec, "'" + std::string(parts[1]) + "' as the size", "COLUMNSxROWS, for example 9x6");
  }
  Checkerboard board;
  board.columns = parseCount(spec, counts[0]);
  board.rows = parseCount(spec, counts[1]);
  const std::string where = "board '" + std::string(spec) + "'";
  board.square_m = parseLength(parts[2], where);
  checkBoard(board, where);
  return board;
}

}  // namespace alidade
