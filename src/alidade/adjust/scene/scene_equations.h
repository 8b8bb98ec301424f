// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/scene/scene_fit.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// The normal equations of the camera's parameters and the readout, with poses and points eliminated, at a
/// solved scene. Unknowns: the parameters in storage order, then the readout.
struct SceneEquations {
  DenseMatrix information;      ///< E x E
  DenseMatrix point_gradients;  ///< E x points: contribution of each point to the gradient of the cost
  DenseMatrix prior_gradient;   ///< E x 1: contribution of the fields' priors
  /// Covariance of the poses of the frames that are not held, with the camera fixed: 6 per frame, right
  /// perturbation [translation, rotation]. The free scale is held along the frames' displacement from the
  /// first frame.
  DenseMatrix pose_covariance;
  double cost = 0;            ///< half the sum of rho, plus half of the fields' priors
  double field_square = 0;    ///< sum of squares of the fields' coefficients, px^2
  double field_variance = 0;  ///< trace of their covariance, for errors with the standard deviation sigma_px
  double num_redundant = 0;   ///< coordinates minus unknowns of points and poses
};

/// @pre every sighting projects
[[nodiscard]] SceneEquations sceneEquations(const SceneFit& fit);

/// The error that each sighting would have if its point were estimated without it, px, to first order, with
/// fixed poses; NaN if the other sightings do not determine the point.
[[nodiscard]] std::vector<Eigen::Vector2d> heldOutErrors(const SceneFit& fit);

/// Three directions orthogonal to a homogeneous point, along which it can move.
[[nodiscard]] Eigen::Matrix<double, 4, 3> pointTangent(const Eigen::Vector4d& point);

}  // namespace alidade
