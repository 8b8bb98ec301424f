// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "alidade/detect/corner/edge_pixels.h"

namespace alidade {

/// The image of a disc: with the signed distance d of a pixel to an ellipse, to first order (Sampson 1982,
/// Fitting conic sections to very scattered data), its grey level is
///
///   (1 + sx X + sy Y) (a + b erf(d / (sqrt2 s)))
///
/// The rim is where (x - c)^T S (x - c) = 1. The caller chooses the unit of lengths and the origin of
/// positions.
struct DiscModel {
  enum Parameter : std::size_t {
    kX,
    kY,
    kShapeXX,
    kShapeXY,
    kShapeYY,
    kBlur,           ///< s
    kMean,           ///< a
    kAmplitude,      ///< b
    kShadeX,         ///< sx
    kShadeY,         ///< sy
    kNumParameters,  ///< their number
  };
  using Vector = Eigen::Matrix<double, kNumParameters, 1>;

  Vector values = Vector::Zero();

  [[nodiscard]] double operator[](Parameter i) const { return values[static_cast<Eigen::Index>(i)]; }
  [[nodiscard]] double& operator[](Parameter i) { return values[static_cast<Eigen::Index>(i)]; }

  [[nodiscard]] Eigen::Vector2d centre() const { return values.head<2>(); }
  [[nodiscard]] Eigen::Matrix2d shape() const {
    return Eigen::Matrix2d{{values[kShapeXX], values[kShapeXY]}, {values[kShapeXY], values[kShapeYY]}};
  }
  [[nodiscard]] bool isEllipse() const {
    return values[kShapeXX] > 0 && shape().determinant() > 0 && values[kBlur] > 0;
  }
  /// Signed distance of a place to the rim, outwards; NaN at the centre.
  [[nodiscard]] double distance(const Eigen::Vector2d& at) const {
    const Eigen::Vector2d offset = at - centre();
    const Eigen::Vector2d normal = shape() * offset;
    const double square = offset.dot(normal);
    return (square - std::sqrt(square)) / normal.norm();
  }
};
using DiscSums = NormalEquations<DiscModel::kNumParameters>;

/// Values of each pixel after a fit.
struct DiscResiduals {
  std::vector<float> residual;  ///< observed - modelled, grey levels
  std::vector<float> slope;     ///< derivative of the modelled grey level by the distance
  std::vector<float> pattern;   ///< -1 inside, 1 outside
};

/// The accuracy is that of sumNormalEquations() for EdgeModel.
void sumNormalEquations(const EdgePixels& pixels, const DiscModel& model, DiscSums& sums);

/// Fills columns of at least pixels.size() values.
void evaluateResiduals(const EdgePixels& pixels, const DiscModel& model, DiscResiduals& residuals);

}  // namespace alidade
