// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/reduced.h"

#include "alidade/adjust/board/corner_groups.h"
#include "alidade/adjust/board/view_kernel.h"

namespace alidade::detail {

WeightedRows weightedRows(std::string_view model_id, std::span<const double> params,
                          const SE3& camera_from_board, std::span<const Observation> view, HuberLoss loss) {
  const ViewKernel kernel = viewKernel(model_id);
  const CornerGroups groups(view);
  const Eigen::Index num_columns = kernel.numParams() + 7;
  WeightedRows of;
  of.rows.resize(2 * static_cast<Eigen::Index>(view.size()), num_columns);
  kernel.rows(params.data(), camera_from_board, groups.view(0),
              {of.rows.data(), static_cast<std::size_t>(of.rows.size())});
  constexpr Eigen::Index kCx = 6 + 2;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const auto from = static_cast<Eigen::Index>(2 * i);
    const double root_weight = of.rows(from, kCx);  // as the pixel moves with the principal point
    if (!(root_weight > 0)) continue;
    const auto to = static_cast<Eigen::Index>(2 * of.corner.size());
    if (to != from) of.rows.middleRows<2>(to) = of.rows.middleRows<2>(from);
    of.corner.push_back(i);
    of.root_weight.push_back(root_weight);
    of.loss_weight.push_back(loss.weight(of.rows.block<2, 1>(to, num_columns - 1).squaredNorm()));
  }
  of.rows.conservativeResize(2 * static_cast<Eigen::Index>(of.corner.size()), num_columns);
  return of;
}

Reduced eliminatePose(const ViewGram& gram) {
  const Eigen::Index num_params = gram.dense.rows() - 7;
  const Eigen::Index num_extra = gram.extra.rows();
  const Eigen::Index size = num_params + num_extra;
  const Eigen::Index error = 6 + num_params;
  const Eigen::Matrix<double, 6, 6> pose = gram.dense.topLeftCorner<6, 6>().selfadjointView<Eigen::Lower>();
  Eigen::MatrixXd coupling(6, size + 1);
  coupling << gram.dense.block(6, 0, num_params, 6).transpose(), gram.mixed.leftCols<6>().transpose(),
      gram.dense.block(error, 0, 1, 6).transpose();
  Reduced reduced{.information = Eigen::MatrixXd(size, size),
                  .gradient = Eigen::VectorXd(size),
                  .squares = gram.dense(error, error),
                  .num_corners = gram.num_corners};
  auto& information = reduced.information;
  information.topLeftCorner(num_params, num_params) = gram.dense.block(6, 6, num_params, num_params);
  information.bottomLeftCorner(num_extra, num_params) = gram.mixed.middleCols(6, num_params);
  information.bottomRightCorner(num_extra, num_extra) = gram.extra;
  reduced.gradient << gram.dense.block(error, 6, 1, num_params).transpose(), gram.mixed.col(error);
  const Eigen::MatrixXd solved = pose.ldlt().solve(coupling);
  information.triangularView<Eigen::Lower>() -= coupling.leftCols(size).transpose() * solved.leftCols(size);
  information.triangularView<Eigen::StrictlyUpper>() = information.transpose();
  reduced.gradient -= coupling.leftCols(size).transpose() * solved.col(size);
  reduced.squares -= coupling.col(size).dot(solved.col(size));
  return reduced;
}

}  // namespace alidade::detail
