// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/target/board_ink.h"

namespace alidade {

struct Paper {
  std::string name;         ///< "A4"
  Eigen::Vector2d size_mm;  ///< width and height in feed direction: the height is the longer side
};

/// A4 to A0 and letter, smallest first.
[[nodiscard]] const std::vector<Paper>& knownPapers();

/// Layout of a board on paper. The drawing is the board with a white margin and, below it, a ruler, the SPEC
/// and instructions. It is printed on one page or cut into equal pieces to be joined.
struct BoardSheet {
  BoardInk ink;
  std::string spec;            ///< as on the command line
  Paper paper;                 ///< turned as the pages are
  Eigen::Vector2d drawing_mm;  ///< width and height
  Eigen::Vector2d piece_mm;    ///< of the drawing on each page, at most
  int columns = 1;             ///< of pages
  int rows = 1;

  [[nodiscard]] int numPages() const { return columns * rows; }
};

/// Lays a board out on `paper` in the orientation that takes fewer pages. Without `paper`, uses the smallest
/// known paper that holds the board on one page, or A0.
/// @throws Error (kUsage) for more than 100 pages
[[nodiscard]] BoardSheet layOutBoard(const BoardInk& ink, const std::string& spec,
                                     const std::optional<Paper>& paper);

enum class SheetFormat { kPdf, kSvg, kPng };

/// A file of the sheet at exact scale: PDF with all pages; SVG and PNG for a sheet of one page. PNG states
/// its resolution.
/// @param dpi  pixels per inch of a PNG file
/// @throws Error (kUsage) for several pages in SVG or PNG, and for an image of more than 200 million pixels
/// or fewer than 50 along a side
[[nodiscard]] std::string sheetFile(const BoardSheet& sheet, SheetFormat format, double dpi);

}  // namespace alidade
