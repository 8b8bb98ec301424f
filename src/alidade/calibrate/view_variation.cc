// SPDX-License-Identifier: MIT
#include "alidade/calibrate/view_variation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "alidade/calibrate/reprojection.h"
#include "alidade/camera/model_list.h"

namespace alidade {
namespace {

constexpr int kFocal = 0;
constexpr int kShear = 1;
constexpr int kStretch = 2;
constexpr int kNumWays = 3;

// The normal equations of one view by the ways in which it may differ, its pose eliminated.
struct ViewWays {
  Eigen::Matrix3d information;
  Eigen::Vector3d gradient;
  double squares = 0;  // of the errors
  int num_corners = 0;
};

template <CameraModel M>
ViewWays waysOf(const double* params, const SE3& camera_from_board, std::span<const Observation> view,
                HuberLoss loss) {
  constexpr int kAll = 6 + kNumWays + 1;
  Eigen::Matrix<double, kAll, kAll> gram = Eigen::Matrix<double, kAll, kAll>::Zero();
  const Eigen::Matrix3d R = camera_from_board.rotation.matrix();
  Reprojection<M> corner;
  Eigen::Matrix<double, 2, kAll, Eigen::RowMajor> row;
  ViewWays ways;
  for (const Observation& observation : view) {
    if (!reproject<M>(params, R, camera_from_board.translation, observation.p_board, corner)) continue;
    const Eigen::Vector2d error = corner.pixel - observation.pixel;
    const double below_centre = corner.pixel.y() - params[3];
    row.template leftCols<6>() = corner.J_px_pose;
    row.col(6 + kFocal) = params[0] * corner.J_px_params.col(0) + params[1] * corner.J_px_params.col(1);
    row.col(6 + kShear) << below_centre, 0;
    row.col(6 + kStretch) << 0, below_centre;
    row.col(6 + kNumWays) = error;
    const double weight = observation.weight * loss.weight(observation.weight * error.squaredNorm());
    gram.noalias() += weight * row.transpose() * row;
    ++ways.num_corners;
  }
  const Eigen::Matrix<double, 6, 6> pose = gram.template topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 6, kNumWays + 1> coupling = gram.template topRightCorner<6, kNumWays + 1>();
  const Eigen::Matrix<double, kNumWays + 1, kNumWays + 1> reduced =
      gram.template bottomRightCorner<kNumWays + 1, kNumWays + 1>() -
      coupling.transpose() * pose.ldlt().solve(coupling);
  ways.information = reduced.template topLeftCorner<kNumWays, kNumWays>();
  ways.gradient = reduced.template topRightCorner<kNumWays, 1>();
  ways.squares = reduced(kNumWays, kNumWays);
  return ways;
}

// By how much the sum of squares of one view falls if it may differ, and in how many ways it can.
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
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(view.information.bottomRightCorner<2, 2>());
  // Seen from the front a plane tells nothing of one of the two.
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

// Of values with the given informations at unit variance, as the class comment says.
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

// F statistic of `drops` against what they leave; nothing is free but poses and, in all, as many values as
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

ViewVariations viewVariations(std::string_view model_id, std::span<const std::vector<Observation>> views,
                              const BundleState& state, HuberLoss loss) {
  constexpr std::size_t kMinViewsToVary = 4;
  ViewVariations variations;
  if (views.size() < kMinViewsToVary) return variations;
  std::vector<ViewWays> ways;
  forEachModel(AllModels{}, [&](auto tag) {
    using M = typename decltype(tag)::Model;
    if (M::kId != model_id) return;
    for (std::size_t v = 0; v < views.size(); ++v)
      ways.push_back(waysOf<M>(state.params.data(), state.camera_from_board[v], views[v], loss));
  });
  double squares = 0;
  int freedom = -static_cast<int>(state.params.size());
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
