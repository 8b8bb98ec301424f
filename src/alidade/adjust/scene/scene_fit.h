// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/fit.h"
#include "alidade/adjust/board/solve.h"
#include "alidade/camera/any_camera.h"
#include "alidade/core/image.h"
#include "alidade/geometry/dense_matrix.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// A scene point in one image.
struct SceneSighting {
  std::uint32_t frame = 0;  ///< index into SceneFit::camera_from_world
  std::uint32_t point = 0;  ///< index into SceneFit::points
  Eigen::Vector2d pixel{0, 0};
  double sigma_px = 1;  ///< standard deviation of each coordinate, positive
  /// Change of the pixel per unit of SceneFit::readout: its velocity in px per frame, times its row's
  /// distance from the middle row as a share of the height.
  Eigen::Vector2d readout_px{0, 0};
};

/// Position errors shared by the points of one image, smooth over the image: for each coordinate a polynomial
/// of degree 3 in the pixel, scaled to -1 to 1 over the image. The first ten numbers are those of x, in px: 1
/// x y xx xy yy xxx xxy xyy yyy.
struct ErrorField {
  static constexpr int kTerms = 10;
  static constexpr int kSize = 2 * kTerms;
  using Basis = Eigen::Matrix<double, kTerms, 1>;
  using Coefficients = Eigen::Matrix<double, kSize, 1>;

  [[nodiscard]] static Basis basisAt(const Eigen::Vector2d& pixel, const ImageSize& size);
  /// The displacement, px.
  [[nodiscard]] static Eigen::Vector2d at(const Basis& basis, const Coefficients& field) {
    return {field.head<kTerms>().dot(basis), field.tail<kTerms>().dot(basis)};
  }
};

/// Images of a rigid scene of unknown points by one moving camera. World and points have no known scale.
struct SceneFit {
  AnyCamera camera;
  std::vector<SE3> camera_from_world;
  /// Homogeneous, of length 1: (x, y, z, w) is the point (x, y, z) / w, at infinity for w = 0.
  std::vector<Eigen::Vector4d> points;
  std::vector<SceneSighting> sightings;  ///< sorted by point, those of a point by frame
  std::size_t num_held_frames = 1;       ///< number of first frames whose poses are held; at least one
  /// Time from the exposure of the first row to that of the last, in frames: a rolling shutter.
  double readout = 0;
  HuberLoss loss = kNoLoss;  ///< of errors in units of sigma_px
  ImageSize size = {};
  /// Standard deviation of the coefficients of each image's error field, px; 0: there are none.
  double field_px = 0;
  std::vector<ErrorField::Coefficients> fields = {};  ///< one per frame if field_px is above 0
  SolveSummary summary = {};
};

/// A homogeneous point in the camera's frame, and its derivatives by the pose (right perturbation) and the
/// point.
struct PointInCamera {
  Eigen::Vector3d at;
  Eigen::Matrix<double, 3, 6> J_pose;
  Eigen::Matrix<double, 3, 4> J_point;
};
[[nodiscard]] PointInCamera inCamera(const SE3& camera_from_world, const Eigen::Vector4d& point);

/// Projection of a sighting's point by the camera of a fit, and the derivatives.
struct SceneProjection {
  bool ok = false;
  Eigen::Vector2d error{0, 0};  ///< projected minus observed, px
  Eigen::Matrix<double, 2, 6> J_pose;
  Eigen::Matrix<double, 2, 4> J_point;
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 24> J_params;
  ErrorField::Basis field;  ///< derivatives by each coordinate's coefficients
};
/// @param wants_params  sets J_params
[[nodiscard]] SceneProjection projectSighting(const SceneFit& fit, const SceneSighting& sighting,
                                              bool wants_params = true);

/// The error of a sighting, px; NaN if the point has no pixel.
[[nodiscard]] Eigen::Vector2d sightingError(const SceneFit& fit, const SceneSighting& sighting);

/// Minimises the robust reprojection error over poses, points and error fields; the camera is fixed. A
/// sighting that cannot be projected at the start is a failure (Termination::kFailed).
/// @throws Cancelled
[[nodiscard]] SceneFit solveScene(SceneFit fit, const SolveOptions& options = {});

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
  /// Change of the optimum per unit of each unknown: 6 rows per frame that is not held, right perturbation,
  /// then the coefficients of each frame's error field.
  DenseMatrix J_optimum_camera;
  double cost = 0;            ///< half the sum of rho, plus half of the fields' priors
  double field_square = 0;    ///< sum of squares of the fields' coefficients, px^2
  double field_variance = 0;  ///< trace of their covariance, for errors with the standard deviation sigma_px
  double num_redundant = 0;   ///< coordinates minus unknowns of points and poses
};

/// @pre every sighting projects
[[nodiscard]] SceneEquations sceneEquations(const SceneFit& fit);

/// Changes the camera's unknowns of a solved scene by `delta` and moves poses, points and fields along with
/// them, to first order: the start of the next solve. A sighting may have no pixel afterwards.
/// @param J_optimum_camera  as in SceneEquations
/// @param camera            with the changed parameters
void followCamera(SceneFit& fit, const Eigen::MatrixXd& J_optimum_camera, const AnyCamera& camera,
                  const Eigen::VectorXd& delta);

/// The cost that solveScene() minimises; infinite if a sighting has no pixel.
[[nodiscard]] double sceneCost(const SceneFit& fit);

/// The error that each sighting would have if its point were estimated without it, px, to first order, with
/// fixed poses; NaN if the other sightings do not determine the point.
[[nodiscard]] std::vector<Eigen::Vector2d> heldOutErrors(const SceneFit& fit);

/// Three directions orthogonal to a homogeneous point, along which it can move.
[[nodiscard]] Eigen::Matrix<double, 4, 3> pointTangent(const Eigen::Vector4d& point);

}  // namespace alidade
