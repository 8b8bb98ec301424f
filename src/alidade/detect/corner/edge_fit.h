// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "alidade/detect/corner/edge_model.h"

namespace alidade {

/// Prior knowledge of a model's parameters, as terms precision * value^2 added to the sum of squared
/// residuals; precisions are in squared grey levels over the parameter's unit squared.
struct EdgePrior {
  static constexpr double kHeld = 1e12;  ///< a precision that keeps a parameter at 0

  EdgeModel precision;
  double equal_blur = 0;     ///< precision of the difference of the two blurs
  bool common_blur = false;  ///< both lines use the first line's blur
};

struct EdgeSolverOptions {
  /// Edges much sharper than this pass between pixel centres, and the cost has steps. The width of a pixel
  /// alone has a standard deviation of 0.29; sharpened images can show less.
  double min_blur_px = 0.25;
  double max_blur_px = 1e3;
  bool are_angles_held = false;  ///< at those of the start
  int max_iterations = 100;      ///< large residuals, as of sharpened images, need many
  /// Ends when the expected next step is shorter than this share of the estimate's standard deviation.
  double step_share = 0.1;
};

struct EdgeSolution {
  EdgeModel model;
  EdgeSums sums;  ///< at `model`
  bool converged = false;
};

/// Least squares from `start`, with its blurs moved within the bounds, by damped Gauss-Newton steps
/// (Levenberg 1944, Marquardt 1963).
[[nodiscard]] EdgeSolution solveEdgeModel(const EdgePixels& pixels, const EdgeModel& start,
                                          const EdgePrior& prior, const EdgeSolverOptions& options);

/// Sums over the pixels of a short section of an edge, for its offset from the model.
struct EdgeSection {
  double information = 0;  ///< sum of squared slopes
  double score = 0;        ///< sum of slope times residual

  void add(double slope, double residual) {
    information += slope * slope;
    score += slope * residual;
  }
};

/// Regression of the residuals along an edge on its pattern, which is -1 on one side and 1 on the other.
struct EdgeContrast {
  double count = 0, pattern = 0, pattern2 = 0, residual = 0, product = 0;

  void add(double of_pattern, double of_residual) {
    count += 1;
    pattern += of_pattern;
    pattern2 += of_pattern * of_pattern;
    residual += of_residual;
    product += of_pattern * of_residual;
  }
  /// The contrast as a share of the model's; NaN if there are too few pixels, or too few on one side
  /// (`least_variance` of the pattern).
  [[nodiscard]] double share(double amplitude, double least_count, double least_variance) const;
};

/// Quality of a model for the pixels that it was fitted to.
struct EdgeQuality {
  /// Mean square of the residuals, corrected for the number of parameters, squared grey levels.
  double residual_variance = 0;
  /// For lines 0 and 1: the noise variance, in squared grey levels, that explains the scatter of the line's
  /// cross-sections around it; see assessEdgeFit().
  std::array<double, 2> line_variance{};
  /// Mean square of the residuals in the inner and in the outer half of the window.
  double inner_variance = 0;
  double outer_variance = 0;
  /// Contrast on the four arms that leave the corner, as a share of the model's: line 0 forwards and
  /// backwards along its direction, then line 1. NaN if an arm has too few pixels.
  std::array<double, 4> arm_contrast{};
};

/// Cuts each line into short cross-sections, measures the offset of the edge from the model in each, and
/// compares the scatter of these offsets with that of independent pixels. This scatter is the noise that
/// moves the corner. A point spread that differs in shape from the model leaves large residuals, but they
/// balance within each cross-section and move no edge. Correlated residuals, as after JPEG, move it more than
/// their size suggests.
///
///
/// @param reach_px  distance of the farthest pixels from the corner along each line
[[nodiscard]] EdgeQuality assessEdgeFit(const EdgePixels& pixels, const EdgeModel& model,
                                        const EdgeResiduals& residuals,
                                        const std::array<double, 2>& reach_px);

}  // namespace alidade
