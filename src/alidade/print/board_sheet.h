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
  Eigen::Vector2d size_mm;  ///< width and height as it is fed: the height is the longer side
};

/// A4 to A0 and letter, the smallest first.
[[nodiscard]] const std::vector<Paper>& knownPapers();

/// How a board is laid out on paper. The drawing is the board with a white margin and, below it, a ruler, the
/// SPEC and what to do; it is on one page or is cut into equal pieces to be joined.
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

/// Lays a board out on `paper`, turned as takes fewer pages; without, on the smallest known paper that holds
/// it in one page, or on A0.
/// @throws Error (kUsage) for more than 100 pages
[[nodiscard]] BoardSheet layOutBoard(const BoardInk& ink, const std::string& spec,
                                     const std::optional<Paper>& paper);

enum class SheetFormat { kPdf, kSvg, kPng };

/// A file of the sheet at exact scale: PDF with a page each; SVG and PNG of its only page. PNG states its
/// resolution.
/// @param dpi  pixels per inch of a PNG file
/// @throws Error (kUsage) for several pages in SVG or PNG, and for an image of more than 200 million pixels
/// or less than 50 along a side
[[nodiscard]] std::string sheetFile(const BoardSheet& sheet, SheetFormat format, double dpi);

}  // namespace alidade
