// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>

namespace alidade {

/// Pixels that enter a fit, as columns for vector instructions.
class EdgePixels {
 public:
  /// Columns are whole chunks of this many pixels; their derivatives stay in the L1 cache.
  static constexpr std::size_t kChunk = 128;

  void clear() { size_ = 0; }
  void push(float x, float y, float grey) {
    if (size_ == x_.size()) grow();
    x_[size_] = x;
    y_[size_] = y;
    grey_[size_++] = grey;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Positions relative to the model's origin, and grey levels. The columns are padded beyond size() values,
  /// so that vector code may read whole chunks.
  [[nodiscard]] const float* x() const { return x_.data(); }
  [[nodiscard]] const float* y() const { return y_.data(); }
  [[nodiscard]] const float* grey() const { return grey_.data(); }

 private:
  void grow() {
    const std::size_t size = x_.empty() ? 8 * kChunk : 2 * x_.size();
    for (auto* column : {&x_, &y_, &grey_}) column->resize(size);
  }

  std::vector<float> x_;
  std::vector<float> y_;
  std::vector<float> grey_;
  std::size_t size_ = 0;
};

/// Sums over the pixels: hessian = J^T J, gradient = J^T r and cost = r^T r, where r = observed - modelled
/// grey level and J is the derivative of the modelled level by the parameters.
template <int kSize>
struct NormalEquations {
  using Vector = Eigen::Matrix<double, kSize, 1>;
  using Matrix = Eigen::Matrix<double, kSize, kSize>;
  Matrix hessian = Matrix::Zero();
  Vector gradient = Vector::Zero();
  double cost = 0;

  /// Factors of the unknowns that give the Hessian a diagonal of 1.
  [[nodiscard]] Vector scale() const { return hessian.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse(); }
  /// The step to the minimum, with a damping of the scaled unknowns.
  [[nodiscard]] Vector step(double damping) const {
    const Vector scaled = scale();
    Matrix system = scaled.asDiagonal() * hessian * scaled.asDiagonal();
    system.diagonal().array() += damping;
    return scaled.cwiseProduct(system.llt().solve(scaled.cwiseProduct(gradient)));
  }
  /// True if a step is shorter than this share of the estimate's standard deviation, judged by the gain that
  /// Gauss-Newton expects.
  [[nodiscard]] bool isShort(const Vector& step, double share, std::size_t num_pixels) const {
    // Images are stored in whole grey levels, so residuals cannot be smaller than rounding.
    constexpr double kLeastVariance = 1.0 / 12;
    const double variance = std::fmax(kLeastVariance, cost / static_cast<double>(num_pixels));
    return step.dot(gradient) <= share * share * variance;
  }
};

}  // namespace alidade
