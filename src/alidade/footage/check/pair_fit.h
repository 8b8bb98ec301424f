// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/camera/camera_change.h"
#include "alidade/core/cancel.h"
#include "alidade/footage/geometry/two_view.h"
#include "alidade/geometry/se3.h"

namespace alidade {

/// Two cameras and the pose of the second one. The translation has length 1.
struct PosedPair {
  AnyCamera first;
  AnyCamera second;
  SE3 second_from_first;
};

/// A match of two cameras at one of several instants.
struct TimedMatch {
  PixelMatch pixels;
  std::size_t instant = 0;
};

/// Signed Sampson error of each match, px; NaN if a pixel has no ray.
[[nodiscard]] std::vector<double> sampsonErrors(const PosedPair& pair, std::span<const TimedMatch> matches);

/// The camera of a pair that a change affects.
enum class PairSide : std::uint8_t { kFirst, kSecond, kBoth };

/// A group of unknowns that is freed together.
struct PairFreedom {
  struct Part {
    CameraChangeKind kind;
    PairSide side;
  };
  CameraChangeKind kind = CameraChangeKind::kSeveral;
  PairSide side = PairSide::kBoth;
  std::vector<Part> parts;  ///< their amounts are concatenated
  Eigen::VectorXd prior;    ///< standard deviation of each amount before seeing images

  [[nodiscard]] Eigen::Index size() const { return prior.size(); }
};

/// The groups that can be freed for two cameras, the most common causes first.
/// @param widths  of the images of both cameras, px
[[nodiscard]] std::vector<PairFreedom> pairFreedoms(const PosedPair& pair, std::array<int, 2> widths);

/// The pair after a change; nothing if a parameter leaves its range.
[[nodiscard]] std::optional<PosedPair> changedPair(const PosedPair& pair, const PairFreedom& freedom,
                                                   const Eigen::VectorXd& amounts);

/// Displacement of a point in the second camera by a change, px: from the epipolar curve of its first pixel,
/// and in x and y; with derivatives by the amounts. Linear in small amounts.
struct PairShift {
  Eigen::Vector3d across_x_y{0, 0, 0};
  Eigen::Matrix<double, 3, Eigen::Dynamic> J;
};
/// @param seen  stated pixels of each point, which lies on the ray of the first pixel
/// @param distance  of the points from the first camera, in baselines
/// @returns one per point; nothing if it has no ray or pixel after the change
[[nodiscard]] std::vector<std::optional<PairShift>> shiftsBy(const PosedPair& pair,
                                                             const PairFreedom& freedom,
                                                             const Eigen::VectorXd& amounts,
                                                             std::span<const PixelMatch> seen,
                                                             double distance);

/// Minimises the robust sum of the matches' squared errors over a group of unknowns.
struct PairFit {
  Eigen::VectorXd amounts;
  Eigen::MatrixXd covariance;
  double cost = 0;          ///< of the errors, in units of their noise
  double prior_cost = 0;    ///< of the amounts, likewise
  double dispersion = 1;    ///< variance over that for independent matches, mean over the unknowns
  double disagreement = 1;  ///< of the instants: variance of their gradients over the expected
  bool is_converged = false;
  /// One per match, 0 to 1: 1 if it alone determines an unknown.
  std::vector<double> leverages = {};
};
/// @param noise  of the errors, in units of sigma_px
/// @param start  amounts at which the pair is valid
[[nodiscard]] PairFit fitPair(const PosedPair& pair, const PairFreedom& freedom,
                              std::span<const TimedMatch> matches, const Eigen::VectorXd& start, double noise,
                              int max_steps = 30, const CancelFlag* cancel = nullptr);

/// The robust sum without a change; half the squares for small errors.
[[nodiscard]] double costOf(const PosedPair& pair, std::span<const TimedMatch> matches, double noise);

}  // namespace alidade
