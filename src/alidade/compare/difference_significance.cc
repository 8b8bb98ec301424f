// SPDX-License-Identifier: MIT
#include "alidade/compare/difference_significance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "alidade/camera/projection_uncertainty.h"
#include "alidade/core/error.h"
#include "alidade/core/statistics.h"
#include "alidade/geometry/symmetric_eigen.h"

namespace alidade {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
// Differences below this are rounding, whatever the covariance says.
constexpr double kRoundingPx = 1e-9;

// S with S S^T = covariance, which may be singular: parameters that are held have no variance.
Eigen::MatrixXd rootOf(const Eigen::MatrixXd& covariance) {
  // Scaled first: the units of the parameters span ten orders of magnitude.
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const SymmetricEigen solver(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  return scale.asDiagonal() * solver.eigenvectors() *
         Eigen::MatrixXd(solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal());
}

Eigen::MatrixXd factorOf(const ComparedCamera& camera, std::span<const Eigen::Vector2d> pixels,
                         const Eigen::Matrix2d& unit, std::optional<Freed> freed,
                         std::span<const double> weights) {
  const auto n = static_cast<Eigen::Index>(camera.camera->parameters().size());
  if (!camera.covariance) return Eigen::MatrixXd(2 * static_cast<Eigen::Index>(pixels.size()), 0);
  expect(camera.covariance->rows() == n && camera.covariance->cols() == n,
         "the covariance has a row and a column for each of the camera's parameters");
  Eigen::MatrixXd rows =
      alignedJacobians(*camera.camera, pixels, {}, freed, weights).transposed.view().transpose() *
      rootOf(*camera.covariance);
  for (Eigen::Index i = 0; i < rows.rows(); i += 2)
    rows.middleRows<2>(i) = (unit * rows.middleRows<2>(i)).eval();
  return rows;
}

// The difference in standard deviations, in each direction into which the parameters' uncertainty moves it.
struct Wald {
  double sum_of_squares = 0;
  double expected = 0;  // the number of directions, each as far as it counts
};

Wald waldOf(const Eigen::MatrixXd& factor, const Eigen::VectorXd& difference) {
  // A direction that the parameters determine to less than this (RMS over the image) is known to this: the
  // pixels' change is a straight line to first order only.
  constexpr double kFloorPx = 0.005;
  constexpr double kNoDirection = 1e-12;  // of the largest variance
  const SymmetricEigen solver(factor.transpose() * factor);
  const double floor = 0.5 * static_cast<double>(factor.rows()) * kFloorPx * kFloorPx;
  Wald result;
  for (Eigen::Index i = 0; i < factor.cols(); ++i) {
    const double variance = solver.eigenvalues()(i);
    if (!(variance > kNoDirection * solver.eigenvalues()(factor.cols() - 1))) continue;
    const Eigen::VectorXd moved = factor * solver.eigenvectors().col(i);
    const double along = moved.dot(difference);
    result.sum_of_squares += along * along / variance / (variance + floor);
    result.expected += variance / (variance + floor);
  }
  return result;
}

}  // namespace

Eigen::MatrixXd differenceFactor(const ComparedCamera& a, const ComparedCamera& b, const ImageMatch& match,
                                 std::span<const Eigen::Vector2d> pixels, std::optional<Freed> freed,
                                 std::span<const double> weights) {
  std::vector<Eigen::Vector2d> in_b;
  for (const Eigen::Vector2d& pixel : pixels) in_b.push_back(match.inB(pixel));
  const Eigen::MatrixXd by_a = factorOf(a, pixels, match.unit_from_a, freed, weights);
  const Eigen::MatrixXd by_b = factorOf(b, in_b, match.unit_from_b, freed, weights);
  Eigen::MatrixXd factor(by_a.rows(), by_a.cols() + by_b.cols());
  factor << by_a, by_b;
  return factor;
}

bool DifferenceSignificance::isSignificant() const {
  return sigmas > kNormalOneInThousand;
}

std::optional<DifferenceSignificance> significanceOf(const ProjectionDifference& difference,
                                                     const ComparedCamera& a, const ComparedCamera& b,
                                                     std::optional<Freed> freed) {
  if ((!a.covariance && !b.covariance) || difference.num_compared == 0) return std::nullopt;
  std::vector<std::size_t> compared;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<double> weights;
  for (std::size_t i = 0; i < difference.pixels.size(); ++i) {
    if (!difference.difference_px[i].allFinite()) continue;
    compared.push_back(i);
    pixels.push_back(difference.pixels[i]);
    weights.push_back(difference.weights[i]);
  }
  Eigen::MatrixXd factor = differenceFactor(a, b, difference.match, pixels, freed, weights);

  const auto n = static_cast<double>(compared.size());
  DifferenceSignificance result;
  result.std_px.assign(difference.pixels.size(), kUnknown);
  result.expected_rms_px = std::sqrt(factor.squaredNorm() / n);
  Eigen::VectorXd weighted(factor.rows());
  int num_beyond = 0;
  for (std::size_t i = 0; i < compared.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Vector2d& d = difference.difference_px[compared[i]];
    const Eigen::Matrix2d covariance = factor.middleRows<2>(row) * factor.middleRows<2>(row).transpose() +
                                       kRoundingPx * kRoundingPx * Eigen::Matrix2d::Identity();
    const SymmetricEigen solver(covariance);
    result.std_px[compared[i]] = std::sqrt(solver.eigenvalues()(1));
    constexpr double kEllipse95 = 5.991464547107979;  // of two normal variables' squares
    const Eigen::Vector2d along = solver.eigenvectors().transpose() * d;
    num_beyond += along.cwiseAbs2().cwiseQuotient(solver.eigenvalues()).sum() > kEllipse95 ? 1 : 0;
    const double root = std::sqrt(weights[i]);
    factor.middleRows<2>(row) *= root;
    weighted.segment<2>(row) = root * d;
  }
  result.share_beyond = num_beyond / n;
  const Wald wald = waldOf(factor, weighted);
  const double m = std::max(1.0, wald.expected);
  result.sigmas = normalOfMeanSquare(wald.sum_of_squares / m, m);
  const double limit = m * meanSquareOfNormal(kNormalOneInThousand, m);
  if (wald.sum_of_squares > limit)
    result.sure_p95_px = (1 - std::sqrt(limit / wald.sum_of_squares)) * difference.p95_px;
  return result;
}

bool isComparable(const ProjectionDifference& difference) {
  // Domains of different models end at slightly different places where the image circle does.
  constexpr double kMaxShareOfOne = 0.05;
  const double num_seen = difference.num_compared + difference.num_seen_by_one;
  return difference.is_converged && difference.num_compared > 0 &&
         difference.num_seen_by_one <= kMaxShareOfOne * num_seen;
}

Agreement agreementOf(const ProjectionDifference& difference,
                      const std::optional<DifferenceSignificance>& significance, double tolerance_px) {
  if (!isComparable(difference)) return Agreement::kNotComparable;
  if (difference.p95_px <= tolerance_px) return Agreement::kWithin;
  const bool is_sure = !significance || significance->isSignificant();
  return is_sure ? Agreement::kBeyond : Agreement::kUncertain;
}

}  // namespace alidade
