// SPDX-License-Identifier: MIT
#include "alidade/detect/board_hint.h"

#include <algorithm>
#include <utility>

namespace alidade {

std::optional<BoardHint> guessBoardSize(std::span<const std::string> images,
                                        const std::function<SourceImage(const std::string&)>& load,
                                        const Checkerboard& asked, const DetectImagesOptions& options) {
  constexpr std::size_t kMaxImages =
      2;  // a search that finds nothing is slow, and there are many sizes to try
  std::vector<std::string> some;
  const std::size_t count = std::min(kMaxImages, images.size());
  for (std::size_t i = 0; i < count; ++i) some.push_back(images[i * images.size() / count]);

  std::vector<std::pair<int, int>> sizes;
  const auto add = [&](int columns, int rows) {
    const std::pair<int, int> size(columns, rows);
    const bool is_new = std::find(sizes.begin(), sizes.end(), size) == sizes.end();
    if (columns >= 3 && rows >= 3 && size != std::pair(asked.columns, asked.rows) && is_new)
      sizes.push_back(size);
  };
  // Squares counted instead of corners comes first: it is by far the commonest slip.
  add(asked.columns - 1, asked.rows - 1);
  add(asked.columns + 1, asked.rows + 1);
  for (const int off : {-1, 1, -2, 2}) {
    add(asked.columns + off, asked.rows);
    add(asked.columns, asked.rows + off);
  }
  add(asked.columns + 1, asked.rows - 1);
  add(asked.columns - 1, asked.rows + 1);

  DetectImagesOptions quiet = options;
  quiet.progress = nullptr;
  constexpr int kSearchPx = 480;  // a hint needs no small boards, and each miss costs by the pixel
  quiet.detector = {.first_search_px = kSearchPx, .last_search_px = kSearchPx};
  for (const auto& [columns, rows] : sizes) {
    const Checkerboard board{.columns = columns, .rows = rows, .square_m = asked.square_m};
    const std::vector<ImageOutcome> outcomes = detectInImages(some, load, board, quiet);
    const auto num_found = std::count_if(outcomes.begin(), outcomes.end(),
                                         [](const ImageOutcome& o) { return o.detection.found(); });
    if (num_found > 0) {
      return BoardHint{.columns = columns,
                       .rows = rows,
                       .num_images = static_cast<int>(num_found),
                       .num_looked_at = static_cast<int>(some.size())};
    }
  }
  return std::nullopt;
}

}  // namespace alidade
