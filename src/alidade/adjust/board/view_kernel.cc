// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "alidade/adjust/board/disc_rows.h"
#include "alidade/adjust/board/elimination.h"
#include "alidade/adjust/board/view_equations.h"
#include "alidade/core/lanes.h"

namespace alidade {
namespace {

using detail::DiscRows;
using detail::EliminationEquations;

constexpr std::size_t kPose = detail::RowLayout::kPose;

// Sums the upper triangle of the normal equations of a view of points. The sum of rho replaces r^T r. False
// with Unseen::kRefuse if a corner does not project.
bool sumPoints(const detail::ViewRows& points, const double* params, const SE3& camera_from_board,
               std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen,
               EliminationEquations& to) {
  const detail::RowLayout& layout = points.layout();
  const std::size_t last = layout.size - 1;
  Lanes sum_rho = {};
  const bool is_seen = detail::forEachChunk(corners, [&](std::span<const CornerGroup> chunk) {
    Lanes rows[detail::kMaxChunkRows];
    const bool has_all = points.write(params, camera_from_board, chunk, loss, rows, sum_rho);
    if (!has_all && unseen == Unseen::kRefuse) return false;
    callVectorised([&]() ALIDADE_INLINE_LAMBDA { detail::addProducts(layout, rows, chunk.size(), to); });
    return true;
  });
  to.at(last, last) = detail::sumOfLanes(sum_rho);
  return is_seen;
}

// The same for a view of discs.
bool sumDiscs(const detail::ViewRows& points, const double* params, const SE3& camera_from_board,
              std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen, EliminationEquations& to) {
  const DiscRows discs(points, params, camera_from_board);
  const std::size_t size = points.layout().size;
  double sum_of_rho = 0;
  std::array<double, 2 * detail::kMaxColumns> rows;
  for (const CornerGroup& group : corners) {
    for (std::size_t l = 0; l < kNumLanes; ++l) {
      if (group.root_weight[l] == 0) continue;  // padding of the group
      if (!discs.write(group, l, rows.data())) {
        if (unseen == Unseen::kRefuse) return false;
        continue;
      }
      const double weight = group.root_weight[l] * group.root_weight[l];
      const double u = rows[size - 1];
      const double v = rows[2 * size - 1];
      const double s = weight * (u * u + v * v);
      sum_of_rho += loss.rho(s);
      const double factor = weight * loss.weight(s);
      for (std::size_t i = 0; i < size; ++i) {
        for (std::size_t j = i; j < size; ++j)
          to.at(i, j) += factor * (rows[i] * rows[j] + rows[size + i] * rows[size + j]);
      }
    }
  }
  to.at(size - 1, size - 1) = sum_of_rho;
  return true;
}

}  // namespace

int ViewKernel::numParams() const {
  return static_cast<int>(points_->layout().size - kPose - 1);
}

bool ViewKernel::factor(const double* params, const SE3& camera_from_board,
                        std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen,
                        double* rows) const {
  const std::size_t size = points_->layout().size;
  EliminationEquations equations(size);
  const auto& sum = detail::areDiscs(corners) ? sumDiscs : sumPoints;
  if (!sum(*points_, params, camera_from_board, corners, loss, unseen, equations)) return false;
  callVectorised([&]() ALIDADE_INLINE_LAMBDA {
    const std::size_t last = size - 1;
    std::array<double, detail::kMaxColumns> diagonal;
    for (std::size_t i = 0; i < size; ++i) diagonal[i] = equations.at(i, i);
    equations.mirror(0, kPose);
    equations.eliminate(0, kPose, diagonal.data(), rows);
    equations.mirror(kPose, last);
    equations.eliminate(kPose, last, diagonal.data(), rows + kPose * size);
    double* last_row = rows + last * size;
    std::fill_n(last_row, last, 0.0);
    // With the sum of rho in place of r^T r, this is the remainder that the other rows do not contain.
    last_row[last] = std::sqrt(std::max(equations.at(last, last), 0.0));
  });
  return true;
}

double ViewKernel::sumOfRho(const double* params, const SE3& camera_from_board,
                            std::span<const CornerGroup> corners, HuberLoss loss) const {
  if (detail::areDiscs(corners)) {
    const DiscRows discs(*points_, params, camera_from_board);
    double sum = 0;
    for (const CornerGroup& group : corners) {
      for (std::size_t l = 0; l < kNumLanes; ++l) {
        if (group.root_weight[l] == 0) continue;
        const double weight = group.root_weight[l] * group.root_weight[l];
        sum += loss.rho(weight * discs.error(group, l).squaredNorm());
      }
    }
    return sum;
  }
  Lanes rho = {};
  detail::forEachChunk(corners, [&](std::span<const CornerGroup> chunk) {
    Lanes errors[2 * detail::kChunk];
    points_->writeErrors(params, camera_from_board, chunk, errors);
    callVectorised([&]() ALIDADE_INLINE_LAMBDA {
      for (std::size_t i = 0; i < chunk.size(); ++i)
        rho += detail::GroupLoss(errors + 2 * i, chunk[i], loss).rho;
    });
    return true;
  });
  return detail::sumOfLanes(rho);
}

void ViewKernel::errors(const double* params, const SE3& camera_from_board,
                        std::span<const CornerGroup> corners, std::span<Eigen::Vector2d> errors) const {
  if (!detail::areDiscs(corners)) return points_->errors(params, camera_from_board, corners, errors);
  const DiscRows discs(*points_, params, camera_from_board);
  for (std::size_t i = 0; i < errors.size(); ++i)
    errors[i] = discs.error(corners[i / kNumLanes], i % kNumLanes);
}

void ViewKernel::rows(const double* params, const SE3& camera_from_board,
                      std::span<const CornerGroup> corners, std::span<double> rows) const {
  if (!detail::areDiscs(corners)) return points_->rows(params, camera_from_board, corners, rows);
  const DiscRows discs(*points_, params, camera_from_board);
  const std::size_t of_corner = 2 * points_->layout().size;
  for (std::size_t i = 0; i < rows.size() / of_corner; ++i) {
    double* const to = rows.data() + i * of_corner;
    const CornerGroup& group = corners[i / kNumLanes];
    discs.write(group, i % kNumLanes, to);
    for (std::size_t c = 0; c < of_corner; ++c) to[c] *= group.root_weight[i % kNumLanes];
  }
}

ViewKernel viewKernel(std::string_view model_id) {
  return ViewKernel(detail::viewRows(model_id));
}

std::optional<ViewFactor> viewFactor(const ViewKernel& kernel, std::span<const double> params,
                                     const SE3& camera_from_board, std::span<const CornerGroup> corners,
                                     HuberLoss loss, Unseen unseen) {
  const Eigen::Index size = kernel.numParams() + 7;
  ViewFactor factor(size, size);
  if (!kernel.factor(params.data(), camera_from_board, corners, loss, unseen, factor.data()))
    return std::nullopt;
  return factor;
}

Eigen::MatrixXd paramsInformation(const ViewFactor& factor) {
  const Eigen::Index num_params = factor.cols() - 7;
  const auto rest = factor.block(6, 6, num_params, num_params);
  return rest.transpose() * rest;
}

}  // namespace alidade
