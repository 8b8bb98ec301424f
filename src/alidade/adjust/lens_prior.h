// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"

namespace alidade {

/// What is assumed about a lens before any view: each of its parameters lies about that of the model's start
/// (CameraModel::kStartLens; for polynomials zero), independent of the others. Empty: nothing.
struct LensPrior {
  std::vector<double> mean;  ///< N, in storage order
  /// N: variance of a coordinate of a corner of weight 1 over that of the parameter, px^2; zero for those of
  /// which nothing is known. So the prior's term in the cost counts like that of corners.
  std::vector<double> precision;

  [[nodiscard]] bool isNone() const { return precision.empty(); }
  /// Half the sum of squares, as the solver counts it.
  [[nodiscard]] double cost(std::span<const double> params) const;
  /// Adds the prior to an information and a gradient of which the parameters are the first rows.
  void addTo(std::span<const double> params, Eigen::MatrixXd& information, Eigen::VectorXd& gradient) const;
};

/// Natural sizes of a lens' parameters: a change by one of them moves some ray of the image by half the
/// image's diagonal, so that a lens of which one is much larger is no lens that anybody makes. The rays are
/// those of the model's start. Zero for fx fy cx cy.
struct LensScale {
  std::vector<double> mean;  ///< the model's start, with fx and fy to go with it
  std::vector<double> size;

  /// The prior by which each parameter has a standard deviation of `width` of its natural sizes.
  /// @param variance  of a coordinate of a corner of weight 1, px^2
  [[nodiscard]] LensPrior prior(double width, double variance) const;
  /// Distance of parameter i from the model's start, in natural sizes; 0 for fx fy cx cy.
  [[nodiscard]] double distance(std::span<const double> params, std::size_t i) const;
};

/// A parameter of more natural sizes is no lens: the solver went along a valley in which others make up for
/// it, to where the views seem to tell even what they do not.
inline constexpr double kRunawaySizes = 10;

/// The prior that holds a lens together, if one does; see regularised().
struct WeakPrior {
  double width = 0;      ///< one standard deviation in natural sizes; 0 without a prior
  LensPrior prior = {};  ///< none: the views determine the lens, or no prior could help
  LensScale scale = {};
  std::vector<double> free_params = {};  ///< where the solver went without the prior
  std::vector<int> least_known = {};     ///< parameters that take most part in what the views do not see

  [[nodiscard]] bool isNone() const { return prior.isNone(); }
};

/// @param like  a camera of any model with the focal length that the image has
[[nodiscard]] LensScale lensScale(std::string_view model_id, const AnyCamera& like, ImageSize size);

}  // namespace alidade
