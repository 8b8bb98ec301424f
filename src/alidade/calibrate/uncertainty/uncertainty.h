// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/calibrate/bend/board_bend.h"
#include "alidade/calibrate/uncertainty/accuracy.h"
#include "alidade/calibrate/uncertainty/image_bias.h"
#include "alidade/calibrate/uncertainty/two_cameras.h"
#include "alidade/calibrate/uncertainty/view_covariance.h"
#include "alidade/calibrate/uncertainty/view_scores.h"
#include "alidade/calibrate/uncertainty/view_variation.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// A camera of the same model, far from the result in its own standard deviations, that the corners do not
/// rule out.
struct OtherOptimum {
  std::vector<double> params;  ///< N, in storage order, solved to rest on the corners of the result
  double rms_px = 0;           ///< weighted, to be compared with weightedRms() of the fit
  /// By how much its cost exceeds the result's: twice the difference over the variance of a coordinate. Below
  /// 0 where it was refined to less than the result, which then has gone astray since the two were compared.
  double excess_chi2 = 0;
  /// The largest parameter difference in stated standard deviations of the result.
  double sigmas = 0;
  /// The largest difference of the pixels of far points over the image, the rotation taken out, px; NaN where
  /// the two cameras have no pixel of the image in common.
  double projection_px = 0;
};

/// How accurately a fit determines its camera.
struct Uncertainty {
  /// One standard deviation of the coordinate of a corner of weight 1, from the residuals. The same number of
  /// corners with this noise would be equally informative.
  double coordinate_sigma_px = 0;
  /// tau of CornerNoise: the standard deviation per axis that detection noise does not explain. NaN if no
  /// corner states its sigma.
  double unexplained_sigma_px = std::numeric_limits<double>::quiet_NaN();
  /// coordinate_sigma_px from differences between neighbouring corners alone, in which errors that vary
  /// smoothly over the board (a lens that does not follow the model, a bent board) cancel; NaN without
  /// neighbours.
  double local_sigma_px = 0;
  /// The errors over those that neighbouring corners do not share, at least 1: large where the lens or the
  /// board deviates from its model.
  double smoothness = 1;
  std::size_t num_places = 0;  ///< of the boards, see placesOf()
  /// N x N covariance of the parameters in storage order; nothing where the views do not determine them.
  std::optional<DenseMatrix> covariance;
  /// The same without assuming that the corners of a view are independent, and with an ignored bend as a
  /// common error; empty without a covariance or with too few views. Where it is much larger,
  /// the views have errors that the model and the noise do not explain.
  std::optional<ViewCovariance> by_views;
  /// Where boards were held flat although tests say that they are bent.
  std::optional<IgnoredBend> ignored_bend;
  /// One sigma of bend_x and bend_y of each board of the fit, or with the board held flat what it would be;
  /// NaN if unknown.
  std::vector<Eigen::Vector2d> bend_std_m;
  /// N x N, per px^2: what the corners say about the parameters with all poses free, and the boards' bends
  /// where these are estimated and determined; along free_directions, covariance = coordinate_sigma_px^2 *
  /// its inverse.
  DenseMatrix information;
  DenseMatrix free_directions;  ///< N x M: what was estimated of the parameters, one direction per column
  double scaled_condition = 0;  ///< of `information`, its diagonal scaled to 1; near 0: undetermined
  /// What statedCovariance() makes of the pixel of a point: infinitely far away with the best rotation taken
  /// out, and near with the best pose. Nothing where there is no covariance.
  std::optional<UncertaintyGrid> projection_far;
  std::optional<UncertaintyGrid> projection_near;
  double board_distance_m = 0;            ///< median of the boards' middles from the camera
  std::vector<ViewInfluence> influences;  ///< one per view; empty if the views do not determine the camera
  HoldoutReport holdout;
  ImageBias image_bias;
  std::vector<CommonError> common_errors;  ///< one per cause that the views determine
  ViewVariations variations;               ///< what changes from view to view although it should not
  std::optional<TwoCameras> two_cameras;   ///< evidence for two cameras among the views
  std::vector<OtherOptimum> other_optima;  ///< that the corners do not rule out, the likeliest first
  std::optional<Accuracy> accuracy;        ///< of projected points; nothing without a covariance

  /// One standard deviation of parameter i, in storage order, from statedCovariance(): the one to report. NaN
  /// without a covariance.
  [[nodiscard]] double parameterStd(int i) const;
  /// The same if corner noise were the only error; from `covariance`.
  [[nodiscard]] double parameterStdByNoise(int i) const;
  /// Whether the views disagree by more than the corners' noise makes them, beyond chance: then `covariance`
  /// is too small, and `by_views` is what counts.
  [[nodiscard]] bool isNoiseExceeded() const;
  /// The covariance to use: where noise is exceeded, in every direction the larger of both. If a bend
  /// was ignored, that of the camera with the bend, plus the square of the change due to the bend.
  /// Exactly symmetric, so the lower triangle in files is complete. @pre there is a covariance
  [[nodiscard]] DenseMatrix statedCovariance() const;
  /// Two parameters whose combination is known well, but each of them badly.
  struct Correlation {
    int first = 0;
    int second = 0;
    double value = 0;  ///< -1 to 1
  };
  /// The strongest of statedCovariance() if it is above 0.95 in size. fx and fy that are held equal do not
  /// count.
  [[nodiscard]] std::optional<Correlation> strongestCorrelation() const;
  /// Do all views err in the same way at the same place of the image, and by enough to matter?
  [[nodiscard]] bool hasBias() const;
};

/// Of a fit of one camera, solved.
/// @param ignored_bend  see ignoredBend()
/// @param bend_std_m    of each board, see ShapeReport; where the bend is estimated, the result is more
///                      accurate
/// @param close_params  see ModelSolution
[[nodiscard]] Uncertainty uncertaintyOf(const Fit& fit, std::optional<IgnoredBend> ignored_bend,
                                        std::vector<Eigen::Vector2d> bend_std_m,
                                        const std::vector<std::vector<double>>& close_params,
                                        const CancelFlag* cancel);

}  // namespace alidade
