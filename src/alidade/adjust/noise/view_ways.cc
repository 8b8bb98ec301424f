// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/view_ways.h"

#include <algorithm>
#include <cmath>

#include "alidade/adjust/board/reduced.h"
#include "alidade/geometry/symmetric_eigen.h"
#include "alidade/target/board_shape.h"

namespace alidade {
namespace {

// The ways as columns after the intrinsics.
struct WayColumns {
  std::array<double, 2> focal;
  double centre_y;
  const Board& board;

  static int size() { return kNumWays; }
  [[nodiscard]] ExtraElements<4> elements(const CornerRows& rows, int axis) const {
    const auto at = static_cast<std::size_t>(axis);
    const double* J = rows.J_px_params[at];
    // For the projected pixel, the sum of the observed one and the error.
    const double below_centre = rows.root_weight * (rows.corner.pixel.y() - centre_y) + rows.error[1];
    const Eigen::Vector3d& p = board.corner(rows.corner.id);
    const Eigen::Vector2d height = rows.J_px_pose[at][2] * bendProfile(board, p.x(), p.y());
    const ViewWay of_rows = axis == 0 ? ViewWay::kShear : ViewWay::kStretch;
    return {.column = {static_cast<int>(ViewWay::kFocal), static_cast<int>(of_rows),
                       static_cast<int>(ViewWay::kBendX), static_cast<int>(ViewWay::kBendY)},
            .value = {focal[0] * J[0] + focal[1] * J[1], below_centre, height.x(), height.y()}};
  }
};

}  // namespace

ViewWays::ViewWays(const Fit& fit) {
  const std::vector<double>& params = onlyCamera(fit).params;
  freedom_ = -static_cast<int>(params.size()) - static_cast<int>(std::lround(numFreeOffsets(fit)));
  for (const FitView& view : fit.views) {
    const WayColumns columns{
        .focal = {params[0], params[1]}, .centre_y = params[3], .board = boardOf(fit, view).target};
    const Reduced of_view = reduced(fit, view, LossWeights::kUse, columns);
    views_.push_back({.information = of_view.information.bottomRightCorner<kNumWays, kNumWays>(),
                      .gradient = of_view.gradient.tail<kNumWays>()});
    squares_ += of_view.squares;
    freedom_ += 2 * of_view.num_corners - 6;
  }
}

bool ViewWays::isRedundant(int num_ways) const {
  return freedom_ > num_ways * static_cast<int>(views_.size());
}

WayDrop ViewWays::dropBy(const OfView& view, std::span<const ViewWay> ways) {
  // A view may not determine a combination: a frontal one not the shear against the stretch.
  constexpr double kUnseen = 1e-6;
  const auto n = static_cast<Eigen::Index>(ways.size());
  const auto indexOf = [&](Eigen::Index i) { return static_cast<int>(ways[static_cast<std::size_t>(i)]); };
  const Eigen::VectorXd root = view.information.diagonal().cwiseSqrt();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(root(indexOf(i)) > 0)) continue;
    gradient(i) = view.gradient(indexOf(i)) / root(indexOf(i));
    for (Eigen::Index k = 0; k < n; ++k) {
      if (root(indexOf(k)) > 0)
        information(i, k) = view.information(indexOf(i), indexOf(k)) / (root(indexOf(i)) * root(indexOf(k)));
    }
  }
  const SymmetricEigen solver(information);
  WayDrop drop;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(solver.eigenvalues()(i) > kUnseen)) continue;
    const double along = solver.eigenvectors().col(i).dot(gradient);
    drop.squares += along * along / solver.eigenvalues()(i);
    ++drop.freedom;
  }
  return drop;
}

WayDrop ViewWays::dropBy(std::span<const ViewWay> ways) const {
  WayDrop all;
  for (const OfView& view : views_) {
    const WayDrop drop = dropBy(view, ways);
    all.squares += drop.squares;
    all.freedom += drop.freedom;
  }
  return all;
}

double ViewWays::varianceLeft(const WayDrop& drop) const {
  return (squares_ - drop.squares) / (freedom_ - drop.freedom);
}

double ViewWays::f(const WayDrop& drop, const WayDrop& beyond) const {
  return (drop.squares - beyond.squares) / (drop.freedom - beyond.freedom) / varianceLeft(drop);
}

double ViewWays::varianceOf(ViewWay way, double noise_variance) const {
  const auto at = static_cast<int>(way);
  double weights = 0;
  double squared_weights = 0;
  double values = 0;
  double squared_values = 0;
  int count = 0;
  for (const OfView& view : views_) {
    const double information = view.information(at, at);
    if (!(information > 0)) continue;
    const double weight = information / noise_variance;
    const double value = -view.gradient(at) / information;
    weights += weight;
    squared_weights += weight * weight;
    values += weight * value;
    squared_values += weight * value * value;
    ++count;
  }
  const double excess = squared_values - values * values / weights - (count - 1);
  return std::max(0.0, excess / (weights - squared_weights / weights));
}

}  // namespace alidade
