// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "alidade/core/image.h"
#include "alidade/detect/board/circle_placement.h"
#include "alidade/detect/board/detection.h"
#include "alidade/detect/corner/disc_fit.h"
#include "alidade/target/board.h"

namespace alidade {

/// The proportions of a grid from the shapes of its discs, which no perspective changes.
struct SeenProportions {
  double diameter_m = 0;  ///< if the spacing of the board is as stated
  double rows_apart = 1;  ///< distance of rows divided by that on the board, relative to the distance of
                          ///< columns
  double diameter_px = 0;
};

/// The circles of a placed grid: fitted to blobs, or searched between the found ones if there is no blob.
class CircleSearch {
 public:
  /// `image` and `board` must outlive it.
  CircleSearch(const GrayImage& image, const Board& board, const GridPlacement& placement);

  [[nodiscard]] const std::vector<std::optional<DiscFit>>& found() const { return found_; }
  /// Nothing if too few circles have neighbours.
  [[nodiscard]] std::optional<SeenProportions> proportions() const;
  [[nodiscard]] ViewMeasures measures() const;

 private:
  [[nodiscard]] const std::optional<DiscFit>& at(int id) const;
  [[nodiscard]] std::array<std::pair<int, int>, 2> oppositePairs(int id) const;
  [[nodiscard]] std::optional<DiscFit> between(int id) const;
  [[nodiscard]] double stepAt(int id) const;
  void fitAt(int id, const Eigen::Vector2d& pixel, const Eigen::Matrix2d& shape);
  void dropOdd();

  const GrayImage& image_;
  const Board& board_;
  double reach_ = 0;
  std::vector<std::optional<DiscFit>> found_;
};

}  // namespace alidade
