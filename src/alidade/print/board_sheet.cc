// SPDX-License-Identifier: MIT
#include "alidade/print/board_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <numbers>

#include <cairo/cairo-pdf.h>
#include <cairo/cairo-svg.h>
#include <cairo/cairo.h>
#include <fmt/format.h>
#include <boost/crc.hpp>

#include "alidade/core/error.h"

namespace alidade {
namespace {

using Eigen::Vector2d;

constexpr double kMmPerInch = 25.4;
constexpr double kPointsPerInch = 72;
constexpr double kUnprintableMm = 4.5;  // at each side of a page
constexpr double kCutMarkMm = 5;        // at each side of a piece
constexpr double kWhiteMm = 6;          // around the pattern
constexpr double kFooterMm = 12;
constexpr double kLeastWidthMm = 110;  // for the footer

struct Freed {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using Surface = std::unique_ptr<cairo_surface_t, Freed>;
using Context = std::unique_ptr<cairo_t, Freed>;

void checkStatus(cairo_status_t status) {
  if (status == CAIRO_STATUS_SUCCESS) return;
  if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
  throw std::runtime_error(std::string("drawing the board: ") + cairo_status_to_string(status));
}

cairo_status_t append(void* text, const unsigned char* bytes, unsigned int size) {
  static_cast<std::string*>(text)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

Vector2d extentMm(const BoardInk& ink) {
  return 1000 * ink.extent.sizes();
}

// All lengths are in millimetres from the top left corner of the drawing.
class SheetPen {
 public:
  SheetPen(cairo_t* context, const BoardSheet& sheet) : context_(context), sheet_(sheet) {}

  void drawAll() const {
    drawInk();
    drawAxes();
    drawRuler();
    drawText();
  }

  void text(double x, double y, double height_mm, const std::string& text) const {
    cairo_set_font_size(context_, height_mm);
    cairo_move_to(context_, x, y);
    cairo_show_text(context_, text.c_str());
  }
  void line(double x0, double y0, double x1, double y1) const {
    cairo_move_to(context_, x0, y0);
    cairo_line_to(context_, x1, y1);
    cairo_stroke(context_);
  }

 private:
  // Top left corner of the pattern.
  [[nodiscard]] Vector2d origin() const {
    return {0.5 * (sheet_.drawing_mm.x() - extentMm(sheet_.ink).x()), kWhiteMm};
  }

  void drawInk() const {
    const Vector2d shift = origin() - 1000 * sheet_.ink.extent.min();
    for (const auto& box : sheet_.ink.boxes) {
      const Vector2d at = 1000 * box.min() + shift;
      const Vector2d size = 1000 * box.sizes();
      cairo_rectangle(context_, at.x(), at.y(), size.x(), size.y());
    }
    for (const auto& disc : sheet_.ink.discs) {
      const Vector2d middle = 1000 * disc.center() + shift;
      cairo_new_sub_path(context_);
      cairo_arc(context_, middle.x(), middle.y(), 500 * disc.sizes().x(), 0, 2 * std::numbers::pi);
    }
    cairo_fill(context_);
  }

  // Draws the axes, which show the corner where ids start.
  void drawAxes() const {
    constexpr double kLength = 8;
    const Vector2d corner = origin() - Vector2d(2.5, 2.5);
    cairo_set_line_width(context_, 0.3);
    line(corner.x(), corner.y(), corner.x() + kLength, corner.y());
    line(corner.x(), corner.y(), corner.x(), corner.y() + kLength);
    text(corner.x() + kLength + 1, corner.y() + 0.8, 2.5, "x");
    text(corner.x() - 0.6, corner.y() + kLength + 2.5, 2.5, "y");
  }

  void drawRuler() const {
    constexpr int kNumTicks = 10;
    constexpr double kTickMm = 10;
    const double y = sheet_.drawing_mm.y() - 7;
    cairo_set_line_width(context_, 0.2);
    line(kWhiteMm, y, kWhiteMm + kNumTicks * kTickMm, y);
    for (int i = 0; i <= kNumTicks; ++i) {
      const double x = kWhiteMm + i * kTickMm;
      line(x, y, x, y - (i % 5 == 0 ? 3 : 1.5));
    }
  }

  void drawText() const {
    const double y = sheet_.drawing_mm.y() - 3;
    text(kWhiteMm, y, 2.6, "100 mm: print at 100 % and measure.   " + sheet_.spec);
  }

  cairo_t* context_;
  const BoardSheet& sheet_;
};

// Draws cut marks and the position of the piece. The top left corner of the piece is at (0, 0).
void drawCutMarks(cairo_t* context, const BoardSheet& sheet, int column, int row) {
  const SheetPen pen(context, sheet);
  const Vector2d size = sheet.piece_mm;
  constexpr double kGapMm = 0.5;
  cairo_set_line_width(context, 0.1);
  for (const double x : {0.0, size.x()}) {
    pen.line(x, -kCutMarkMm, x, -kGapMm);
    pen.line(x, size.y() + kGapMm, x, size.y() + kCutMarkMm);
  }
  for (const double y : {0.0, size.y()}) {
    pen.line(-kCutMarkMm, y, -kGapMm, y);
    pen.line(size.x() + kGapMm, y, size.x() + kCutMarkMm, y);
  }
  pen.text(kCutMarkMm, size.y() + 3.5, 2.6,
           fmt::format("column {} of {}, row {} of {}: cut at the marks and join on a flat plate", column + 1,
                       sheet.columns, row + 1, sheet.rows));
}

void drawPage(cairo_t* context, const BoardSheet& sheet, int column, int row) {
  cairo_save(context);
  if (sheet.numPages() == 1) {
    const Vector2d shift = 0.5 * (sheet.paper.size_mm - sheet.drawing_mm);
    cairo_translate(context, shift.x(), shift.y());
  } else {
    constexpr double kEdgeMm = kUnprintableMm + kCutMarkMm;
    cairo_translate(context, kEdgeMm, kEdgeMm);
    drawCutMarks(context, sheet, column, row);
    cairo_rectangle(context, 0, 0, sheet.piece_mm.x(), sheet.piece_mm.y());
    cairo_clip(context);
    cairo_translate(context, -column * sheet.piece_mm.x(), -row * sheet.piece_mm.y());
  }
  SheetPen(context, sheet).drawAll();
  cairo_restore(context);
}

// Context of a surface with `per_mm` units per millimetre.
Context makeContext(cairo_surface_t* surface, double per_mm) {
  Context context(cairo_create(surface));
  checkStatus(cairo_status(context.get()));
  cairo_scale(context.get(), per_mm, per_mm);
  cairo_select_font_face(context.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  return context;
}

// PDF and SVG measure in points.
template <class MakeSurface>
std::string vectorFile(const BoardSheet& sheet, const MakeSurface& make_surface) {
  std::string file;
  const Vector2d size = kPointsPerInch / kMmPerInch * sheet.paper.size_mm;
  const Surface surface(make_surface(append, &file, size.x(), size.y()));
  checkStatus(cairo_surface_status(surface.get()));
  {
    const Context context = makeContext(surface.get(), kPointsPerInch / kMmPerInch);
    for (int row = 0; row < sheet.rows; ++row) {
      for (int column = 0; column < sheet.columns; ++column) {
        drawPage(context.get(), sheet, column, row);
        cairo_show_page(context.get());
      }
    }
    checkStatus(cairo_status(context.get()));
  }
  cairo_surface_finish(surface.get());
  checkStatus(cairo_surface_status(surface.get()));
  return file;
}

cairo_surface_t* makePdf(cairo_write_func_t write, void* file, double width, double height) {
  cairo_surface_t* surface = cairo_pdf_surface_create_for_stream(write, file, width, height);
  cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, "");  // so that the same board
                                                                                // gives the same bytes
  return surface;
}

cairo_surface_t* makeSvg(cairo_write_func_t write, void* file, double width, double height) {
  return cairo_svg_surface_create_for_stream(write, file, width, height);
}

std::string bigEndian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xffU);
  return bytes;
}

// Inserts the resolution after the header chunk, with which a PNG file starts (PNG specification, 11.3.5.3).
void stateResolution(std::string& png, double dpi) {
  constexpr std::size_t kBehindHeader = 33;
  const std::string per_metre = bigEndian(static_cast<std::uint32_t>(std::lround(1000 * dpi / kMmPerInch)));
  const std::string chunk = "pHYs" + per_metre + per_metre + '\1';
  boost::crc_32_type crc;
  crc.process_bytes(chunk.data(), chunk.size());
  png.insert(kBehindHeader,
             bigEndian(static_cast<std::uint32_t>(chunk.size() - 4)) + chunk + bigEndian(crc.checksum()));
}

std::string pngFile(const BoardSheet& sheet, double dpi) {
  const Vector2d pixels = (dpi / kMmPerInch * sheet.paper.size_mm).array().round();
  constexpr double kMaxPixels = 2e8;
  constexpr double kMinSidePixels = 50;
  if (pixels.prod() > kMaxPixels || pixels.minCoeff() < kMinSidePixels) {
    throw usageError({.where = "--dpi",
                      .found = fmt::format("an image of {:.0f}x{:.0f} pixels", pixels.x(), pixels.y()),
                      .expected = "50 pixels along each side to 200 million in total",
                      .next_step = "use a PDF file, or another --dpi, such as 300"});
  }
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(pixels.x()),
                                                   static_cast<int>(pixels.y())));
  checkStatus(cairo_surface_status(surface.get()));
  const Context context = makeContext(surface.get(), dpi / kMmPerInch);
  cairo_set_source_rgb(context.get(), 1, 1, 1);
  cairo_paint(context.get());
  cairo_set_source_rgb(context.get(), 0, 0, 0);
  drawPage(context.get(), sheet, 0, 0);
  checkStatus(cairo_status(context.get()));
  std::string file;
  checkStatus(cairo_surface_write_to_png_stream(surface.get(), append, &file));
  stateResolution(file, dpi);
  return file;
}

BoardSheet onPaper(const BoardInk& ink, const std::string& spec, const Paper& paper, bool is_turned) {
  BoardSheet sheet{.ink = ink, .spec = spec, .paper = paper, .drawing_mm = {}, .piece_mm = {}};
  if (is_turned) std::swap(sheet.paper.size_mm.x(), sheet.paper.size_mm.y());
  sheet.drawing_mm = extentMm(ink) + Vector2d(2 * kWhiteMm, 2 * kWhiteMm + kFooterMm);
  sheet.drawing_mm.x() = std::max(sheet.drawing_mm.x(), kLeastWidthMm);
  const Vector2d printable = sheet.paper.size_mm.array() - 2 * kUnprintableMm;
  sheet.piece_mm = printable;
  if ((sheet.drawing_mm.array() <= printable.array()).all()) return sheet;
  sheet.piece_mm = printable.array() - 2 * kCutMarkMm;
  const Vector2d pieces = (sheet.drawing_mm.array() / sheet.piece_mm.array()).ceil();
  sheet.columns = static_cast<int>(pieces.x());
  sheet.rows = static_cast<int>(pieces.y());
  return sheet;
}

}  // namespace

const std::vector<Paper>& knownPapers() {
  static const std::vector<Paper> papers = {{"A4", {210, 297}}, {"letter", {215.9, 279.4}},
                                            {"A3", {297, 420}}, {"A2", {420, 594}},
                                            {"A1", {594, 841}}, {"A0", {841, 1189}}};
  return papers;
}

BoardSheet layOutBoard(const BoardInk& ink, const std::string& spec, const std::optional<Paper>& paper) {
  std::vector<BoardSheet> sheets;
  for (const Paper& candidate : paper ? std::vector<Paper>{*paper} : knownPapers()) {
    if (!paper && candidate.name == "letter") continue;  // A4 is equally large
    for (const bool is_turned : {false, true}) {
      sheets.push_back(onPaper(ink, spec, candidate, is_turned));
      if (sheets.back().numPages() == 1) return sheets.back();
    }
  }
  // The better orientation on the largest paper.
  const BoardSheet& best =
      *std::min_element(sheets.end() - 2, sheets.end(),
                        [](const BoardSheet& a, const BoardSheet& b) { return a.numPages() < b.numPages(); });
  constexpr int kMaxPages = 100;
  if (best.numPages() > kMaxPages) {
    throw usageError(
        {.where = "board " + spec,
         .found = fmt::format("{:.0f}x{:.0f} mm, which takes {} pages of {}", best.drawing_mm.x(),
                              best.drawing_mm.y(), best.numPages(), best.paper.name),
         .expected = fmt::format("at most {} pages", kMaxPages),
         .next_step = "use a larger --paper, or make the squares smaller"});
  }
  return best;
}

std::string sheetFile(const BoardSheet& sheet, SheetFormat format, double dpi) {
  if (format == SheetFormat::kPdf) return vectorFile(sheet, makePdf);
  if (sheet.numPages() > 1) {
    throw usageError(
        {.where = "board " + sheet.spec,
         .found = fmt::format("{:.0f}x{:.0f} mm, which takes {} pages of {}", sheet.drawing_mm.x(),
                              sheet.drawing_mm.y(), sheet.numPages(), sheet.paper.name),
         .expected = "one page in an SVG or PNG file",
         .next_step = "use a PDF file, or a larger --paper"});
  }
  return format == SheetFormat::kSvg ? vectorFile(sheet, makeSvg) : pngFile(sheet, dpi);
}

}  // namespace alidade
