// SPDX-License-Identifier: MIT
#include "alidade/files/corners_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
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

// A parser of files with corners, line by line. The errors name the line.
class LineParser {
 protected:
  [[nodiscard]] std::string where() const { return name_ + ":" + std::to_string(line_); }

  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = "") const {
    return detail::errorAt(where(), "found " + found, expected, next_step);
  }

  [[nodiscard]] double number(const std::string& field, const char* column,
                              const char* expected = "a finite number") const {
    const auto value = parseDouble(field);
    if (value && std::isfinite(*value)) return *value;
    throw error("'" + field + "' as " + column, expected);
  }

  std::string name_;  // of the file
  int line_ = 0;
  CornersFile file_;
};

class CsvParser : LineParser {
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
        throw detail::errorAt(file + ": image " + image, "corner " + std::to_string(twin->id) + " twice",
                              "each corner once",
                              "check whether the same file was given twice, or two images have one name");
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
    throw detail::errorAt(name_, "no corners", "one row per corner",
                          "no board was found when this file was written; its '#' lines give the reasons");
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

  [[nodiscard]] int integer(const std::string& field, const char* column, int low, int high) const {
    const auto value = parseInt(field);
    if (value && *value >= low && *value <= high) return *value;
    throw error("'" + field + "' as " + column,
                "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
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
    auto& [view, file] = entry->second;
    if (file != name_) file = name_;
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

  bool has_header_ = false;
  bool has_rows_ = false;
  bool has_camera_ = false;
  std::map<std::string, std::size_t> board_of_text_;
  std::map<std::string, ImageSize> sizes_;  // of the images
  // By image and board, with the last file that has corners of the view.
  std::map<std::pair<std::string, std::size_t>, std::pair<View, std::string>> views_;
};

constexpr std::string_view kLegend = "filename x y";
constexpr std::string_view kExpectedLegend =
    "the legend '# filename x y', '# filename x y level' or '# filename x y weight'";
constexpr std::string_view kMissing = "-";

bool isPrintableAscii(char c) {
  return c >= ' ' && c <= '~';
}

class VnlParser : LineParser {
 public:
  VnlParser(const Board& board, ImageSize size) : size_(size) { file_.boards.push_back(board); }

  void read(std::string_view text, const std::string& name) {
    name_ = name;
    line_ = 0;
    num_values_ = 0;
    const std::size_t num_views = file_.views.size();
    for (const std::string_view line : split(text, '\n')) this->line(line);
    closeImage();
    if (num_values_ == 0) throw detail::errorAt(name_, "no legend", std::string(kExpectedLegend));
    if (file_.views.size() == num_views)
      throw detail::errorAt(name_, "no corners", "images that show the board",
                            "no board was found when this file was written");
  }

  CornersFile finish() {
    setSigmas();
    std::ranges::sort(file_.views,
                      [](const View& a, const View& b) { return naturalLess(a.image, b.image); });
    return std::move(file_);
  }

 private:
  static constexpr const char* kNumber = "a finite number, or - for a corner that was not found";

  [[nodiscard]] const Board& board() const { return file_.boards.front(); }

  void line(std::string_view text) {
    ++line_;
    text = trim(text);
    if (text.empty()) return;
    if (text.starts_with('#')) {
      legend(text.substr(1));
    } else if (num_values_ == 0) {
      throw error("'" + std::string(text.substr(0, 60)) + "'",
                  std::string(kExpectedLegend) + " before the rows");
    } else {
      row(detail::words(text));
    }
  }

  // Other comments are ignored.
  void legend(std::string_view text) {
    const std::vector<std::string> names = detail::words(text);
    if (names.empty() || names.front() != "filename") return;
    const std::string columns = join(names, " ");
    const std::string start(kLegend);
    if (columns != start && columns != start + " level" && columns != start + " weight")
      throw error("the legend '# " + columns.substr(0, 60) + "'", std::string(kExpectedLegend));
    num_values_ = names.size();
    is_weighted_ = names.back() == "weight";
  }

  void row(const std::vector<std::string>& values) {
    if (values.size() != num_values_) {
      throw error(std::to_string(values.size()) + " values",
                  std::to_string(num_values_) + " as in the legend, separated by blanks",
                  "a corner that was not found has a - for each value");
    }
    if (values.front() != view_.image) {
      closeImage();
      openImage(values.front());
    }
    const std::optional<Corner> seen = corner(values);
    if (seen) view_.corners.push_back(*seen);
    ++num_rows_;
  }

  // Nothing for a corner that was not found.
  [[nodiscard]] std::optional<Corner> corner(const std::vector<std::string>& values) const {
    if (std::ranges::find(values.begin() + 1, values.end(), kMissing) != values.end()) return std::nullopt;
    const Eigen::Vector2d pixel(number(values[1], "x", kNumber), number(values[2], "y", kNumber));
    const double sigma = values.size() == 3 ? 1.0 : relativeSigma(values[3]);
    if (pixel.minCoeff() < 0 || std::isnan(sigma)) return std::nullopt;
    if (!isInOrNearImage(pixel, size_)) {
      throw error(fmt::format("a corner of '{}' at ({}, {}), outside the image of {}x{}", values[0],
                              values[1], values[2], size_.width, size_.height),
                  "a corner inside the image",
                  "check --image-size: width and height may be swapped, or those of another image");
    }
    return Corner{.id = num_rows_, .pixel = pixel, .sigma_px = sigma};
  }

  // NaN for a corner that was not found.
  [[nodiscard]] double relativeSigma(const std::string& field) const {
    constexpr double kNotFound = std::numeric_limits<double>::quiet_NaN();
    if (is_weighted_) {
      const double weight = number(field, "weight", kNumber);
      return weight > 0 ? 1 / weight : kNotFound;
    }
    constexpr double kMaxLevel = 30;  // far beyond the size of an image
    const double level = number(field, "level", kNumber);
    if (level < 0) return kNotFound;
    if (level > kMaxLevel || level != std::floor(level)) {
      throw error("'" + field + "' as level",
                  "a whole number from 0 to 30, or - for a corner that was not found",
                  "if these are weights, name the column so: # filename x y weight");
    }
    return std::exp2(level);
  }

  void openImage(const std::string& image) {
    if (!images_.insert(image).second) {
      throw error("image '" + image + "' again", "the rows of an image together, and each image once",
                  "check whether the same file was given twice, or two images have one name");
    }
    view_ = {.image = image, .size = size_};
    first_line_ = line_;
  }

  // An image without the board may have a single row.
  void closeImage() {
    const bool is_unseen = num_rows_ <= 1 && view_.corners.empty();
    if (!is_unseen && num_rows_ != board().numCorners()) {
      throw detail::errorAt(
          name_ + ":" + std::to_string(first_line_),
          "found " +
              fmt::format("image '{}' with {} row{}", view_.image, num_rows_, num_rows_ == 1 ? "" : "s"),
          fmt::format("{}, one per corner of {} ({} columns x {} rows)", board().numCorners(), board().spec(),
                      board().columns(), board().rows()),
          "check --board: mrcal's --object-width-n is the number of columns, --object-height-n that of rows");
    }
    if (!view_.corners.empty()) file_.views.push_back(std::move(view_));
    view_ = {};
    num_rows_ = 0;
  }

  // Converts relative sigmas to those that the calibration uses, see the header.
  void setSigmas() {
    double least = std::numeric_limits<double>::infinity();
    double most = 0;
    for (const View& view : file_.views) {
      for (const Corner& corner : view.corners) {
        least = std::min(least, corner.sigma_px);
        most = std::max(most, corner.sigma_px);
      }
    }
    for (View& view : file_.views) {
      for (Corner& corner : view.corners)
        corner.sigma_px = least == most ? Corner().sigma_px : corner.sigma_px / least;
    }
  }

  ImageSize size_;
  std::size_t num_values_ = 0;  // per row, from the legend
  bool is_weighted_ = false;    // true: a fourth column has weights, not levels
  View view_;                   // the image whose rows are being read, with relative sigmas
  int num_rows_ = 0;
  int first_line_ = 0;
  std::set<std::string> images_;
};

// True if the board's points are those of mrcal's board, which has one spacing.
bool isEvenlySpaced(const Board& board) {
  for (int id = 0; id < board.numCorners(); ++id) {
    const Eigen::Vector3d even =
        board.spacing() * Eigen::Vector3d(id % board.columns(), id / board.columns(), 0);
    if (!(board.corner(id) - even).isZero(1e-9 * board.spacing())) return false;
  }
  return true;
}

// Comments as lines that start with `mark`.
std::string commentLines(const CornersFile& file, const std::string& mark) {
  std::string text;
  for (const std::string& comment : file.comments) {
    for (const std::string_view line : split(comment, '\n')) text += mark + " " + std::string(line) + "\n";
  }
  return text;
}

// A name as a CSV field. Rows are read line by line, so that a stray quote affects only one row.
std::string nameField(const std::string& name, const char* what) {
  if (name.find_first_of("\r\n") != std::string::npos) {
    throw detail::errorAt(std::string(what) + " '" + name + "'", "a line break in the name",
                          "a name without line breaks", "rename it");
  }
  return detail::csvField(name);
}

}  // namespace

std::string cornersFileText(const CornersFile& file) {
  std::string text = commentLines(file, "#");
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
  CsvParser parser;
  parser.read(text, name);
  return parser.finish();
}

CornersFile readCornersFile(const std::string& path) {
  return readCornersFiles(std::span(&path, 1));
}

CornersFile readCornersFiles(std::span<const std::string> paths) {
  CsvParser parser;
  for (const std::string& path : paths) parser.read(readTextFile(path, kMaxCornersFileBytes), path);
  return parser.finish();
}

bool isVnlFile(const std::string& path) {
  return path.ends_with(".vnl") || path.ends_with(".VNL");
}

bool startsLikeCorners(std::string_view text) {
  constexpr std::size_t kLongestComments = 4096;
  const std::string_view start = text.substr(0, kLongestComments);
  return start.find(kHeader) != std::string_view::npos ||
         start.find("# " + std::string(kLegend)) != std::string_view::npos;
}

void checkVnl(std::span<const Board> boards, std::span<const std::string> images) {
  const std::string next_step = "write a .csv file, which can hold all boards and names";
  if (boards.size() != 1 || !isEvenlySpaced(boards.front())) {
    throw detail::errorAt("a .vnl file", "board " + join(mapped(boards, &Board::spec), " and "),
                          "one board with points in columns and rows that are evenly spaced", next_step);
  }
  const auto isWrong = [](char c) { return !isPrintableAscii(c) || c == ' ' || c == '#'; };
  for (const std::string& image : images) {
    if (!image.empty() && std::ranges::none_of(image, isWrong)) continue;
    throw detail::errorAt("image '" + image + "'", "a name that a .vnl file cannot hold",
                          "ASCII characters without blanks and #", "rename it, or " + next_step);
  }
}

std::string vnlFileText(const CornersFile& file) {
  checkVnl(file.boards, mapped(file.views, &View::image));
  std::string text = commentLines(file, "##");
  // mrcal reads ASCII only.
  std::ranges::replace_if(
      text, [](char c) { return !isPrintableAscii(c) && c != '\n'; }, '?');
  text += "# " + std::string(kLegend) + "\n";
  for (const View& view : file.views) {
    const auto num_corners = static_cast<std::size_t>(file.boards.front().numCorners());
    std::vector<std::string> places(num_corners, fmt::format("{} {}", kMissing, kMissing));
    for (const Corner& corner : view.corners) {
      if (corner.pixel.minCoeff() < 0) continue;
      places.at(static_cast<std::size_t>(corner.id)) =
          exactText(corner.pixel.x()) + " " + exactText(corner.pixel.y());
    }
    for (const std::string& place : places) text += view.image + " " + place + "\n";
  }
  return text;
}

void writeVnlFile(const std::string& path, const CornersFile& file) {
  writeFileAtomically(path, vnlFileText(file));
}

CornersFile parseVnlFile(const std::string& text, const std::string& name, const Board& board,
                         ImageSize size) {
  VnlParser parser(board, size);
  parser.read(text, name);
  return parser.finish();
}

CornersFile readVnlFiles(std::span<const std::string> paths, const Board& board, ImageSize size) {
  VnlParser parser(board, size);
  for (const std::string& path : paths) parser.read(readTextFile(path, kMaxCornersFileBytes), path);
  return parser.finish();
}

}  // namespace alidade
