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

/// Two cameras and where the second one is. The translation has length 1.
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

/// Signed Sampson error of each match, px; NaN where a pixel has no ray.
[[nodiscard]] std::vector<double> sampsonErrors(const PosedPair& pair, std::span<const TimedMatch> matches);

/// The camera of a pair that changes.
enum class PairSide : std::uint8_t { kFirst, kSecond, kBoth };

/// A group of unknowns that is freed at a time.
struct PairFreedom {
  struct Part {
    CameraChangeKind kind;
    PairSide side;
  };
  CameraChangeKind kind = CameraChangeKind::kSeveral;
  PairSide side = PairSide::kBoth;
  std::vector<Part> parts;  ///< their amounts follow one another
  Eigen::VectorXd prior;    ///< standard deviation of each amount before any image is seen

  [[nodiscard]] Eigen::Index size() const { return prior.size(); }
};

/// The groups that can be freed for two cameras. Those that are the most usual causes come first.
/// @param widths  of the images of both cameras, px
[[nodiscard]] std::vector<PairFreedom> pairFreedoms(const PosedPair& pair, std::array<int, 2> widths);

/// The pair after a change; nothing for parameters out of their range.
[[nodiscard]] std::optional<PosedPair> changedPair(const PosedPair& pair, const PairFreedom& freedom,
                                                   const Eigen::VectorXd& amounts);

/// Displacement of a point by a change, seen from the second camera, px: from the epipolar curve of its
/// first pixel, and in x and y; with the derivatives by the amounts. Linear in small amounts.
struct PairShift {
  Eigen::Vector3d across_x_y{0, 0, 0};
  Eigen::Matrix<double, 3, Eigen::Dynamic> J;
};
/// @param seen  pixels of each point as stated; it is on the ray of the first pixel
/// @param distance  of the points from the first camera, in baselines
/// @returns for each point; nothing for those that have no ray or pixel after the change
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
  double dispersion = 1;    ///< variance over that of independent matches, mean over the unknowns
  double disagreement = 1;  ///< of the instants: variance of their gradients over the expected
  bool is_converged = false;
  /// One per match, 0 to 1: 1 if it alone determines an unknown.
  std::vector<double> leverages = {};
};
/// @param noise  of the errors, in units of sigma_px
/// @param start  amounts with which the pair exists
[[nodiscard]] PairFit fitPair(const PosedPair& pair, const PairFreedom& freedom,
                              std::span<const TimedMatch> matches, const Eigen::VectorXd& start, double noise,
                              int max_steps = 30, const CancelFlag* cancel = nullptr);

/// The robust sum without a change, half of squares for small errors.
[[nodiscard]] double costOf(const PosedPair& pair, std::span<const TimedMatch> matches, double noise);

}  // namespace alidade
