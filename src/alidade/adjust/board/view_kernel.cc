// SPDX-License-Identifier: MIT
#include "alidade/adjust/board/view_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "alidade/adjust/board/view_equations.h"
#include "alidade/core/lanes.h"
#include "alidade/geometry/curve_centroid.h"

namespace alidade {
namespace {

using detail::EliminationEquations;

constexpr std::size_t kPose = RowLayout::kPose;

// True if the corners of a view are discs; a board has only one kind.
bool areDiscs(std::span<const CornerGroup> corners) {
  return !corners.empty() && corners.front().radius_m > 0;
}

// The projection of discs: the centroid of a disc's image, which differs from the image of its centre,
// follows from the images of points on its rim, see centroidWithin().
constexpr std::size_t kRimPoints = 12;
static_assert(kRimPoints % kNumLanes == 0);
using Rim = std::array<CornerGroup, kRimPoints / kNumLanes>;
using RimPixels = Eigen::Matrix<double, 2, static_cast<int>(kRimPoints)>;

// The rim as corners seen at pixel (0, 0), so that their errors are their pixels.
Rim rimOf(const CornerGroup& group, std::size_t lane) {
  static const RimPixels circle = unitCircle<static_cast<int>(kRimPoints)>();
  Rim rim;
  for (std::size_t i = 0; i < kRimPoints; ++i) {
    CornerGroup& to = rim[i / kNumLanes];
    const std::size_t l = i % kNumLanes;
    const auto place = static_cast<Eigen::Index>(i);
    to.x[l] = group.x[lane] + group.radius_m * circle(0, place);
    to.y[l] = group.y[lane] + group.radius_m * circle(1, place);
    to.z[l] = group.z[lane];
    to.u[l] = to.v[l] = 0;
    to.root_weight[l] = 1;
    to.radius_m = 0;
  }
  return rim;
}

// Projected minus observed, px; NaN if a point of the rim does not project.
Eigen::Vector2d discError(const ViewKernel& kernel, const double* params, const SE3& camera_from_board,
                          const CornerGroup& group, std::size_t lane) {
  const Rim rim = rimOf(group, lane);
  std::array<Eigen::Vector2d, kRimPoints> pixels;
  kernel.errors(params, camera_from_board, rim, pixels);
  RimPixels seen;
  for (std::size_t i = 0; i < kRimPoints; ++i) seen.col(static_cast<Eigen::Index>(i)) = pixels[i];
  return centroidWithin(seen).at - Eigen::Vector2d(group.u[lane], group.v[lane]);
}

// The rows of u and v as in ViewKernel::rows(), but without the corner's weight; zero, and false, if a point
// of the rim does not project.
bool writeDisc(const ViewKernel& kernel, const double* params, const SE3& camera_from_board,
               const CornerGroup& group, std::size_t lane, double* rows) {
  constexpr auto kRows = static_cast<int>(2 * kRimPoints);
  const auto size = static_cast<int>(kernel.layout().size);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kRows,
                                 static_cast<int>(kMaxColumns)>;
  RowMajor of_rim(kRows, size);
  const Rim rim = rimOf(group, lane);
  kernel.rows(params, camera_from_board, rim,
              std::span(of_rim.data(), static_cast<std::size_t>(kRows * size)));
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> to(rows, 2, size);
  // A point that projects has derivative 1 by the image's centre.
  constexpr int kCentreX = 6 + 2;
  for (int i = 0; i < kRows; i += 2) {
    if (of_rim(i, kCentreX) != 0) continue;
    to.setZero();
    return false;
  }
  RimPixels seen;
  for (int i = 0; i < static_cast<int>(kRimPoints); ++i)
    seen.col(i) << of_rim(2 * i, size - 1), of_rim(2 * i + 1, size - 1);
  const auto centroid = centroidWithin(seen);
  // Column by column: u and v of each point alternate, like the rows.
  to.row(0).noalias() = centroid.J_x_points.reshaped().transpose() * of_rim;
  to.row(1).noalias() = centroid.J_y_points.reshaped().transpose() * of_rim;
  to(0, size - 1) = centroid.at.x() - group.u[lane];
  to(1, size - 1) = centroid.at.y() - group.v[lane];
  return true;
}

// Sums the upper triangle of the normal equations of a view of points. The sum of rho replaces r^T r. False
// with Unseen::kRefuse if a corner does not project.
bool sumPoints(const ViewKernel& kernel, const double* params, const SE3& camera_from_board,
               std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen,
               EliminationEquations& to) {
  const RowLayout& layout = kernel.layout();
  const std::size_t last = layout.size - 1;
  Lanes sum_rho = {};
  const bool is_seen = detail::forEachChunk(corners, [&](std::span<const CornerGroup> chunk) {
    Lanes rows[detail::kMaxChunkRows];
    const bool has_all = kernel.write(params, camera_from_board, chunk, loss, rows, sum_rho);
    if (!has_all && unseen == Unseen::kRefuse) return false;
    callVectorised([&]() ALIDADE_INLINE_LAMBDA { detail::addProducts(layout, rows, chunk.size(), to); });
    return true;
  });
  to.at(last, last) = detail::sumOfLanes(sum_rho);
  return is_seen;
}

// The same for a view of discs.
bool sumDiscs(const ViewKernel& kernel, const double* params, const SE3& camera_from_board,
              std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen, EliminationEquations& to) {
  const std::size_t size = kernel.layout().size;
  double sum_of_rho = 0;
  std::array<double, 2 * kMaxColumns> rows;
  for (const CornerGroup& group : corners) {
    for (std::size_t l = 0; l < kNumLanes; ++l) {
      if (group.root_weight[l] == 0) continue;  // padding of the group
      if (!writeDisc(kernel, params, camera_from_board, group, l, rows.data())) {
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

std::vector<CornerGroup> groupsOf(std::span<const Observation> view) {
  std::vector<CornerGroup> groups((view.size() + kNumLanes - 1) / kNumLanes);
  for (std::size_t i = 0; i < groups.size() * kNumLanes; ++i) {
    const bool is_corner = i < view.size();
    const Observation& corner = view[is_corner ? i : 0];
    CornerGroup& group = groups[i / kNumLanes];
    const std::size_t l = i % kNumLanes;
    group.x[l] = corner.p_board.x();
    group.y[l] = corner.p_board.y();
    group.z[l] = corner.p_board.z();
    group.u[l] = corner.pixel.x();
    group.v[l] = corner.pixel.y();
    group.root_weight[l] = is_corner ? std::sqrt(corner.weight) : 0.0;
    group.radius_m = corner.radius_m;
  }
  return groups;
}

int ViewKernel::numParams() const {
  return static_cast<int>(layout().size - kPose - 1);
}

bool ViewKernel::factor(const double* params, const SE3& camera_from_board,
                        std::span<const CornerGroup> corners, HuberLoss loss, Unseen unseen,
                        double* rows) const {
  const std::size_t size = layout().size;
  EliminationEquations equations(size);
  const auto& sum = areDiscs(corners) ? sumDiscs : sumPoints;
  if (!sum(*this, params, camera_from_board, corners, loss, unseen, equations)) return false;
  callVectorised([&]() ALIDADE_INLINE_LAMBDA {
    const std::size_t last = size - 1;
    std::array<double, kMaxColumns> diagonal;
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
  if (areDiscs(corners)) {
    double sum = 0;
    for (const CornerGroup& group : corners) {
      for (std::size_t l = 0; l < kNumLanes; ++l) {
        if (group.root_weight[l] == 0) continue;
        const double weight = group.root_weight[l] * group.root_weight[l];
        sum += loss.rho(weight * discError(*this, params, camera_from_board, group, l).squaredNorm());
      }
    }
    return sum;
  }
  Lanes rho = {};
  detail::forEachChunk(corners, [&](std::span<const CornerGroup> chunk) {
    Lanes errors[2 * detail::kChunk];
    writeErrors(params, camera_from_board, chunk, errors);
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
  if (areDiscs(corners)) {
    for (std::size_t i = 0; i < errors.size(); ++i)
      errors[i] = discError(*this, params, camera_from_board, corners[i / kNumLanes], i % kNumLanes);
    return;
  }
  std::size_t i = 0;
  detail::forEachChunk(corners, [&](std::span<const CornerGroup> chunk) {
    Lanes of_chunk[2 * detail::kChunk];
    writeErrors(params, camera_from_board, chunk, of_chunk);
    for (std::size_t g = 0; g < chunk.size(); ++g) {
      CornerGroup::Column u;
      CornerGroup::Column v;
      lane::store(of_chunk[2 * g], u.data());
      lane::store(of_chunk[2 * g + 1], v.data());
      for (std::size_t l = 0; l < kNumLanes && i < errors.size(); ++l, ++i) errors[i] = {u[l], v[l]};
    }
    return true;
  });
}

void ViewKernel::rows(const double* params, const SE3& camera_from_board,
                      std::span<const CornerGroup> corners, std::span<double> rows) const {
  const RowLayout& columns = layout();
  const std::size_t of_corner = 2 * columns.size;
  const std::size_t num_corners = rows.size() / of_corner;
  std::fill(rows.begin(), rows.end(), 0.0);
  if (areDiscs(corners)) {
    for (std::size_t i = 0; i < num_corners; ++i) {
      double* const to = rows.data() + i * of_corner;
      const CornerGroup& group = corners[i / kNumLanes];
      writeDisc(*this, params, camera_from_board, group, i % kNumLanes, to);
      for (std::size_t c = 0; c < of_corner; ++c) to[c] *= group.root_weight[i % kNumLanes];
    }
    return;
  }
  std::size_t corner = 0;
  detail::forEachChunk(corners, [&](std::span<const CornerGroup> chunk) {
    Lanes of_chunk[detail::kMaxChunkRows];
    Lanes rho = {};
    write(params, camera_from_board, chunk, kNoLoss, of_chunk, rho);
    const Lanes* at = of_chunk;
    for (std::size_t g = 0; g < chunk.size(); ++g, corner += kNumLanes) {
      const std::size_t count = std::min(kNumLanes, num_corners - corner);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        for (std::size_t c = 0; c < columns.width; ++c) {
          CornerGroup::Column values;
          lane::store(*at++, values.data());
          const std::size_t to = axis * columns.size + columns.column[axis][c];
          for (std::size_t l = 0; l < count; ++l) rows[(corner + l) * of_corner + to] = values[l];
        }
      }
    }
    return true;
  });
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
