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

// The columns that are eliminated from the equations of a placement: its pose, the bends that flexible
// boards have there, and the deviations of its views.
struct OwnColumns {
  std::map<std::size_t, Eigen::Index> bend = {};          // of each flexible board
  std::map<const FitView*, Eigen::Index> deviation = {};  // of each view with one
  Eigen::Index count = kPoseSize;
};

OwnColumns ownColumns(const Fit& fit, std::span<const FitView* const> views) {
  OwnColumns own;
  for (const FitView* view : views) {
    if (boardOf(fit, *view).isFlexible() && own.bend.try_emplace(view->board, own.count).second)
      own.count += kNumBends;
  }
  for (const FitView* view : views) {
    if (!view->deviation) continue;
    own.deviation[view] = own.count;
    own.count += PoseDeviation::kSize;
  }
  return own;
}

// The columns of the offsets of all boards of a placement.
struct OffsetRange {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
};

OffsetRange offsetRange(const Fit& fit, std::span<const FitView* const> views, const JointColumns& columns) {
  OffsetRange range;
  for (const FitView* view : views) {
    const Eigen::Index first = columns.offsets[view->board];
    if (first < 0) continue;
    const Eigen::Index last = first + 3 * static_cast<Eigen::Index>(boardOf(fit, *view).target.numCorners());
    const Eigen::Index end = range.count == 0 ? last : std::max(last, range.first + range.count);
    range.first = range.count == 0 ? first : std::min(first, range.first);
    range.count = end - range.first;
  }
  return range;
}

// Sums of products over the views of a placement. Their columns are those of the placement, the unknowns of
// the fit without offsets, and the error.
struct PlacementSums {
  Eigen::MatrixXd lower;   // triangle
  Eigen::MatrixXd points;  // a row for each of the offsets, with these columns
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
// delay, its board's place in the body and its camera's pose. C Exp(eta) P Exp(zeta) B Exp(beta) Exp(d) =
// C P B Exp(d) Exp(Ad(Exp(-d)) (Ad((P B)^-1) eta + Ad(B^-1) zeta + beta)).
std::vector<PoseColumns> poseColumns(const Fit& fit, const FitView& view, const JointColumns& columns,
                                     const OwnColumns& own) {
  const Matrix6d by_body = boardOf(fit, view).tangentByBody();
  Matrix6d moved = Matrix6d::Identity();
  std::vector<PoseColumns> all;
  if (view.deviation) {
    const Vector6d tangent = deviationTangent(fit, view);
    const Matrix6d jacobian = SE3::rightJacobian(tangent);
    const Eigen::Index deviation = own.deviation.at(&view);
    moved = SE3::exp(-tangent).adjoint();
    all = {{deviation, jacobian * view.deviation->root.leftCols<kPoseSize>()},
           oneColumn(deviation + kPoseSize, jacobian * view.deviation->root.col(kPoseSize))};
    if (columns.delay[view.camera] >= 0) {
      const double delay = fit.cameras[view.camera].delay;
      all.push_back(oneColumn(own.count + columns.delay[view.camera],
                              jacobian * view.deviation->tangentByDelay(delay)));
    }
  }
  all.insert(all.begin(), {0, moved * by_body});
  if (columns.body[view.board] >= 0) all.push_back({own.count + columns.body[view.board], moved});
  if (columns.pose[view.camera] >= 0) {
    all.push_back(
        {own.count + columns.pose[view.camera], moved * rigFromBoard(fit, view).inverse().adjoint()});
  }
  return all;
}

void add(const Fit& fit, const FitView& view, const JointColumns& columns, LossWeights weights,
         const OwnColumns& own, const OffsetRange& offsets, PlacementSums& sums) {
  const FitCamera& camera = fit.cameras[view.camera];
  const std::size_t b = view.board;
  const Eigen::Index num_own = own.count;
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
  if (has_flex) to.insert(to.end(), {own.bend.at(b), own.bend.at(b) + 1});
  if (!has_flex && has_bend) place(columns.bend[b], kNumBends);
  place(columns.num_others, 1);
  const auto at = [&](Eigen::Index i, Eigen::Index j) -> double& {
    return sums.lower(std::max(i, j), std::min(i, j));
  };
  const Eigen::Index size = gram.lower.rows() - kPoseSize;
  const Eigen::Index first_point = columns.offsets[b] - offsets.first;  // of the rows
  for (Eigen::Index j = 0; j < size; ++j) {
    const Eigen::Index column = to[static_cast<std::size_t>(j)];
    if (column < 0) continue;
    for (Eigen::Index i = j; i < size; ++i) {
      const Eigen::Index row = to[static_cast<std::size_t>(i)];
      if (row >= 0) at(row, column) += gram.lower(kPoseSize + i, kPoseSize + j);
    }
    for (std::size_t k = 0; k < gram.ids.size(); ++k) {
      sums.points.col(column).segment<3>(first_point + 3 * gram.ids[k]) +=
          gram.points.col(kPoseSize + j).segment<3>(3 * static_cast<Eigen::Index>(k));
    }
  }
  for (std::size_t k = 0; k < gram.ids.size(); ++k)
    sums.shifts.middleRows<3>(first_point + 3 * gram.ids[k]) +=
        gram.points.block<3, 3>(3 * static_cast<Eigen::Index>(k), 0);
  const Matrix6d pose = gram.lower.topLeftCorner<kPoseSize, kPoseSize>().selfadjointView<Eigen::Lower>();
  const PoseRows rest = gram.lower.bottomLeftCorner(size, kPoseSize).transpose();
  const std::vector<PoseColumns> moves = poseColumns(fit, view, columns, own);
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
      sums.points.block(first_point + 3 * gram.ids[k], one->first, 3, one->count) +=
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
  Eigen::MatrixXd mixed;  // own columns with the unknowns of the fit
  OffsetRange offsets;
};

PlacementEquations equationsOf(const Fit& fit, std::span<const FitView* const> views,
                               const JointColumns& columns, LossWeights weights) {
  const OwnColumns own = ownColumns(fit, views);
  const OffsetRange offsets = offsetRange(fit, views, columns);
  const Eigen::Index num_own = own.count;
  const Eigen::Index error = num_own + columns.num_others;
  PlacementEquations equations{.sums = {.lower = Eigen::MatrixXd::Zero(error + 1, error + 1),
                                        .points = Eigen::MatrixXd::Zero(offsets.count, error + 1),
                                        .shifts = Eigen::MatrixXd::Zero(offsets.count, 3)},
                               .own = {},
                               .own_error = {},
                               .mixed = Eigen::MatrixXd::Zero(num_own, columns.count),
                               .offsets = offsets};
  PlacementSums& sums = equations.sums;
  for (const FitView* view : views) add(fit, *view, columns, weights, own, offsets, sums);
  for (const auto& [view, at] : own.deviation) {
    sums.lower.diagonal().segment<PoseDeviation::kSize>(at).array() += 1;
    sums.lower.row(error).segment<PoseDeviation::kSize>(at) += view->deviation->normal.transpose();
  }
  for (const auto& [board, at] : own.bend) {
    const double precision = fit.boards[board].flex.precision;
    const FitView& view =
        **std::ranges::find_if(views, [&, b = board](const FitView* of) { return of->board == b; });
    sums.lower.diagonal().segment<kNumBends>(at).array() += precision;
    sums.lower.row(error).segment<kNumBends>(at) += precision * view.flex_m.transpose();
  }
  equations.own = sums.lower.topLeftCorner(num_own, num_own).selfadjointView<Eigen::Lower>();
  equations.own_error = sums.lower.row(error).head(num_own).transpose();
  equations.mixed.leftCols(columns.num_others) =
      sums.lower.block(num_own, 0, columns.num_others, num_own).transpose();
  if (offsets.count > 0)
    equations.mixed.middleCols(offsets.first, offsets.count) = sums.points.leftCols(num_own).transpose();
  return equations;
}

// Adds the equations of a placement, without its own columns: the information of all unknowns with those
// before the offsets, whose upper triangle is left out.
void add(const PlacementEquations& equations, const JointColumns& columns, Eigen::MatrixXd& information,
         Eigen::VectorXd& gradient) {
  const PlacementSums& sums = equations.sums;
  const Eigen::Index num_own = equations.own.rows();
  const Eigen::Index num_others = columns.num_others;
  const auto [first, num_offsets] = equations.offsets;
  const Eigen::MatrixXd mixed = equations.mixed.leftCols(num_others);
  const Eigen::MatrixXd solved = solveSpd(equations.own, mixed);
  auto others = information.topRows(num_others);
  others.triangularView<Eigen::Lower>() += sums.lower.block(num_own, num_own, num_others, num_others);
  others.triangularView<Eigen::Lower>() -= mixed.transpose() * solved;
  gradient.head(num_others) += sums.lower.bottomRows<1>().segment(num_own, num_others).transpose();
  gradient -= equations.mixed.transpose() * solveSpd(equations.own, equations.own_error);
  if (num_offsets == 0) return;
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
  for (const FitBoard& board : fit.boards) columns.body.push_back(take(board.isBodyPoseFree(), kPoseSize));
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
  const Frames frames = framesOf(fit);
  Eigen::Index most_roots = 0;
  for (const auto& [index, placements] : frames) {
    for (const auto& [placement, views] : placements)
      most_roots += offsetRange(fit, views, columns).count > 0 ? ownColumns(fit, views).count : 0;
  }
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
  for (const auto& [index, placements] : frames) {
    for (const auto& [placement, views] : placements) {
      const PlacementEquations equations = equationsOf(fit, views, columns, weights);
      add(equations, columns, all.information, all.gradient);
      if (equations.offsets.count == 0) continue;
      const Eigen::MatrixXd& shifts = equations.sums.shifts;
      const Eigen::Index first = equations.offsets.first - columns.num_others;
      const Eigen::Index count = equations.offsets.count;
      const Eigen::MatrixXd roots = semidefiniteRootOf(inverseSpd(equations.own)) *
                                    equations.mixed.middleCols(equations.offsets.first, count);
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
