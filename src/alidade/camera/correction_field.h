// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/core/image.h"

namespace alidade {

/// Equal cells over a part of the image plane, and the control points of a uniform bicubic B-spline on them:
/// one per corner of a cell, and a further ring around these.
struct CorrectionGrid {
  static constexpr int kMaxCells = 200;  ///< along a side

  int columns = 0;  ///< of cells
  int rows = 0;
  Eigen::Vector2d origin_px{0, 0};  ///< the corner of the first cell with the smallest coordinates
  Eigen::Vector2d cell_px{0, 0};    ///< width and height of a cell
  bool is_bounded = false;  ///< beyond the grid, there are no pixels; else the values at its border hold

  /// False for the model's pixels that have none in the image.
  [[nodiscard]] bool has(const Eigen::Vector2d& pixel) const {
    constexpr double kRounding = 1e-9;
    const double x = (pixel.x() - origin_px.x()) / cell_px.x();
    const double y = (pixel.y() - origin_px.y()) / cell_px.y();
    return !is_bounded ||
           (x >= -kRounding && y >= -kRounding && x <= columns + kRounding && y <= rows + kRounding);
  }

  friend bool operator==(const CorrectionGrid&, const CorrectionGrid&) = default;
  /// The grid over a whole image.
  [[nodiscard]] static CorrectionGrid over(ImageSize size, int columns, int rows);

  [[nodiscard]] int pointsAcross() const { return columns + 3; }
  [[nodiscard]] int numPoints() const { return pointsAcross() * (rows + 3); }

  /// What a pixel depends on: 4 x 4 control points from `first` on, each with the product of its weights in x
  /// and y. Outside the grid, the values are those at its border.
  struct Patch {
    std::size_t first = 0;
    std::array<double, 4> x{}, y{};    ///< weights
    std::array<double, 4> dx{}, dy{};  ///< their derivatives, per px
  };
  [[nodiscard]] Patch patchAt(const Eigen::Vector2d& pixel) const {
    Patch patch;
    const int column =
        weigh((pixel.x() - origin_px.x()) / cell_px.x(), columns, cell_px.x(), patch.x, patch.dx);
    const int row = weigh((pixel.y() - origin_px.y()) / cell_px.y(), rows, cell_px.y(), patch.y, patch.dy);
    patch.first = static_cast<std::size_t>(row) * static_cast<std::size_t>(pointsAcross()) +
                  static_cast<std::size_t>(column);
    return patch;
  }
  /// Calls f(point, weight) for the control points that move a pixel.
  template <class F>
  void forEachWeight(const Eigen::Vector2d& pixel, const F& f) const {
    const Patch patch = patchAt(pixel);
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i)
        f(static_cast<int>(patch.first + i) + static_cast<int>(j) * pointsAcross(), patch.x[i] * patch.y[j]);
    }
  }

 private:
  // The cell and the weights at a position in cells.
  static int weigh(double at, int count, double cell_px, std::array<double, 4>& value,
                   std::array<double, 4>& slope) {
    const double inside = at > 0 ? std::min(at, static_cast<double>(count)) : 0.0;  // 0 for NaN
    const int cell = std::min(static_cast<int>(inside), count - 1);
    const double t = inside - cell;
    const double s = 1 - t;
    value = {s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (4 + s * s * (3 * s - 6)) / 6, t * t * t / 6};
    const double per_px = inside == at ? 1 / cell_px : 0.0;
    slope = {-0.5 * s * s * per_px, (1.5 * t - 2) * t * per_px, -(1.5 * s - 2) * s * per_px,
             0.5 * t * t * per_px};
    return cell;
  }
};

/// A smooth displacement over the image, by which a real lens deviates from its model: a point that the model
/// sees at the pixel q is seen at q + D(q). D is a uniform bicubic B-spline surface (de Boor 1978, A
/// practical guide to splines). Immutable, and one-to-one: every pixel is displaced from exactly one, or, if
/// the grid is bounded, from at most one.
class CorrectionField {
 public:
  /// @param points  of the grid, row by row: u and v of each control point, px
  /// @throws Error (kInput) for a grid or a number that makes no sense, and for a field that may fold: if the
  /// symmetric part of I + grad D is not certain to be positive
  CorrectionField(const CorrectionGrid& grid, std::vector<double> points);

  /// Those cells about a pixel, in a rectangle, in which a field does not fold; splines of other programs may
  /// fold where no board was seen. The grid is bounded. @throws Error (kInput) as the constructor
  [[nodiscard]] static CorrectionField soundPart(const CorrectionGrid& grid,
                                                 const std::vector<double>& points,
                                                 const Eigen::Vector2d& about);

  [[nodiscard]] const CorrectionGrid& grid() const { return grid_; }
  [[nodiscard]] const std::vector<double>& points() const { return points_; }
  friend bool operator==(const CorrectionField& a, const CorrectionField& b) {
    return a.grid_ == b.grid_ && a.points_ == b.points_;
  }

  /// D at the model's pixel, px. The derivative by that pixel may be null.
  [[nodiscard]] Eigen::Vector2d at(const Eigen::Vector2d& pixel, Eigen::Matrix2d* gradient = nullptr) const;
  /// The model's pixel of the displaced one; nothing if there is none.
  [[nodiscard]] std::optional<Eigen::Vector2d> undisplaced(const Eigen::Vector2d& pixel) const;
  /// The largest displacement of a control point, px, which no displacement exceeds.
  [[nodiscard]] double largest() const;

  /// The field of an image whose pixels are A q + b.
  /// @pre A is diagonal or antidiagonal, and not singular
  [[nodiscard]] CorrectionField mapped(const Eigen::Matrix2d& A, const Eigen::Vector2d& b) const;

 private:
  CorrectionGrid grid_;
  std::vector<double> points_;
};

}  // namespace alidade
