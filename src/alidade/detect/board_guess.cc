// SPDX-License-Identifier: MIT
#include "alidade/detect/board_guess.h"

#include <algorithm>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/median.h"
#include "alidade/detect/board/find_board.h"
#include "alidade/detect/board/marker_guess.h"

namespace alidade {
namespace {

// Guesses a checkerboard from images that show all of it.
class CheckerboardGuess {
 public:
  void look(const GrayImage& image) {
    // Any counts will do, because `seen` states the actual ones.
    const auto seen = findBoard(image, Checkerboard{.columns = 3, .rows = 3, .square_m = 1}).seen;
    if (seen) ++(seen->is_closed ? closed_ : open_)[{seen->columns, seen->rows}];
  }
  [[nodiscard]] bool isSure() const {
    constexpr int kEnough = 3;
    return std::ranges::any_of(closed_, [](const auto& entry) { return entry.second >= kEnough; });
  }
  [[nodiscard]] std::string text() const {
    // For boards without a white margin, the counts that this many images show.
    constexpr int kEnoughOpen = 5;
    const Counts& counts = closed_.empty() ? open_ : closed_;
    const auto most = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
    if (most == counts.end() || (closed_.empty() && most->second < kEnoughOpen)) return {};
    const auto [columns, rows] = most->first;
    return fmt::format(
        "the images show a checkerboard of {0}x{1} inner corners: --board checkerboard:{0}x{1}:SQUARE, with "
        "the side of a square such as 25mm",
        columns, rows);
  }

  // For a few images of such a board.
  [[nodiscard]] std::string doubtfulText() const {
    const auto most = std::ranges::max_element(
        open_, {}, [](const auto& entry) { return entry.first.first * entry.first.second; });
    if (most == open_.end()) return {};
    const auto [columns, rows] = most->first;
    return fmt::format(
        "squares with {0}x{1} inner corners are seen, perhaps not all; for a whole board of these: --board "
        "checkerboard:{0}x{1}:SQUARE, with the side of a square such as 25mm",
        columns, rows);
  }

 private:
  using Counts = std::map<std::pair<int, int>, int>;
  Counts closed_;  // the whole border is visible
  Counts open_;
};

// Guesses a grid of circles from images that show all of it.
class CircleGuess {
 public:
  void look(const GrayImage& image) {
    const auto seen = seenCircleGrid(image);
    if (!seen) return;
    auto known = std::ranges::find(counts_, seen->counts, &Count::grid);
    if (known == counts_.end()) known = counts_.insert(known, {.grid = seen->counts});
    ++known->num_images;
    if (seen->diameter) known->diameters.push_back(*seen->diameter);
  }
  [[nodiscard]] bool isSure() const {
    constexpr int kEnough = 3;
    return std::ranges::any_of(counts_, [](const Count& count) { return count.num_images >= kEnough; });
  }
  [[nodiscard]] std::string text() const {
    if (counts_.empty()) return {};
    const Count& most = *std::ranges::max_element(counts_, {}, &Count::num_images);
    const CircleCounts& grid = most.grid;
    const std::string counts = fmt::format("{}x{}", grid.columns, grid.rows);
    return fmt::format(
        "the images show {0} of {1} circles: --board {2}:{1}:SPACING:DIAMETER, with lengths such as 25mm{3}",
        grid.is_asymmetric ? "an asymmetric grid" : "a grid", counts,
        grid.is_asymmetric ? AsymmetricCircleGrid::kName : CircleGrid::kName,
        most.diameters.empty()
            ? ""
            : fmt::format("; the diameter is about {:.2g} of the spacing", medianOf(most.diameters)));
  }

 private:
  struct Count {
    CircleCounts grid;
    int num_images = 0;
    std::vector<double> diameters = {};  // as shares of the spacing
  };
  std::vector<Count> counts_;
};

// All images, in an order that starts with distant ones, because neighbours are similar.
std::vector<std::size_t> spreadOrder(std::size_t count) {
  std::vector<std::size_t> order;
  std::vector<bool> is_taken(count, false);
  for (std::size_t parts = 1; order.size() < count; parts *= 2) {
    for (std::size_t part = 0; part < parts; ++part) {
      const std::size_t i = part * count / parts;
      if (!is_taken[i]) order.push_back(i);
      is_taken[i] = true;
    }
  }
  return order;
}

}  // namespace

std::string guessedBoard(const ImageSet& images, const CancelFlag* cancel) {
  // Limits the time for any images.
  constexpr double kMostPixels = 6e7;
  constexpr int kMostImages = 30;
  // Each kind of board has its guess here. Markers come first, because squares without markers are not
  // distinctive.
  MarkerGuess markers;
  CheckerboardGuess squares;
  CircleGuess circles;
  double num_pixels = 0;
  int num_images = 0;
  for (const std::size_t i : spreadOrder(images.size())) {
    const bool is_sure = markers.isSure() || squares.isSure() || circles.isSure();
    if (is_sure || num_pixels > kMostPixels || num_images >= kMostImages) break;
    throwIfCancelled(cancel);
    ++num_images;
    GrayImage image;
    try {
      image = images.read(i).decode().image;
    } catch (const Error&) {
      continue;  // the run itself reports the error
    }
    num_pixels += static_cast<double>(image.size.width) * image.size.height;
    markers.look(image);
    squares.look(image);
    circles.look(image);
  }
  for (std::string text : {markers.text(), squares.text(), circles.text()}) {
    if (!text.empty()) return text;
  }
  return squares.doubtfulText();
}

}  // namespace alidade
