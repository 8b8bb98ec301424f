// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fold_guard.h"
#include "alidade/camera/any_camera.h"

namespace alidade {

/// Prior knowledge of a lens: each parameter is near its initial value (CameraModel::kStartLens; zero for
/// polynomials), independent of the others. Empty: no prior.
struct LensPrior {
  std::vector<double> mean;  ///< N, in storage order
  /// N: ratio of the variance of a coordinate of a corner of weight 1 to that of the parameter, px^2; zero
  /// for parameters without a prior. The prior term in the cost therefore has the unit of the corner terms.
  std::vector<double> precision;

  [[nodiscard]] bool isNone() const { return precision.empty(); }
  /// Half the sum of squares, like the cost of the solver.
  [[nodiscard]] double cost(std::span<const double> params) const;
  /// Adds the prior to an information matrix and a gradient, in which the rows from `first` on are the
  /// parameters.
  void addTo(std::span<const double> params, Eigen::MatrixXd& information, Eigen::VectorXd& gradient,
             Eigen::Index first = 0) const;
};

/// Units of the lens parameters: a change by one unit moves some ray of the image by half the image
/// diagonal. No real lens has a parameter of many units. The rays are those of the initial guess. Zero for
/// fx fy cx cy.
struct LensScale {
  std::vector<double> mean;  ///< the initial values, with matching fx and fy
  std::vector<double> size;

  /// The prior with a standard deviation of `width` units for each parameter.
  /// @param variance  of a coordinate of a corner of weight 1, px^2
  [[nodiscard]] LensPrior prior(double width, double variance) const;
  /// Distance of parameter i from its initial value, in units; 0 for fx fy cx cy.
  [[nodiscard]] double distance(std::span<const double> params, std::size_t i) const;
};

/// No real lens has a parameter of more units: the solver diverged along a valley in which other parameters
/// compensate for it. There, even undetermined parameters seem to be determined.
inline constexpr double kRunawaySizes = 10;

/// The prior knowledge that regularises a lens, if there is any; see regularised().
struct WeakPrior {
  FoldGuard guard = {};
  double width = 0;      ///< standard deviation in units; 0 without a prior
  LensPrior prior = {};  ///< empty: the views determine the lens, or no prior could help
  LensScale scale = {};
  std::vector<double> free_params = {};  ///< the solution without the prior
  std::vector<int> least_known = {};     ///< the parameters that the views determine least

  [[nodiscard]] bool isNone() const { return prior.isNone(); }  ///< a guard has no preferred values
};

/// @param like  a camera of any model with the focal length of the image
[[nodiscard]] LensScale lensScale(std::string_view model_id, const AnyCamera& like, ImageSize size);

}  // namespace alidade
