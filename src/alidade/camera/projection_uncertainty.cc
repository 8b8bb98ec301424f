// SPDX-License-Identifier: MIT
#include "alidade/camera/projection_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "alidade/camera/camera_model.h"
#include "alidade/camera/correction_field.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/geometry/decompositions.h"
#include "alidade/geometry/so3.h"

namespace alidade {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Pixels at equal steps from one border of a side to the other.
double pixelAt(int i, int count, int side) {
  return count == 1 ? 0.5 * (side - 1) : static_cast<double>(i) * (side - 1) / (count - 1);
}

int rowsFor(int columns, ImageSize size) {
  if (size.width < 2 || size.height < 2) return size.height < 2 ? 1 : 2;
  const double cell = static_cast<double>(size.width - 1) / (columns - 1);
  return std::clamp(static_cast<int>(std::lround((size.height - 1) / cell)) + 1, 2, size.height);
}

double largerStd(const Eigen::Matrix2d& covariance) {
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double half = 0.5 * (covariance(0, 0) - covariance(1, 1));
  return std::sqrt(mean + std::sqrt(half * half + covariance(0, 1) * covariance(0, 1)));
}

}  // namespace

AlignedJacobians alignedJacobians(const AnyCamera& camera, std::span<const Eigen::Vector2d> pixels,
                                  std::span<const Eigen::Vector2d> others, std::optional<Freed> freed,
                                  std::span<const double> weights, const CorrectionGrid* grid) {
  const auto num_fitted = static_cast<Eigen::Index>(2 * pixels.size());
  const auto num_rows = num_fitted + static_cast<Eigen::Index>(2 * others.size());
  const auto num_lens = static_cast<Eigen::Index>(camera.parameters().size());
  const Eigen::Index num_params = num_lens + (grid == nullptr ? 0 : 2 * grid->numPoints());
  const Eigen::Index num_freed = !freed ? 0 : *freed == Freed::kRotation ? 3 : 6;
  // Two rows per pixel: its derivatives by the parameters, by the rotation, and by the position of the points
  // in units of the distance.
  Eigen::MatrixXd by_params = Eigen::MatrixXd::Zero(num_rows, num_params);
  Eigen::MatrixXd by_pose = Eigen::MatrixXd::Zero(num_rows, num_freed);
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> J_point;
  Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor> J_params(2, num_lens);
  AlignedJacobians result;
  for (const auto& list : {pixels, others}) {
    for (const Eigen::Vector2d& pixel : list) {
      const auto row = static_cast<Eigen::Index>(2 * result.has_ray.size());
      const auto ray = camera.unproject(pixel);
      result.has_ray.push_back(ray && camera.project(*ray, J_point.data(), J_params.data()).ok());
      if (!result.has_ray.back()) continue;
      by_params.middleRows<2>(row).leftCols(num_lens) = J_params;
      if (grid != nullptr) {
        grid->forEachWeight(pixel, [&](int point, double weight) {
          for (int axis = 0; axis < 2; ++axis) by_params(row + axis, num_lens + 2 * point + axis) = weight;
        });
      }
      if (num_freed > 0) by_pose.block<2, 3>(row, 0) = -J_point * hat(*ray);
      if (num_freed > 3) by_pose.block<2, 3>(row, 3) = J_point;
    }
  }
  if (num_freed == 0) {
    result.transposed = by_params.transpose();
    return result;
  }
  Eigen::MatrixXd fitted_pose = by_pose.topRows(num_fitted);
  Eigen::MatrixXd fitted_params = by_params.topRows(num_fitted);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double root = std::sqrt(weights[i]);
    fitted_pose.middleRows<2>(2 * static_cast<Eigen::Index>(i)) *= root;
    fitted_params.middleRows<2>(2 * static_cast<Eigen::Index>(i)) *= root;
  }
  // Through a long lens, a shift of the camera looks almost like a rotation. Any solution will do, because
  // only the remaining change matters.
  const Eigen::MatrixXd W = leastSquares(fitted_pose, fitted_params);
  result.transposed = (by_params - by_pose * W).transpose();
  return result;
}

ProjectionUncertainty::ProjectionUncertainty(const AnyCamera& camera, ImageSize size, double distance_m,
                                             std::optional<Freed> freed, int columns) {
  const auto refusal = [](const std::string& found, const std::string& expected) {
    return usageError({.where = "projection uncertainty", .found = found, .expected = expected});
  };
  if (!(distance_m > 0))
    throw refusal("a distance of " + exactText(distance_m) + " m", "a positive distance, or infinity");
  const Freed what = freed.value_or(std::isinf(distance_m) ? Freed::kRotation : Freed::kPose);
  if (what == Freed::kPose && std::isinf(distance_m)) {
    throw refusal("alignment by a pose at an infinite distance",
                  "a finite distance, or alignment by a rotation: the position of the camera does not affect "
                  "points at infinity");
  }
  if (columns < 2) throw refusal(std::to_string(columns) + " columns", "2 or more");
  columns_ = std::min(columns, size.width);
  rows_ = rowsFor(columns_, size);
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column)
      pixels_.emplace_back(pixelAt(column, columns_, size.width), pixelAt(row, rows_, size.height));
  }

  const Eigen::Vector2d center(0.5 * (size.width - 1), 0.5 * (size.height - 1));
  AlignedJacobians aligned = alignedJacobians(camera, pixels_, std::span(&center, 1), what);
  center_has_ray_ = aligned.has_ray.back();
  aligned.has_ray.pop_back();
  has_ray_ = std::move(aligned.has_ray);
  jacobians_ = std::move(aligned.transposed);
}

Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>> ProjectionUncertainty::jacobian(
    int i) const {
  const Eigen::Index n = jacobians_.rows();
  return {jacobians_.view().data() + 2 * n * i, 2, n};
}

// Works in blocks of columns, because products of single columns are much slower.
template <class F>
void ProjectionUncertainty::forEachCovariance(const Eigen::MatrixXd& parameter_covariance, F&& f) const {
  expect(parameter_covariance.rows() == jacobians_.rows() && parameter_covariance.cols() == jacobians_.rows(),
         "the covariance has a row and a column for each of the camera's parameters");
  const Eigen::Index end = jacobians_.cols() / 2;
  constexpr int kBlock = 32;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostParams, 2 * kBlock> product;
  for (Eigen::Index first = 0; first < end; first += kBlock) {
    const Eigen::Index count = std::min<Eigen::Index>(kBlock, end - first);
    const auto A = jacobians_.view().middleCols(2 * first, 2 * count);
    product.noalias() = parameter_covariance * A;
    for (Eigen::Index i = 0; i < count; ++i) {
      Eigen::Matrix2d covariance;
      covariance(0, 0) = A.col(2 * i).dot(product.col(2 * i));
      covariance(0, 1) = covariance(1, 0) = A.col(2 * i).dot(product.col(2 * i + 1));
      covariance(1, 1) = A.col(2 * i + 1).dot(product.col(2 * i + 1));
      f(static_cast<std::size_t>(first + i), covariance);
    }
  }
}

UncertaintyGrid ProjectionUncertainty::grid(const Eigen::MatrixXd& parameter_covariance) const {
  UncertaintyGrid result{.columns = columns_, .rows = rows_, .pixels = pixels_, .std_px = {}};
  result.center_px = kNan;
  forEachCovariance(parameter_covariance, [&](std::size_t i, const auto& found) {
    if (i < pixels_.size()) {
      result.std_px.push_back(has_ray_[i] ? largerStd(found) : kNan);
    } else if (center_has_ray_) {
      result.center_px = largerStd(found);
    }
  });
  const Worst found = worst(parameter_covariance);
  result.worst_px = found.std_px;
  result.worst_pixel =
      found.index < 0 ? Eigen::Vector2d::Constant(kNan) : pixels_[static_cast<std::size_t>(found.index)];
  return result;
}

ProjectionUncertainty::Worst ProjectionUncertainty::worst(const Eigen::MatrixXd& parameter_covariance) const {
  Worst result{.std_px = kNan};
  bool has_nan = false;
  forEachCovariance(parameter_covariance, [&](std::size_t i, const auto& found) {
    if (i == pixels_.size() || !has_ray_[i]) return;
    const double std = largerStd(found);
    if (std::isnan(std)) has_nan = true;
    if (result.index < 0 || std > result.std_px) result = {.std_px = std, .index = static_cast<int>(i)};
  });
  return has_nan ? Worst{.std_px = kNan} : result;
}

}  // namespace alidade
