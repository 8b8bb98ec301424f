// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/detect/corner/corner_guess.h"
#include "alidade/detect/corner/edge_model.h"

namespace alidade {

/// Largest distance from the guess, as a share of the spacing; a fit that moves further has left the corner.
inline constexpr double kMaxMoveShare = 0.35;
/// Smallest angle between the lines.
inline constexpr double kMinCrossingDeg = 10;
inline constexpr double kMinContrast = 4;  ///< grey levels

/// A window along the board's lines, a parallelogram: center + a u + b v with |a| <= reach_u and |b| <=
/// reach_v, where u and v are the steps to the neighbouring corners. Pixels.
struct EdgeWindow {
  Eigen::Vector2d center;
  Eigen::Vector2d step_u;
  Eigen::Vector2d step_v;
  double reach_u = 0;  ///< as a share of the step
  double reach_v = 0;

  [[nodiscard]] std::array<double, 2> reachPx() const {
    return {reach_u * step_u.norm(), reach_v * step_v.norm()};
  }
  [[nodiscard]] double shorterReach() const { return std::min(reachPx()[0], reachPx()[1]); }
};

/// Takes every `stride`-th pixel of the window, in both directions, that is in the image. Positions count
/// from the pixel `origin`.
void gatherLattice(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                   int stride, EdgePixels& pixels);

/// Takes the pixels of the window that lie within `blur_reach` blurs + 0.5 px of one of the model's lines.
/// Line 0 runs along step_u, line 1 along step_v.
void gatherBands(const GrayImage& image, const EdgeWindow& window, const Eigen::Vector2i& origin,
                 const EdgeModel& model, double blur_reach, const std::array<double, 2>& most_px,
                 EdgePixels& pixels);

/// Constants of the refinement of one corner.
struct CornerTask {
  const GrayImage& image;
  const CornerGuess& guess;
  Eigen::Vector2i origin;
  double spacing = 0;               // length of the shorter step, px
  double crossing_sine = 0;         // sine of the angle between the steps
  std::array<bool, 4> is_cut = {};  // along +u, +v, -u, -v: a margin cuts the squares

  // `share` of a step, or the safe part of it if the squares are cut.
  [[nodiscard]] double shareOnSide(std::size_t side, double share) const {
    constexpr double kCutShare = 0.22;  // the part of a quarter that remains under perspective
    return is_cut[side] ? std::min(share, kCutShare) : share;
  }
  // Extends to `share` of the steps from the corner, or less where the squares are cut, minus the margins.
  [[nodiscard]] EdgeWindow window(const Eigen::Vector2d& corner, double share, double margin_u = 0,
                                  double margin_v = 0) const {
    const double half_u = 0.5 * (shareOnSide(0, share) + shareOnSide(2, share));
    const double half_v = 0.5 * (shareOnSide(1, share) + shareOnSide(3, share));
    const Eigen::Vector2d shift =
        (shareOnSide(0, share) - half_u) * guess.step_u + (shareOnSide(1, share) - half_v) * guess.step_v;
    return {.center = corner + origin.cast<double>() + shift,
            .step_u = guess.step_u,
            .step_v = guess.step_v,
            .reach_u = half_u - margin_u,
            .reach_v = half_v - margin_v};
  }
  // Pixels farther than this from a line may belong to a marker.
  [[nodiscard]] double clearPx(std::size_t line) const {
    return guess.clear_share * (line == 0 ? guess.step_v : guess.step_u).norm() * crossing_sine;
  }
  [[nodiscard]] double distanceFromGuess(const EdgeModel& model) const {
    return (model.corner() + origin.cast<double>() - guess.pixel).norm();
  }
  // Length that a window loses to blurred neighbours, for lines along the steps, as a share of the step.
  [[nodiscard]] double marginShare(double step_px, double blur_px) const {
    // Distance between a window and the edges of the neighbouring squares.
    constexpr double kMarginBlurs = 1.5;
    constexpr double kMarginPx = 0.5;
    return (kMarginBlurs * blur_px + kMarginPx) / (step_px * crossing_sine);
  }
  /// Contrast, as in CornerFit, from one place in each of the four squares; nothing if they do not alternate.
  [[nodiscard]] std::optional<double> contrastOfSquares(const Eigen::Vector2d& corner) const;
  /// True unless one of the four squares has the opposite colour of the fit, for example because an object
  /// covers it or it is not a board. Squares outside the image do not count.
  [[nodiscard]] bool hasColoursOf(const CornerFit& fit) const;
};

/// The result refers to both arguments.
/// @returns nothing if refinement is impossible: numbers that are not finite, squares too small, steps along
/// one line, or a place outside the image
[[nodiscard]] std::optional<CornerTask> makeCornerTask(const GrayImage& image, const CornerGuess& guess);

}  // namespace alidade
