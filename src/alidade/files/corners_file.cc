// SPDX-License-Identifier: MIT
#include "alidade/files/corners_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/file_text.h"
#include "alidade/files/text/table_lines.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

constexpr std::string_view kHeader = "camera,image,width,height,board,corner_id,col,row,u,v,sigma_px";
constexpr std::size_t kNumColumns = 11;
constexpr std::size_t kMaxCornersFileBytes = std::size_t{1} << 30U;

class Parser {
 public:
  void read(std::string_view text, const std::string& name) {
    open(name);
    for (const std::string_view line : split(text, '\n')) this->line(line);
    close();
  }

  CornersFile finish() {
    for (auto& [key, of] : views_) {
      const std::string& image = key.first;
      auto& [view, file] = of;
      auto& corners = view.corners;
      std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
      const auto twin = std::adjacent_find(corners.begin(), corners.end(),
                                           [](const auto& a, const auto& b) { return a.id == b.id; });
      if (twin != corners.end()) {
        throw inputError(
            {.where = file + ": image " + image,
             .found = "corner " + std::to_string(twin->id) + " twice",
             .expected = "each corner once",
             .next_step = "check whether the same file was given twice, or two images have one name"});
      }
      file_.views.push_back(std::move(view));
    }
    std::sort(file_.views.begin(), file_.views.end(), [](const View& a, const View& b) {
      return a.image == b.image ? a.board < b.board : naturalLess(a.image, b.image);
    });
    return std::move(file_);
  }

 private:
  // Starts a file; the following lines belong to it.
  void open(std::string name) {
    name_ = std::move(name);
    line_ = 0;
    has_header_ = false;
    has_rows_ = false;
  }

  void close() const {
    if (!has_header_) throw error("no header", std::string(kHeader));
    if (has_rows_) return;
    throw inputError(
        {.where = name_,
         .found = "no corners",
         .expected = "one row per corner",
         .next_step = "no board was found when this file was written; its '#' lines give the reasons"});
  }

  void line(std::string_view text) {
    ++line_;
    text = trim(text);
    if (text.empty() || text.starts_with('#')) return;
    if (text == kHeader) {
      has_header_ = true;
      return;
    }
    if (!has_header_)
      throw error("'" + std::string(text.substr(0, 60)) + "'", "the header " + std::string(kHeader));
    row(text);
  }

  [[nodiscard]] std::string where() const { return name_ + ":" + std::to_string(line_); }

  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = "") const {
    return inputError(
        {.where = where(), .found = "found " + found, .expected = expected, .next_step = next_step});
  }

  [[nodiscard]] int integer(const std::string& field, const char* column, int low, int high) const {
    const auto value = parseInt(field);
    if (value && *value >= low && *value <= high) return *value;
    throw error("'" + field + "' as " + column,
                "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  }

  [[nodiscard]] double number(const std::string& field, const char* column) const {
    const auto value = parseDouble(field);
    if (value && std::isfinite(*value)) return *value;
    throw error("'" + field + "' as " + column, "a finite number");
  }

  // The index of a row's board.
  std::size_t readBoard(const std::string& spec) {
    const auto known = board_of_text_.find(spec);
    if (known != board_of_text_.end()) return known->second;
    const Board board = detail::withPlace(where(), [&] { return parseBoardSpec(spec); });
    // The same board may be written in two ways.
    const auto same = std::ranges::find(file_.boards, board);
    const auto index = static_cast<std::size_t>(same - file_.boards.begin());
    if (same == file_.boards.end()) file_.boards.push_back(board);
    board_of_text_[spec] = index;
    return index;
  }

  // All boards in an image must state the same image size.
  void checkSize(const std::string& image, ImageSize size) {
    const auto [entry, is_new] = sizes_.try_emplace(image, size);
    if (!is_new && entry->second != size)
      throw error("image '" + image + "' with a different size", "the size in its previous rows");
  }

  void row(std::string_view text) {
    const auto fields = detail::splitCsv(text);
    if (!fields || fields->size() != kNumColumns) {
      throw error(fields ? std::to_string(fields->size()) + " fields" : "a quote that is not closed",
                  std::to_string(kNumColumns) + " fields: " + std::string(kHeader));
    }
    const auto& f = *fields;
    if (has_camera_ && f[0] != file_.camera)
      throw error("camera '" + f[0] + "'", "'" + file_.camera + "' as in the previous rows");
    file_.camera = f[0];
    has_camera_ = true;
    const std::size_t board_index = readBoard(f[4]);
    const Board& board = file_.boards[board_index];

    constexpr int kMaxSide = 1'000'000;
    const ImageSize size{.width = integer(f[2], "width", 1, kMaxSide),
                         .height = integer(f[3], "height", 1, kMaxSide)};
    checkSize(f[1], size);
    const auto [entry, is_new] = views_.try_emplace({f[1], board_index});
    View& view = entry->second.view;
    if (entry->second.file != name_) entry->second.file = name_;
    if (is_new) view = {.image = f[1], .size = size, .corners = {}, .board = board_index};
    Corner corner;
    corner.id = integer(f[5], "corner_id", 0, board.numCorners() - 1);
    const int column = integer(f[6], "col", 0, board.columns() - 1);
    const int row = integer(f[7], "row", 0, board.rows() - 1);
    if (corner.id != row * board.columns() + column) {
      throw error("corner " + f[5] + " at col " + f[6] + ", row " + f[7], "corner_id = row * columns + col");
    }
    corner.pixel = {number(f[8], "u"), number(f[9], "v")};
    if (!isInOrNearImage(corner.pixel, size)) {
      throw error("corner " + f[5] + " of '" + f[1] + "' at (" + f[8] + ", " + f[9] +
                      "), outside the image of " + f[2] + "x" + f[3],
                  "a corner inside the image",
                  "check the image size: width and height may be swapped, or those of another image");
    }
    if (!f[10].empty()) {
      corner.sigma_px = number(f[10], "sigma_px");
      if (!(corner.sigma_px > 0))
        throw error("'" + f[10] + "' as sigma_px", "a positive number, or an empty field");
    }
    view.corners.push_back(corner);
    has_rows_ = true;
  }

  std::string name_;
  int line_ = 0;
  bool has_header_ = false;
  bool has_rows_ = false;
  bool has_camera_ = false;
  std::map<std::string, std::size_t> board_of_text_;
  std::map<std::string, ImageSize> sizes_;  // of the images
  struct ReadView {
    View view;
    std::string file;  // the last file with corners of this view
  };
  std::map<std::pair<std::string, std::size_t>, ReadView> views_;  // by image and board
  CornersFile file_;
};

// A name as a CSV field. Rows are read line by line, so that a stray quote affects only one row.
std::string nameField(const std::string& name, const char* what) {
  if (name.find_first_of("\r\n") != std::string::npos) {
    throw inputError({.where = std::string(what) + " '" + name + "'",
                      .found = "a line break in the name",
                      .expected = "a name without line breaks",
                      .next_step = "rename it"});
  }
  return detail::csvField(name);
}

}  // namespace

std::string cornersFileText(const CornersFile& file) {
  std::string text;
  for (const std::string& comment : file.comments) {
    for (const std::string_view line : split(comment, '\n')) text += "# " + std::string(line) + "\n";
  }
  std::replace(text.begin(), text.end(), '\r', ' ');
  text += std::string(kHeader) + "\n";
  for (const View& view : file.views) {
    const Board& board = file.boards[view.board];
    const std::string prefix =
        fmt::format("{},{},{},{},{},", nameField(file.camera, "camera"), nameField(view.image, "image"),
                    view.size.width, view.size.height, board.spec());
    for (const auto& [id, pixel, sigma_px] : view.corners) {
      text += fmt::format("{}{},{},{},{},{},{}\n", prefix, id, id % board.columns(), id / board.columns(),
                          exactText(pixel.x()), exactText(pixel.y()),
                          std::isnan(sigma_px) ? "" : exactText(sigma_px));
    }
  }
  return text;
}

void writeCornersFile(const std::string& path, const CornersFile& file) {
  writeFileAtomically(path, cornersFileText(file));
}

CornersFile parseCornersFile(const std::string& text, const std::string& name) {
  Parser parser;
  parser.read(text, name);
  return parser.finish();
}

CornersFile readCornersFile(const std::string& path) {
  return readCornersFiles(std::span(&path, 1));
}

CornersFile readCornersFiles(std::span<const std::string> paths) {
  Parser parser;
  for (const std::string& path : paths) parser.read(readTextFile(path, kMaxCornersFileBytes), path);
  return parser.finish();
}

}  // namespace alidade
