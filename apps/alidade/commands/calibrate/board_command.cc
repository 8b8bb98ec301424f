// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <boost/algorithm/string/predicate.hpp>

#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/files/board_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/print/board_sheet.h"
#include "alidade/print/ink_of_board.h"
#include "alidade/report/data/json_output.h"
#include "alidade/target/board_spec.h"
#include "board_views.h"
#include "command.h"
#include "console.h"
#include "outputs.h"

namespace alidade {
namespace {

constexpr std::array<std::pair<std::string_view, SheetFormat>, 3> kFormats = {
    {{".pdf", SheetFormat::kPdf}, {".svg", SheetFormat::kSvg}, {".png", SheetFormat::kPng}}};

// "A4", or "300x400mm": any unit, after the second number.
Paper parsePaper(const std::string& text) {
  const std::vector<std::string> names = mapped(knownPapers(), &Paper::name);
  for (const Paper& paper : knownPapers()) {
    if (boost::iequals(paper.name, text)) return paper;
  }
  constexpr double kLeastMm = 50;
  constexpr double kMostMm = 5000;
  const std::vector<std::string_view> sides = split(text, 'x');
  const std::size_t unit = text.find_last_of("0123456789") + 1;
  if (sides.size() == 2 && unit > 0 && unit < text.size()) {
    const auto sideMm = [&](std::string side) { return 1000 * parseLength(side, "--paper"); };
    const bool has_unit = sides[0].find_last_of("0123456789") + 1 < sides[0].size();
    const Eigen::Vector2d size(sideMm(std::string(sides[0]) + (has_unit ? "" : text.substr(unit))),
                               sideMm(std::string(sides[1])));
    if (size.minCoeff() >= kLeastMm && size.maxCoeff() <= kMostMm)
      return {.name = text, .size_mm = {size.minCoeff(), size.maxCoeff()}};
  }
  throw flagError("--paper", "'" + text + "'",
                  join(names, ", ") + ", or WIDTHxHEIGHT with a unit, 50 mm to 5 m",
                  didYouMean(text, names, "for example --paper A3 or --paper 300x400mm"));
}

class BoardCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade board checkerboard:9x6:25mm -o board.pdf\nPrint at 100 % (no fitting to the page), "
        "measure the ruler, and glue the print on a flat plate.");
    flags.add("board", &board_, kBoardText, kSpec);
    flags.redirect({"--board", "--type", "--rows", "--columns", "--size", "--square"},
                   "the SPEC has no flag: alidade board checkerboard:9x6:25mm -o board.pdf");
    flags.add("-o,--output", &output_, "File to write: .pdf, .svg or .png", kFilePath);
    flags.add(
        "--paper", &paper_,
        "A4, A3, A2, A1, A0, letter or WIDTHxHEIGHT, for example 300x400mm (default: the smallest of A4 to "
        "A0 that holds the board). A larger board is cut into pages");
    flags.add("--dpi", &dpi_, "Resolution of a PNG file, pixels per inch", {.complaint = positiveNumber});
    flags.addCommon(common_, false);
  }

  int run(const Flags&) override {
    if (board_.empty()) throw missing("no board", "a board SPEC, for example checkerboard:9x6:25mm");
    if (output_.empty()) throw missing("no --output", "-o FILE, for example -o board.pdf");
    const auto* format = std::ranges::find_if(
        kFormats, [&](const auto& known) { return boost::iends_with(output_, known.first); });
    if (format == kFormats.end()) {
      throw flagError("--output " + output_, "a name without a known ending",
                      "a name that ends with .pdf, .svg or .png");
    }
    checkOutput(output_, {board_, common_.config}, common_);
    const Board board = readBoard(board_);
    const BoardSheet sheet = layOutBoard(inkOf(board), board.spec(),
                                         paper_.empty() ? std::nullopt : std::optional(parsePaper(paper_)));
    writeFileAtomically(output_, sheetFile(sheet, format->second, dpi_));
    if (sheet.numPages() > 1 && !common_.quiet) {
      printMessage(fmt::format(
          "warning: the board takes {:.0f}x{:.0f} mm, more than {}: it was cut into {} pages, and boards "
          "that are joined are rarely flat\n  next: have it printed on larger paper, or make the squares "
          "smaller",
          sheet.drawing_mm.x(), sheet.drawing_mm.y(), sheet.paper.name, sheet.numPages()));
    }
    answer(
        [&] {
          return jsonText({{"output", output_},
                           {"board", sheet.spec},
                           {"paper", sheet.paper.name},
                           {"page_mm", vectorJson(sheet.paper.size_mm)},
                           {"drawing_mm", vectorJson(sheet.drawing_mm)},
                           {"num_pages", sheet.numPages()}});
        },
        [&] {
          return fmt::format("{}: {} on {} ({}); print at 100 %\n", printable(output_), sheet.spec,
                             sheet.paper.name, counted(sheet.numPages(), "page"));
        });
    return 0;
  }

 private:
  std::string board_;
  std::string output_;
  std::string paper_;
  double dpi_ = 300;
};

}  // namespace

const CommandEntry kBoardCommand = {"board", "Draw a board to print, at exact scale", made<BoardCommand>};

}  // namespace alidade
