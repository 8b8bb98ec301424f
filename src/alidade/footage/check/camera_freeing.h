// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/footage/map/reconstruction.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// A camera changed in some directions of its parameters to fit footage better.
struct FreedCamera {
  AnyCamera camera;
  Eigen::VectorXd amounts;  ///< steps along the directions
  double cost = 0;          ///< of the pixels, in units of their noise, with the error fields' priors
  /// Covariance of the parameters in storage order, then the readout; zero across the directions. The points
  /// of a scene count as independent, but not the pixels of one point; if windows differ by more than this
  /// explains, the covariance is scaled up accordingly.
  DenseMatrix covariance;
  DenseMatrix amount_covariance;
  double readout = 0;       ///< see SceneFit::readout
  double dispersion = 1;    ///< variance over that for independent pixels, mean over the directions
  double disagreement = 1;  ///< of the windows: variance of their gradients over the expected
  bool is_converged = false;
};

/// Fits cameras to windows of footage. Poses, points, error fields and (for videos) the readout are free
/// throughout.
class CameraFreeing {
 public:
  /// Solves all windows with the given camera, and once more with all parameters free to estimate the noise
  /// and the size of the error fields.
  /// @param windows  reconstructed, with fits; at least one
  CameraFreeing(const AnyCamera& given, std::vector<Reconstruction> windows, const FootageTracks& tracks,
                int num_jobs, const CancelFlag* cancel);

  /// The given camera, with the readout freed. Here and below: nothing if it could not be evaluated.
  [[nodiscard]] std::optional<FreedCamera> given() const;
  /// The best camera with all parameters freed; nothing if none was found.
  [[nodiscard]] std::optional<FreedCamera> all() const;
  /// The best camera among those that differ from the given one along directions.
  /// @param directions  of the parameters in storage order, one per column
  [[nodiscard]] std::optional<FreedCamera> along(const Eigen::MatrixXd& directions) const;
  /// Prediction of along() from the normal equations at the given camera, at no cost: exact for small
  /// changes.
  [[nodiscard]] std::optional<FreedCamera> predictedAlong(const Eigen::MatrixXd& directions) const;

  /// Windows as solved with the given camera.
  [[nodiscard]] const std::vector<Reconstruction>& windows() const {
    return at_given_ ? at_given_->windows : windows_;
  }
  [[nodiscard]] double noisePx() const;  ///< of a coordinate

 private:
  // The windows' sums at one camera.
  struct Sums {
    double cost = 0;  // of the pixels, in units of their noise
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    Eigen::MatrixXd scatter;                        // by points
    std::vector<Eigen::VectorXd> window_gradients;  // one per window, for their scatter
    std::vector<Eigen::MatrixXd> window_scatters;
    std::vector<Eigen::MatrixXd> window_informations;
    std::vector<Eigen::MatrixXd> window_responses;  // see SceneEquations::J_optimum_camera
    std::size_t num_points = 0;
    double field_square = 0;  // expected, px^2, for this many coefficients
    double num_coefficients = 0;
  };
  // The windows, solved at a camera.
  struct State {
    std::vector<Reconstruction> windows;
    Eigen::VectorXd at;
    Sums sums;
  };

  [[nodiscard]] State unsolved() const;
  [[nodiscard]] double follow(State& state, const Eigen::VectorXd& at) const;
  [[nodiscard]] bool settle(State& state) const;
  [[nodiscard]] Sums sumsOf(const std::vector<Reconstruction>& windows) const;
  [[nodiscard]] std::optional<AnyCamera> cameraAt(const Eigen::VectorXd& at) const;
  bool solve(State& state, const Eigen::MatrixXd& directions, int max_steps) const;
  [[nodiscard]] std::optional<FreedCamera> freedAt(const Eigen::VectorXd& at, const Sums& sums,
                                                   const Eigen::MatrixXd& directions,
                                                   bool is_converged) const;
  [[nodiscard]] double priorCost(const Eigen::VectorXd& at) const;
  void setNoise();
  void setPrior();
  void setField(State& state) const;

  AnyCamera given_;
  std::vector<Reconstruction> windows_;
  int num_jobs_;
  const CancelFlag* cancel_;
  bool is_video_ = false;
  Eigen::VectorXd start_;  // parameters, then the readout
  Eigen::Index num_ = 0;
  double noise_ = 1;  // in units of the pixels' sigma
  double field_px_ = 0;
  Eigen::MatrixXd prior_;
  bool is_usable_ = false;         // at_given_ is at the optimum
  std::optional<State> at_given_;  // nothing if it could not be evaluated
  std::optional<State> at_all_;    // nothing if no optimum was found
};

}  // namespace alidade
