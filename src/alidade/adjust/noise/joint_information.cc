// SPDX-License-Identifier: MIT
#include "alidade/adjust/noise/joint_information.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "alidade/core/error.h"
#include "alidade/geometry/decompositions.h"

namespace alidade {
namespace {

constexpr int kPoseSize = 6;
using PoseRows = Eigen::Matrix<double, kPoseSize, Eigen::Dynamic>;

// The columns that are eliminated from the equations of a placement: its pose, the bends that a flexible
// board has there, and the deviations of its views.
int numOwn(const FitBoard& board, int num_deviations) {
  return kPoseSize + (board.isFlexible() ? kNumBends : 0) + PoseDeviation::kSize * num_deviations;
}

// Sums of products over the views of a placement. Their columns are those of the placement, the unknowns of
// the fit without offsets, and the error.
struct PlacementSums {
  Eigen::MatrixXd lower;   // triangle
  Eigen::MatrixXd points;  // three rows per point of an uneven board, its offset, with these columns
  Eigen::MatrixXd shifts;  // of each point's offset with itself, 3 x 3
};

// Some columns, and the tangent of camera_from_board by each.
struct PoseColumns {
  Eigen::Index first;
  Matrix6d tangent;  // of these columns, then zeros
  Eigen::Index count = kPoseSize;
};

PoseColumns oneColumn(Eigen::Index at, const Vector6d& tangent) {
  PoseColumns one{at, Matrix6d::Zero(), 1};
  one.tangent.col(0) = tangent;
  return one;
}

// The columns of the sums that move the pose of a view: those of its placement, its deviation, its camera's
// pose and its camera's delay. C Exp(eta) P Exp(zeta) Exp(d) = C P Exp(d) Exp(Ad(Exp(-d)) (Ad(P^-1) eta +
// zeta)).
// @param num_own    number of columns before those of the fit
// @param deviation  the first column of the deviation
std::vector<PoseColumns> poseColumns(const Fit& fit, const FitView& view, const JointColumns& columns,
                                     Eigen::Index num_own, Eigen::Index deviation) {
  Matrix6d moved = Matrix6d::Identity();
  std::vector<PoseColumns> all = {{0, moved}};
  if (view.deviation) {
    const Vector6d tangent = deviationTangent(fit, view);
    const Matrix6d jacobian = SE3::rightJacobian(tangent);
    moved = SE3::exp(-tangent).adjoint();
    all = {{0, moved},
           {deviation, jacobian * view.deviation->root.leftCols<kPoseSize>()},
           oneColumn(deviation + kPoseSize, jacobian * view.deviation->root.col(kPoseSize))};
    if (columns.delay[view.camera] >= 0) {
      const double delay = fit.cameras[view.camera].delay;
      all.push_back(
          oneColumn(num_own + columns.delay[view.camera], jacobian * view.deviation->tangentByDelay(delay)));
    }
  }
  if (columns.pose[view.camera] >= 0) {
    all.push_back({num_own + columns.pose[view.camera],
                   moved * fit.placements[view.placement].rig_from_board.inverse().adjoint()});
  }
  return all;
}

// @param deviation  the first column of the view's deviation, if it has one
void add(const Fit& fit, const FitView& view, const JointColumns& columns, LossWeights weights,
         Eigen::Index num_own, Eigen::Index deviation, PlacementSums& sums) {
  const FitCamera& camera = fit.cameras[view.camera];
  const std::size_t b = boardIndex(fit, view);
  const Board& board = fit.boards[b].target;
  const bool has_flex = fit.boards[b].isFlexible();
  const bool has_bend = columns.bend[b] >= 0;
  const auto shifts =
      columns.offsets[b] >= 0 ? detail::PointShifts::kInclude : detail::PointShifts::kLeaveOut;
  const detail::ViewGram gram =
      detail::gramOf(camera.model, camera.params, cameraFromBoard(fit, view), cornersOnShape(fit, view),
                     fit.loss, weights, has_bend || has_flex ? bendColumns(&board) : ExtraColumns(), shifts);
  // For each column of the view after the pose, the column of the sums; -1 if it is not estimated.
  std::vector<Eigen::Index> to;
  const auto place = [&](int first, Eigen::Index count) {
    for (Eigen::Index i = 0; i < count; ++i) to.push_back(first < 0 ? -1 : num_own + first + i);
  };
  const auto num_params = static_cast<Eigen::Index>(camera.params.size());
  place(columns.params[view.camera], num_params);
  if (has_flex) to.insert(to.end(), {kPoseSize, kPoseSize + 1});
  if (!has_flex && has_bend) place(columns.bend[b], kNumBends);
  place(columns.num_others, 1);
  const auto at = [&](Eigen::Index i, Eigen::Index j) -> double& {
    return sums.lower(std::max(i, j), std::min(i, j));
  };
  const Eigen::Index size = gram.lower.rows() - kPoseSize;
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::Index column = to[static_cast<std::size_t>(j)];
    if (column < 0) continue;
    for (Eigen::Index i = j; i < size; ++i) {
      const Eigen::Index row = to[static_cast<std::size_t>(i)];
      if (row >= 0) at(row, column) += gram.lower(kPoseSize + i, kPoseSize + j);
    }
    for (std::size_t k = 0; k < gram.ids.size(); ++k) {
      sums.points.col(column).segment<3>(3 * gram.ids[k]) +=
          gram.points.col(kPoseSize + j).segment<3>(3 * static_cast<Eigen::Index>(k));
    }
  }
  for (std::size_t k = 0; k < gram.ids.size(); ++k)
    sums.shifts.middleRows<3>(3 * gram.ids[k]) +=
        gram.points.block<3, 3>(3 * static_cast<Eigen::Index>(k), 0);
  const Matrix6d pose = gram.lower.topLeftCorner<kPoseSize, kPoseSize>().selfadjointView<Eigen::Lower>();
  const PoseRows rest = gram.lower.bottomLeftCorner(size, kPoseSize).transpose();
  const std::vector<PoseColumns> moves = poseColumns(fit, view, columns, num_own, deviation);
  for (auto one = moves.begin(); one != moves.end(); ++one) {
    for (auto other = moves.begin(); other <= one; ++other) {
      const Matrix6d product = one == other
                                   ? Matrix6d((one->tangent.transpose() * pose * one->tangent).transpose())
                                   : Matrix6d(other->tangent.transpose() * (pose * one->tangent));
      for (Eigen::Index i = 0; i < one->count; ++i) {
        for (Eigen::Index j = 0; j < (one == other ? i + 1 : other->count); ++j)
          at(one->first + i, other->first + j) += product(j, i);
      }
    }
    const PoseRows with_rest = one->tangent.transpose() * rest;
    for (Eigen::Index i = 0; i < one->count; ++i) {
      for (Eigen::Index j = 0; j < size; ++j) {
        const Eigen::Index column = to[static_cast<std::size_t>(j)];
        if (column >= 0) at(one->first + i, column) += with_rest(i, j);
      }
    }
    for (std::size_t k = 0; k < gram.ids.size(); ++k) {
      sums.points.block(3 * gram.ids[k], one->first, 3, one->count) +=
          gram.points.block<3, kPoseSize>(3 * static_cast<Eigen::Index>(k), 0) *
          one->tangent.leftCols(one->count);
    }
  }
}

// The equations of a placement and those of its own columns, which are eliminated from them.
struct PlacementEquations {
  PlacementSums sums;
  Eigen::MatrixXd own;
  Eigen::VectorXd own_error;
  Eigen::MatrixXd mixed;      // own columns with the unknowns of the fit
  Eigen::Index first_offset;  // of its board; -1 for an even one
};

PlacementEquations equationsOf(const Fit& fit, std::span<const FitView* const> views,
                               const JointColumns& columns, LossWeights weights) {
  const std::size_t b = boardIndex(fit, *views.front());
  const FitBoard& board = fit.boards[b];
  const auto num_deviations = static_cast<int>(
      std::ranges::count_if(views, [](const FitView* view) { return view->deviation.has_value(); }));
  const Eigen::Index num_own = numOwn(board, num_deviations);
  Eigen::Index deviation = numOwn(board, 0);
  const Eigen::Index error = num_own + columns.num_others;
  const Eigen::Index num_offsets = columns.offsets[b] < 0 ? 0 : 3 * board.target.numCorners();
  PlacementEquations equations{.sums = {.lower = Eigen::MatrixXd::Zero(error + 1, error + 1),
                                        .points = Eigen::MatrixXd::Zero(num_offsets, error + 1),
                                        .shifts = Eigen::MatrixXd::Zero(num_offsets, 3)},
                               .own = {},
                               .own_error = {},
                               .mixed = Eigen::MatrixXd::Zero(num_own, columns.count),
                               .first_offset = columns.offsets[b]};
  PlacementSums& sums = equations.sums;
  for (const FitView* view : views) {
    add(fit, *view, columns, weights, num_own, deviation, sums);
    if (!view->deviation) continue;
    sums.lower.diagonal().segment<PoseDeviation::kSize>(deviation).array() += 1;
    sums.lower.row(error).segment<PoseDeviation::kSize>(deviation) += view->deviation->normal.transpose();
    deviation += PoseDeviation::kSize;
  }
  for (Eigen::Index i = kPoseSize; i < numOwn(board, 0); ++i) {
    sums.lower(i, i) += board.flex.precision;
    sums.lower(error, i) += board.flex.precision * views.front()->flex_m(i - kPoseSize);
  }
  equations.own = sums.lower.topLeftCorner(num_own, num_own).selfadjointView<Eigen::Lower>();
  equations.own_error = sums.lower.row(error).head(num_own).transpose();
  equations.mixed.leftCols(columns.num_others) =
      sums.lower.block(num_own, 0, columns.num_others, num_own).transpose();
  if (num_offsets > 0)
    equations.mixed.middleCols(columns.offsets[b], num_offsets) = sums.points.leftCols(num_own).transpose();
  return equations;
}

// Adds the equations of a placement, without its own columns: the information of all unknowns with those
// before the offsets, whose upper triangle is left out.
void add(const PlacementEquations& equations, const JointColumns& columns, Eigen::MatrixXd& information,
         Eigen::VectorXd& gradient) {
  const PlacementSums& sums = equations.sums;
  const Eigen::Index num_own = equations.own.rows();
  const Eigen::Index num_others = columns.num_others;
  const Eigen::Index num_offsets = sums.points.rows();
  const Eigen::MatrixXd mixed = equations.mixed.leftCols(num_others);
  const Eigen::MatrixXd solved = solveSpd(equations.own, mixed);
  auto others = information.topRows(num_others);
  others.triangularView<Eigen::Lower>() += sums.lower.block(num_own, num_own, num_others, num_others);
  others.triangularView<Eigen::Lower>() -= mixed.transpose() * solved;
  gradient.head(num_others) += sums.lower.bottomRows<1>().segment(num_own, num_others).transpose();
  gradient -= equations.mixed.transpose() * solveSpd(equations.own, equations.own_error);
  if (num_offsets == 0) return;
  const Eigen::Index first = equations.first_offset;
  information.middleRows(first, num_offsets) += sums.points.middleCols(num_own, num_others);
  information.middleRows(first, num_offsets) -=
      equations.mixed.middleCols(first, num_offsets).transpose() * solved;
  gradient.segment(first, num_offsets) += sums.points.rightCols<1>();
}

// Frames, their placements, and the views of these.
using Frames = std::map<std::size_t, std::map<std::size_t, std::vector<const FitView*>>>;

Frames framesOf(const Fit& fit) {
  Frames frames;
  for (const FitView& view : fit.views)
    frames[fit.placements[view.placement].frame][view.placement].push_back(&view);
  return frames;
}

void completeUpper(Eigen::MatrixXd& information) {
  auto others = information.topRows(information.cols());
  others.triangularView<Eigen::StrictlyUpper>() = others.transpose();
}

// Combines the directions of a lens so that its corners determine each equally well.
Eigen::MatrixXd balanced(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& information) {
  if (directions.cols() == 0) return directions;
  const Eigen::MatrixXd own = directions.transpose() * information * directions;
  const Eigen::VectorXd scale = own.diagonal().cwiseSqrt().cwiseInverse();  // because units differ
  const auto inverse_root = inverseRootOf(scale.asDiagonal() * own * scale.asDiagonal());
  if (!inverse_root || !scale.allFinite()) return directions;
  return directions * scale.asDiagonal() * *inverse_root;
}

}  // namespace

JointColumns jointColumns(const Fit& fit, Offsets offsets) {
  JointColumns columns;
  const auto take = [&](bool is_free, int size) {
    const int first = is_free ? columns.count : -1;
    columns.count += is_free ? size : 0;
    return first;
  };
  for (const FitCamera& camera : fit.cameras)
    columns.params.push_back(take(true, static_cast<int>(camera.params.size())));
  for (const FitCamera& camera : fit.cameras)
    columns.pose.push_back(take(!camera.is_rig_pose_fixed, kPoseSize));
  for (const FitBoard& board : fit.boards) columns.bend.push_back(take(!board.is_shape_fixed, kNumBends));
  for (const FitCamera& camera : fit.cameras) columns.delay.push_back(take(!camera.is_delay_fixed, 1));
  columns.num_others = columns.count;
  for (const FitBoard& board : fit.boards) {
    const bool is_free = offsets == Offsets::kInclude && board.isUneven();
    columns.offsets.push_back(take(is_free, 3 * board.target.numCorners()));
  }
  return columns;
}

std::vector<Reduced> jointInformation(const Fit& fit, const JointColumns& columns) {
  expect(columns.count == columns.num_others, "columns without offsets");
  std::vector<Reduced> all;
  for (const auto& [index, placements] : framesOf(fit)) {
    Reduced& frame =
        all.emplace_back(Reduced{.information = Eigen::MatrixXd::Zero(columns.count, columns.count),
                                 .gradient = Eigen::VectorXd::Zero(columns.count)});
    for (const auto& [placement, views] : placements)
      add(equationsOf(fit, views, columns, LossWeights::kLeaveOut), columns, frame.information,
          frame.gradient);
    completeUpper(frame.information);
  }
  return all;
}

Eigen::MatrixXd OffsetMatrix::times(const Eigen::MatrixXd& X) const {
  if (full.size() > 0) return full * X;
  Eigen::MatrixXd product = sign * (roots.transpose() * (roots * X).eval());
  for (Eigen::Index i = 0; i < blocks.rows(); i += 3)
    product.middleRows<3>(i) += blocks.middleRows<3>(i) * X.middleRows<3>(i);
  return product;
}

Eigen::VectorXd OffsetMatrix::diagonal() const {
  if (full.size() > 0) return full.diagonal();
  Eigen::VectorXd values = sign * roots.colwise().squaredNorm().transpose();
  for (Eigen::Index i = 0; i < values.size(); ++i) values(i) += blocks(i, i % 3);
  return values;
}

JointEquations jointEquations(const Fit& fit, const JointColumns& columns, LossWeights weights) {
  const Eigen::Index num_offsets = columns.count - columns.num_others;
  Eigen::Index most_roots = 0;
  for (const FitPlacement& placement : fit.placements)
    most_roots += columns.offsets[placement.board] < 0 ? 0 : numOwn(fit.boards[placement.board], 0);
  for (const FitView& view : fit.views)
    most_roots += view.deviation && columns.offsets[boardIndex(fit, view)] >= 0 ? PoseDeviation::kSize : 0;
  const bool are_few = most_roots < num_offsets;
  JointEquations all{.information = Eigen::MatrixXd::Zero(columns.count, columns.num_others),
                     .of_offsets = {.sign = -1},
                     .gradient = Eigen::VectorXd::Zero(columns.count)};
  OffsetMatrix& offsets = all.of_offsets;
  if (are_few) {
    offsets.blocks = Eigen::MatrixXd::Zero(num_offsets, 3);
    offsets.roots = Eigen::MatrixXd::Zero(most_roots, num_offsets);
  } else {
    offsets.full = Eigen::MatrixXd::Zero(num_offsets, num_offsets);
  }
  Eigen::Index num_roots = 0;
  for (const auto& [index, placements] : framesOf(fit)) {
    for (const auto& [placement, views] : placements) {
      const PlacementEquations equations = equationsOf(fit, views, columns, weights);
      add(equations, columns, all.information, all.gradient);
      if (equations.first_offset < 0) continue;
      const Eigen::MatrixXd& shifts = equations.sums.shifts;
      const Eigen::Index first = equations.first_offset - columns.num_others;
      const Eigen::Index count = shifts.rows();
      const Eigen::MatrixXd roots = semidefiniteRootOf(inverseSpd(equations.own)) *
                                    equations.mixed.middleCols(equations.first_offset, count);
      if (are_few) {
        offsets.blocks.middleRows(first, count) += shifts;
        offsets.roots.block(num_roots, first, roots.rows(), count) = roots;
        num_roots += roots.rows();
      } else {
        for (Eigen::Index i = 0; i < count; i += 3)
          offsets.full.block<3, 3>(first + i, first + i) += shifts.middleRows<3>(i);
        offsets.full.block(first, first, count, count).triangularView<Eigen::Lower>() -=
            roots.transpose() * roots;
      }
    }
  }
  if (!are_few) completeUpper(offsets.full);
  completeUpper(all.information);
  return all;
}

Eigen::MatrixXd jointDirections(const Fit& fit, const JointColumns& columns,
                                const Eigen::MatrixXd& information) {
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(columns.count, columns.count);
  Eigen::Index free = 0;
  for (std::size_t c = 0; c < fit.cameras.size(); ++c) {
    const auto num_params = static_cast<int>(fit.cameras[c].params.size());
    const int at = columns.params[c];
    const Eigen::MatrixXd of_lens = balanced(freeDirections(num_params, fit.cameras[c].constraint),
                                             information.block(at, at, num_params, num_params));
    directions.block(at, free, num_params, of_lens.cols()) = of_lens;
    free += of_lens.cols();
  }
  for (int column = columns.params.back() + static_cast<int>(fit.cameras.back().params.size());
       column < columns.count; ++column)
    directions(column, free++) = 1;
  return directions.leftCols(free);
}

}  // namespace alidade
