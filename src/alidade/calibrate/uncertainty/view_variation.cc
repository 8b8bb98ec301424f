// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_variation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "alidade/adjust/board/reduced.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr int kFocal = 0;
constexpr int kShear = 1;
constexpr int kStretch = 2;
constexpr int kNumWays = 3;

// The ways in which a view may differ, as additional columns.
struct WayColumns {
  std::array<double, 2> focal;
  double centre_y;

  static int size() { return kNumWays; }
  [[nodiscard]] ExtraElements<2> elements(const CornerRows& rows, int axis) const {
    const double* J = rows.J_px_params[static_cast<std::size_t>(axis)];
    // For the projected pixel, the sum of the observed one and the error.
    const double below_centre = rows.root_weight * (rows.corner.pixel.y() - centre_y) + rows.error[1];
    return {.column = {kFocal, axis == 0 ? kShear : kStretch},
            .value = {focal[0] * J[0] + focal[1] * J[1], below_centre}};
  }
};

// The normal equations of one view for its possible differences, with its pose eliminated.
struct ViewWays {
  Eigen::Matrix3d information;
  Eigen::Vector3d gradient;
  double squares = 0;  // of the errors
  int num_corners = 0;
};

// Decrease of the sum of squares of one view if it may differ, and the number of ways in which it can.
struct Drop {
  double squares = 0;
  int freedom = 0;
};

Drop dropByFocal(const ViewWays& view) {
  const double information = view.information(kFocal, kFocal);
  if (!(information > 0)) return {};
  return {.squares = view.gradient(kFocal) * view.gradient(kFocal) / information, .freedom = 1};
}

Drop dropByRows(const ViewWays& view) {
  const SymmetricEigen solver(view.information.bottomRightCorner<2, 2>());
  // In a frontal view a plane does not determine one of the two.
  constexpr double kUnseen = 1e-6;
  Drop drop;
  for (int i = 0; i < 2; ++i) {
    const double information = solver.eigenvalues()(i);
    if (!(information > kUnseen * solver.eigenvalues()(1))) continue;
    const double gradient = solver.eigenvectors().col(i).dot(view.gradient.tail<2>());
    drop.squares += gradient * gradient / information;
    ++drop.freedom;
  }
  return drop;
}

// Spread of values with given informations at unit variance, see ViewVariation::spread.
class Spread {
 public:
  explicit Spread(double variance) : variance_(variance) {}

  void add(double information, double gradient) {
    if (!(information > 0)) return;
    const double weight = information / variance_;
    const double value = -gradient / information;
    weights_ += weight;
    squared_weights_ += weight * weight;
    values_ += weight * value;
    squared_values_ += weight * value * value;
    ++count_;
  }

  [[nodiscard]] double variance() const {
    const double excess = squared_values_ - values_ * values_ / weights_ - (count_ - 1);
    return std::max(0.0, excess / (weights_ - squared_weights_ / weights_));
  }

 private:
  double variance_;
  double weights_ = 0;
  double squared_weights_ = 0;
  double values_ = 0;
  double squared_values_ = 0;
  int count_ = 0;
};

// F statistic of `drops` against the remaining squares; free are only poses and, in total, as many values as
// the camera has parameters.
double statistic(std::span<const Drop> drops, double squares, int freedom, double& variance) {
  Drop all;
  for (const Drop& drop : drops) {
    all.squares += drop.squares;
    all.freedom += drop.freedom;
  }
  variance = (squares - all.squares) / (freedom - all.freedom);
  return all.squares / all.freedom / variance;
}

}  // namespace

ViewVariations viewVariations(const Fit& fit) {
  constexpr std::size_t kMinViewsToVary = 4;
  ViewVariations variations;
  if (fit.views.size() < kMinViewsToVary) return variations;
  std::vector<ViewWays> ways;
  const std::vector<double>& params = onlyCamera(fit).params;
  const WayColumns columns{.focal = {params[0], params[1]}, .centre_y = params[3]};
  for (const Reduced& view : reduced(fit, LossWeights::kUse, columns)) {
    ways.push_back({.information = view.information.bottomRightCorner<kNumWays, kNumWays>(),
                    .gradient = view.gradient.tail<kNumWays>(),
                    .squares = view.squares,
                    .num_corners = view.num_corners});
  }
  double squares = 0;
  int freedom = -static_cast<int>(params.size());
  std::vector<Drop> by_focal;
  std::vector<Drop> by_rows;
  double focal_squares = 0;
  double row_squares = 0;
  for (const ViewWays& view : ways) {
    squares += view.squares;
    freedom += 2 * view.num_corners - 6;
    by_focal.push_back(dropByFocal(view));
    by_rows.push_back(dropByRows(view));
    focal_squares += by_focal.back().squares;
    row_squares += by_rows.back().squares;
  }
  if (freedom <= 2 * static_cast<int>(ways.size())) return variations;
  variations.focal_share = row_squares > 0 ? std::min(1.0, focal_squares / row_squares) : 0.0;
  double variance = 0;
  variations.focal.f = statistic(by_focal, squares, freedom, variance);
  Spread focal(variance);
  for (const ViewWays& view : ways) focal.add(view.information(kFocal, kFocal), view.gradient(kFocal));
  variations.focal.spread = std::sqrt(focal.variance());
  variations.rows.f = statistic(by_rows, squares, freedom, variance);
  Spread shear(variance);
  Spread stretch(variance);
  for (const ViewWays& view : ways) {
    shear.add(view.information(kShear, kShear), view.gradient(kShear));
    stretch.add(view.information(kStretch, kStretch), view.gradient(kStretch));
  }
  variations.rows.spread = std::sqrt(std::max(shear.variance(), stretch.variance()));
  return variations;
}

}  // namespace alidade
