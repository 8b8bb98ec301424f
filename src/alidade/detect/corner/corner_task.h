// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include <Eigen/Core>

#include "alidade/core/image.h"
#include "alidade/detect/corner/edge_model.h"

namespace alidade {

/// Positive if b is clockwise from a in the image.
[[nodiscard]] inline double crossProduct(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Approximate position and surroundings of a corner before refinement. Pixels; (0, 0) is the centre of the
/// top left pixel.
struct CornerGuess {
  Eigen::Vector2d pixel;  ///< within about a fifth of the spacing of the corner
  Eigen::Vector2d
      step_u;  ///< to the next corner along the board's columns: the mean of both sides if both exist
  Eigen::Vector2d step_v;  ///< the same along its rows
  /// True if no corner follows along +u, +v, -u, -v: there, the board's border may cut the squares.
  std::array<bool, 4> is_outermost{};
  /// Distance from both lines in which the squares are plain, as a share of the steps; markers may lie
  /// beyond.
  double clear_share = 1;
};

/// A refined corner: the crossing of two edges (EdgeModel) or, if there are too few pixels, the saddle of the
/// grey levels.
struct CornerFit {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;  ///< px^2
  double sigma_px = 0;         ///< one standard deviation per axis: sqrt(trace(covariance) / 2)
  double blur_px = 0;          ///< one standard deviation of the edges' blur, including the pixel's own width
  /// Grey levels between the bright and the dark squares at the corner: > 0 if the square between step_u and
  /// step_v is dark, < 0 if it is bright.
  double contrast = 0;
  double window = 0;  ///< half size of the window, as a share of the steps
};

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

/// Constants of the refinement of one corner.
struct CornerTask {
  const GrayImage& image;
  const CornerGuess& guess;
  Eigen::Vector2i origin;           // origin of positions in models and EdgePixels
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
  /// Takes every `stride`-th pixel of the window, in both directions, that is in the image.
  void gatherLattice(const EdgeWindow& window, int stride, EdgePixels& pixels) const;
  /// Takes the pixels of the window that lie within `blur_reach` blurs + 0.5 px of one of the model's lines.
  /// Line 0 runs along step_u, line 1 along step_v.
  void gatherBands(const EdgeWindow& window, const EdgeModel& model, double blur_reach,
                   const std::array<double, 2>& most_px, EdgePixels& pixels) const;
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

/// The corner as the saddle of the grey levels near `start`, px of the image: for squares too small, or too
/// blurred, for the edge model. Nothing if there is no saddle with the contrast of four squares.
[[nodiscard]] std::optional<CornerFit> fitSaddleCorner(const CornerTask& task, const Eigen::Vector2d& start);

}  // namespace alidade
