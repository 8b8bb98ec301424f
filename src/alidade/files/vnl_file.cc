// SPDX-License-Identifier: MIT
#include "alidade/files/vnl_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

namespace alidade {
namespace {

constexpr std::string_view kLegend = "filename x y";
constexpr std::string_view kExpectedLegend =
    "the legend '# filename x y', '# filename x y level' or '# filename x y weight'";
constexpr std::string_view kMissing = "-";
constexpr std::size_t kMaxVnlFileBytes = std::size_t{1} << 30U;

bool isPrintableAscii(char c) {
  return c >= ' ' && c <= '~';
}

class VnlParser {
 public:
  VnlParser(const Board& board, ImageSize size) : size_(size) { file_.boards.push_back(board); }

  void read(std::string_view text, const std::string& name) {
    name_ = name;
    line_ = 0;
    num_values_ = 0;
    const std::size_t num_views = file_.views.size();
    for (const std::string_view line : split(text, '\n')) this->line(line);
    closeImage();
    if (num_values_ == 0)
      throw inputError({.where = name_, .found = "no legend", .expected = std::string(kExpectedLegend)});
    if (file_.views.size() == num_views)
      throw inputError({.where = name_,
                        .found = "no corners",
                        .expected = "images that show the board",
                        .next_step = "no board was found when this file was written"});
  }

  CornersFile finish() {
    setSigmas();
    std::ranges::sort(file_.views,
                      [](const View& a, const View& b) { return naturalLess(a.image, b.image); });
    return std::move(file_);
  }

 private:
  enum class Extra { kNone, kLevel, kWeight };  // meaning of the last column

  [[nodiscard]] const Board& board() const { return file_.boards.front(); }

  [[nodiscard]] Error errorAt(int line, const std::string& found, const std::string& expected,
                              const std::string& next_step = "") const {
    return inputError({.where = name_ + ":" + std::to_string(line),
                       .found = "found " + found,
                       .expected = expected,
                       .next_step = next_step});
  }

  [[nodiscard]] Error error(const std::string& found, const std::string& expected,
                            const std::string& next_step = "") const {
    return errorAt(line_, found, expected, next_step);
  }

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
    if (columns == start) {
      extra_ = Extra::kNone;
    } else if (columns == start + " level") {
      extra_ = Extra::kLevel;
    } else if (columns == start + " weight") {
      extra_ = Extra::kWeight;
    } else {
      throw error("the legend '# " + columns.substr(0, 60) + "'", std::string(kExpectedLegend));
    }
    num_values_ = names.size();
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
    const Eigen::Vector2d pixel(number(values[1], "x"), number(values[2], "y"));
    const double sigma = extra_ == Extra::kNone ? 1.0 : relativeSigma(values[3]);
    if (pixel.minCoeff() < 0 || std::isnan(sigma)) return std::nullopt;
    if (!isInOrNearImage(pixel, size_)) {
      throw error(fmt::format("a corner of '{}' at ({}, {}), outside the image of {}x{}", values[0],
                              values[1], values[2], size_.width, size_.height),
                  "a corner inside the image",
                  "check --image-size: width and height may be swapped, or those of another image");
    }
    return Corner{.id = num_rows_, .pixel = pixel, .sigma_px = sigma};
  }

  [[nodiscard]] double number(const std::string& field, const char* column) const {
    const auto value = parseDouble(field);
    if (value && std::isfinite(*value)) return *value;
    throw error("'" + field + "' as " + column, "a finite number, or - for a corner that was not found");
  }

  // NaN for a corner that was not found.
  [[nodiscard]] double relativeSigma(const std::string& field) const {
    constexpr double kNotFound = std::numeric_limits<double>::quiet_NaN();
    if (extra_ == Extra::kWeight) {
      const double weight = number(field, "weight");
      return weight > 0 ? 1 / weight : kNotFound;
    }
    constexpr double kMaxLevel = 30;  // far beyond the size of an image
    const double level = number(field, "level");
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
      throw errorAt(
          first_line_,
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
  std::string name_;
  int line_ = 0;
  std::size_t num_values_ = 0;  // per row, from the legend
  Extra extra_ = Extra::kNone;
  View view_;  // the image whose rows are being read, with relative sigmas
  int num_rows_ = 0;
  int first_line_ = 0;
  std::set<std::string> images_;
  CornersFile file_;
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

}  // namespace

bool isVnlFile(const std::string& path) {
  return path.ends_with(".vnl") || path.ends_with(".VNL");
}

void checkVnl(std::span<const Board> boards, std::span<const std::string> images) {
  const std::string next_step = "write a .csv file, which can hold all boards and names";
  if (boards.size() != 1 || !isEvenlySpaced(boards.front())) {
    throw inputError({.where = "a .vnl file",
                      .found = "board " + join(mapped(boards, &Board::spec), " and "),
                      .expected = "one board with points in columns and rows that are evenly spaced",
                      .next_step = next_step});
  }
  const auto isWrong = [](char c) { return !isPrintableAscii(c) || c == ' ' || c == '#'; };
  for (const std::string& image : images) {
    if (!image.empty() && std::ranges::none_of(image, isWrong)) continue;
    throw inputError({.where = "image '" + image + "'",
                      .found = "a name that a .vnl file cannot hold",
                      .expected = "ASCII characters without blanks and #",
                      .next_step = "rename it, or " + next_step});
  }
}

std::string vnlFileText(const CornersFile& file) {
  checkVnl(file.boards, mapped(file.views, &View::image));
  std::string text;
  for (const std::string& comment : file.comments) {
    for (const std::string_view line : split(comment, '\n')) text += "## " + std::string(line) + "\n";
  }
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
  for (const std::string& path : paths) parser.read(readTextFile(path, kMaxVnlFileBytes), path);
  return parser.finish();
}

}  // namespace alidade
