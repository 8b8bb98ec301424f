// SPDX-License-Identifier: MIT
#include "alidade/calibrate/uncertainty/view_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr int kCellsAlong = 6;  // the longer side

// Nodes of the field, and its two displacements at each.
class FieldGrid {
 public:
  explicit FieldGrid(ImageSize size)
      : side_(static_cast<double>(std::max(size.width, size.height)) / kCellsAlong),
        columns_(static_cast<int>(std::ceil(size.width / side_))),
        rows_(static_cast<int>(std::ceil(size.height / side_))) {}

  [[nodiscard]] int size() const { return 2 * (columns_ + 1) * (rows_ + 1); }

  // The four displacements along an axis that a corner's pixel depends on.
  [[nodiscard]] ExtraElements<4> elements(const CornerRows& rows, int axis) const {
    const Eigen::Vector2d& pixel = rows.corner.pixel;
    const double w = rows.root_weight;
    const double x = (pixel.x() + 0.5) / side_;
    const double y = (pixel.y() + 0.5) / side_;
    const int column = std::clamp(static_cast<int>(std::floor(x)), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(std::floor(y)), 0, rows_ - 1);
    const double a = x - column;
    const double b = y - row;
    const auto node = [&](int c, int r) { return 2 * ((row + r) * (columns_ + 1) + column + c) + axis; };
    return {.column = {node(0, 0), node(1, 0), node(0, 1), node(1, 1)},
            .value = {w * (1 - a) * (1 - b), w * a * (1 - b), w * (1 - a) * b, w * a * b}};
  }

 private:
  double side_;
  int columns_;
  int rows_;
};

// Inverse in the directions that the views determine.
Eigen::MatrixXd inverseOfDetermined(const Eigen::MatrixXd& matrix) {
  constexpr double kUndetermined = 1e-11;
  if (matrix.size() == 0) return matrix;  // all parameters are held
  const Eigen::VectorXd scale =
      matrix.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 0.0; });
  const SymmetricEigen solver(scale.asDiagonal() * matrix * scale.asDiagonal());
  const double largest = solver.eigenvalues().maxCoeff();
  const Eigen::VectorXd inverse = solver.eigenvalues().unaryExpr(
      [&](double value) { return value > kUndetermined * largest ? 1 / value : 0.0; });
  return scale.asDiagonal() * solver.eigenvectors() * inverse.asDiagonal() *
         solver.eigenvectors().transpose() * scale.asDiagonal();
}

}  // namespace

ImageBias imageBias(const Fit& fit) {
  const FitCamera& camera = onlyCamera(fit);
  const FieldGrid grid(camera.size);
  const auto n = static_cast<Eigen::Index>(camera.params.size());
  const Eigen::Index m = grid.size();
  // Sums for the intrinsics and the field, with the poses of the views eliminated.
  Eigen::MatrixXd votes = Eigen::MatrixXd::Zero(n + m, n + m);
  Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(n + m, std::ssize(fit.views));  // one column per view
  for (Eigen::Index v = 0; v < gradients.cols(); ++v) {
    const Reduced view = reduced(fit, fit.views[static_cast<std::size_t>(v)], LossWeights::kUse, grid);
    votes += view.information;
    gradients.col(v) = view.gradient;
  }
  // The intrinsics are eliminated as well.
  const Eigen::MatrixXd directions = freeDirections(static_cast<int>(n), camera.constraint);
  const Eigen::MatrixXd coupling = directions.transpose() * votes.topRightCorner(n, m);
  const Eigen::MatrixXd back =
      coupling.transpose() *
      inverseOfDetermined(directions.transpose() * votes.topLeftCorner(n, n) * directions);
  const Eigen::MatrixXd scores =
      gradients.bottomRows(m) - back * (directions.transpose() * gradients.topRows(n));
  Eigen::MatrixXd information = votes.bottomRightCorner(m, m) - back * coupling;
  // The parts of the field that poses and intrinsics would absorb have hardly any information, which must not
  // be divided by.
  constexpr double kPrior = 0.05;  // of the mean information
  const double prior = kPrior * information.trace() / static_cast<double>(m);
  if (!(prior > 0)) return {};
  information.diagonal().array() += prior;
  const Eigen::MatrixXd whitened = information.llt().matrixL().solve(scores);
  const Eigen::MatrixXd products = whitened.transpose() * whitened;  // products of two views
  const double agreed = products.sum() - products.trace();
  // If views have nothing in common, flipping the sign of whole views changes nothing. Over all flips the sum
  // has the mean 0 and this variance.
  const double variance = 2 * (products.squaredNorm() - products.diagonal().squaredNorm());
  if (!(variance > 0)) return {};
  return {.z = agreed / std::sqrt(variance),
          .rms_px = std::sqrt(std::max(0.0, agreed / static_cast<double>(numCorners(fit))))};
}

}  // namespace alidade
