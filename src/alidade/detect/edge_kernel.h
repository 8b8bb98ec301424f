// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/detect/edge_model.h"

namespace alidade {

/// Pixels that enter a fit, as columns for the vector unit.
class EdgePixels {
 public:
  void clear() { size_ = 0; }
  void push(float x, float y, float grey) {
    if (size_ == x_.size()) grow();
    x_[size_] = x;
    y_[size_] = y;
    grey_[size_++] = grey;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Positions relative to the model's origin, and grey levels. The columns hold more than size() values: so
  /// many that the vector unit may read whole chunks.
  [[nodiscard]] const float* x() const { return x_.data(); }
  [[nodiscard]] const float* y() const { return y_.data(); }
  [[nodiscard]] const float* grey() const { return grey_.data(); }

 private:
  void grow();

  std::vector<float> x_;
  std::vector<float> y_;
  std::vector<float> grey_;
  std::size_t size_ = 0;
};

/// Sums over the pixels: hessian = J^T J, gradient = J^T r and cost = r^T r, where r = observed - modelled
/// grey level and J is the modelled one's derivative by the parameters.
struct NormalEquations {
  static constexpr int kSize = EdgeModel::kNumParameters;
  Eigen::Matrix<double, kSize, kSize> hessian;
  Eigen::Matrix<double, kSize, 1> gradient;
  double cost = 0;
};

/// What remains of each pixel after a fit.
struct EdgeResiduals {
  std::vector<float> residual;  ///< observed - modelled, grey levels
  std::vector<float> slope1;    ///< derivative of the modelled grey level by d1, 1/px
  std::vector<float> slope2;    ///< by d2
  std::vector<float> pattern;   ///< E
};

/// Single precision per pixel: erf to 1.5e-7 (Abramowitz and Stegun 1964, 7.1.26), sums to about 1e-6 of
/// themselves. The same numbers on every thread; between processors with and without AVX2 they may differ by
/// rounding.
void sumNormalEquations(const EdgePixels& pixels, const EdgeModel& model, NormalEquations& sums);

/// Fills columns of at least pixels.size() values.
void evaluateResiduals(const EdgePixels& pixels, const EdgeModel& model, EdgeResiduals& residuals);

}  // namespace alidade
