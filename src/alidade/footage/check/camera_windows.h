// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/core/cancel.h"
#include "alidade/footage/follow/tracks.h"
#include "alidade/footage/map/reconstruction.h"

namespace alidade {

/// Whether a frame shows something new: points moved by 4 % of the width since the last one that did, or half
/// of them are new. Photographs always do.
/// @param kept  the frames so far that did
[[nodiscard]] bool isKeyframe(const FootageTracks& kept, const std::vector<TrackPixel>& frame);

/// Keyframes in groups that are reconstructed together. Photographs are one group.
/// @param tracks  of keyframes
/// @param most  groups; of more, so many are taken evenly
[[nodiscard]] std::vector<std::vector<std::size_t>> chooseWindows(const FootageTracks& tracks,
                                                                  std::size_t most);

/// Reconstructs groups of frames; what is left of a group of photographs becomes further windows.
struct FootageWindows {
  std::vector<Reconstruction> windows;      ///< with fits
  std::vector<Reconstruction> without_fit;  ///< why others failed
};
[[nodiscard]] FootageWindows reconstructAll(const AnyCamera& camera, const FootageTracks& tracks,
                                            const ReconstructionOptions& options, int num_jobs);

/// A camera that was changed in some directions of its parameters to fit footage better.
struct FreedCamera {
  AnyCamera camera;
  Eigen::VectorXd amounts;  ///< steps along the directions
  double cost = 0;          ///< of the pixels, in units of their noise, with the error fields' priors
  /// Of the parameters in storage order, then the readout; zero across the directions. The points of a scene
  /// are taken as independent, the pixels of one point are not; where windows differ by more than this
  /// explains, it is larger by that.
  DenseMatrix covariance;
  DenseMatrix amount_covariance;
  double readout = 0;       ///< see SceneFit::readout
  double dispersion = 1;    ///< variance over that of independent pixels, mean over the directions
  double disagreement = 1;  ///< of the windows: variance of their gradients over the expected
  bool is_converged = false;
};

struct FreeingOptions {
  /// Standard deviation, px, RMS over the pixels of the footage, of the change that is thought possible
  /// before any footage is seen: what footage does not determine then stays as it is.
  double prior_px = 20;
  int num_jobs = 0;
  const CancelFlag* cancel = nullptr;
};

/// Fits cameras to windows of footage. Poses, points, error fields and (for videos) the readout are free
/// throughout.
class CameraFreeing {
 public:
  /// Solves all windows at the camera that is given, and once more with all parameters free, by which the
  /// noise and the error fields' size are estimated.
  /// @param windows  reconstructed, with fits; one or more
  CameraFreeing(const AnyCamera& given, std::vector<Reconstruction> windows, const FootageTracks& tracks,
                const FreeingOptions& options);
  ~CameraFreeing();

  /// Whether the given camera could be evaluated; without, there are no results.
  [[nodiscard]] bool isUsable() const { return is_usable_; }
  /// The given camera, with the readout freed.
  [[nodiscard]] std::optional<FreedCamera> given() const;
  /// The best camera with all parameters freed; nothing if none was found.
  [[nodiscard]] std::optional<FreedCamera> all() const;
  /// The best camera among those that differ from the given one along directions.
  /// @param directions  of the parameters in storage order, one a column
  [[nodiscard]] std::optional<FreedCamera> along(const Eigen::MatrixXd& directions) const;
  /// The same by the normal equations at the given camera alone, at no cost: exact for small changes.
  [[nodiscard]] std::optional<FreedCamera> predictedAlong(const Eigen::MatrixXd& directions) const;

  /// As solved at the given camera.
  [[nodiscard]] const std::vector<Reconstruction>& windows() const;
  [[nodiscard]] double noisePx() const;  ///< of a coordinate
  [[nodiscard]] double fieldPx() const { return field_px_; }

 private:
  struct Sums;
  struct State;

  [[nodiscard]] bool solveAt(State& state, const Eigen::VectorXd& at) const;
  [[nodiscard]] Sums sumsAt(const State& state) const;
  bool minimise(State& state, const Eigen::MatrixXd& directions, int max_steps) const;
  [[nodiscard]] std::optional<FreedCamera> freedAt(const Eigen::VectorXd& at, const Sums& sums,
                                                   const Eigen::MatrixXd& directions,
                                                   bool is_converged) const;
  [[nodiscard]] double priorCost(const Eigen::VectorXd& at) const;
  void setNoise();
  void setPrior();
  void setField(State& state, double field_px) const;

  AnyCamera given_;
  std::vector<Reconstruction> windows_;
  FreeingOptions options_;
  bool is_video_ = false;
  Eigen::VectorXd start_;  // parameters, then the readout
  Eigen::Index num_ = 0;
  double noise_ = 1;  // in units of the pixels' sigma
  double field_px_ = 0;
  Eigen::MatrixXd prior_;
  bool is_usable_ = false;
  bool is_all_found_ = false;
  std::unique_ptr<State> at_given_;
  std::unique_ptr<State> at_all_;
};

}  // namespace alidade
