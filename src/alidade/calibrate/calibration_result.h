// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "alidade/calibrate/bend_by_views.h"
#include "alidade/calibrate/bundle_adjustment.h"
#include "alidade/calibrate/cross_validation.h"
#include "alidade/calibrate/finding.h"
#include "alidade/calibrate/image_bias.h"
#include "alidade/calibrate/model_candidate.h"
#include "alidade/calibrate/model_spread.h"
#include "alidade/calibrate/other_optimum.h"
#include "alidade/calibrate/start.h"
#include "alidade/calibrate/view_covariance.h"
#include "alidade/calibrate/view_scores.h"
#include "alidade/calibrate/view_variation.h"
#include "alidade/camera/any_camera.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board_shape.h"

namespace alidade {

/// A view as the calibration left it.
struct ViewResult {
  std::string image;
  SE3 camera_from_board;
  int num_corners = 0;  ///< used, outliers left out
  int num_outliers = 0;
  double rms_px = 0;  ///< sqrt(mean over used corners of dx^2 + dy^2)
  double max_error_px = 0;
  ViewInfluence influence;  ///< on the parameters
};

/// A view that was given but not used.
struct ExcludedView {
  std::string image;
  std::string reason;
};

/// A view that was taken together with another one of the same pose, see mergeRepeatedViews().
struct RepeatedView {
  std::string image;
  std::string same_as;  ///< the view that stands for both
};

/// A corner left out of the estimate because it lies far from where the camera puts it.
struct Outlier {
  std::string image;
  int corner_id = 0;
  Eigen::Vector2d error_px{0, 0};  ///< projected minus observed
};

/// A model with more parameters that explains the same views significantly better.
struct BetterModel {
  std::string id;
  double rms_px = 0;       ///< weighted, with the weights of the model in use
  double lean_rms_px = 0;  ///< that of the model in use
};

/// A bend of the board that the views show and the fit has left out.
struct IgnoredBend {
  BoardShape shape;
  Eigen::VectorXd params_step;  ///< N parameters
  double cost_share = 1;        ///< of the corners' cost, what the bend would leave
  /// N x N: the covariance by the corners' noise of the camera with the bend.
  std::optional<Eigen::MatrixXd> covariance = {};
};

/// What the views say of the board's shape.
struct ShapeReport {
  BoardShape shape;           ///< flat unless it was estimated
  bool is_estimated = false;  ///< with the camera; false: the board was held flat
  bool is_requested = false;  ///< whether or not a test sees a bend
  bool is_determined = true;  ///< false: these views and this board cannot tell a bend
  /// F statistic of the bend against a flat board, about 1 for a flat one; NaN if nobody asked.
  double f = std::numeric_limits<double>::quiet_NaN();
  std::optional<BendByViews> by_views;  ///< the same by views; nothing if nobody asked or they are too few
  /// One sigma of bend_x and bend_y, or with the board held flat what it would be; NaN if unknown.
  Eigen::Vector2d std_m = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  double bend_share = 0;  ///< the larger bend as a share of the board's extent along it
  /// Where the board was held flat although a test says that it is bent: the bend, and the change of the
  /// parameters that it would make, to first order.
  std::optional<IgnoredBend> ignored;
  /// Where it was estimated: the camera that the same corners give under the same loss with the board held
  /// flat.
  std::vector<double> flat_params;
  double flat_rms_px = std::numeric_limits<double>::quiet_NaN();  ///< and its weighted RMS
};

struct CalibrationResult {
  explicit CalibrationResult(AnyCamera estimated) : camera(std::move(estimated)) {}

  AnyCamera camera;
  ImageSize image_size;
  std::vector<ViewResult> views;  ///< in order of image name
  std::vector<ExcludedView> excluded_views;
  std::vector<RepeatedView> repeated_views;
  std::size_t num_misfits = 0;  ///< of the excluded views, those that do not fit the camera of the others
  std::vector<Outlier> outliers;
  int num_corners = 0;  ///< used
  double rms_px = 0;    ///< sqrt(mean over used corners of dx^2 + dy^2)
  /// The same with each corner's square times its weight, see CornerNoise; the mean weight is 1.
  double weighted_rms_px = 0;
  /// One standard deviation of the coordinate of a corner of weight 1, from the residuals: as many corners
  /// all as good as this would know as much as these do.
  double coordinate_sigma_px = 0;
  /// tau of CornerNoise: one standard deviation an axis that detection's own noise does not explain. NaN
  /// where no corner states its sigma.
  double unexplained_sigma_px = std::numeric_limits<double>::quiet_NaN();
  /// coordinate_sigma_px from differences between neighbouring corners alone, in which errors that vary
  /// smoothly over the board (a lens that does not follow the model, a bent board) cancel; NaN without
  /// neighbours.
  double local_sigma_px = 0;
  int num_corners_outside = 0;  ///< used corners that the final camera says it cannot see
  /// N x N covariance of the parameters in storage order; nothing where the views do not determine them.
  std::optional<Eigen::MatrixXd> covariance;
  /// The same without taking the corners of one view for independent, and with a bend that was ignored as a
  /// common error; nothing where there is no covariance, or the views are too few. Where it is much larger,
  /// the views have errors that the model and the noise do not explain.
  std::optional<ViewCovariance> by_views;
  /// N x N, per px^2: what the corners say about the parameters with all poses free, and the board's bend
  /// where that is estimated and determined; along free_directions, covariance = coordinate_sigma_px^2 * its
  /// inverse.
  Eigen::MatrixXd information;
  Eigen::MatrixXd free_directions;  ///< N x M: what was estimated of the parameters, one direction a column
  double scaled_condition = 0;      ///< see IntrinsicsInformation
  /// What statedCovariance() makes of the pixel of a point: infinitely far away with the best rotation taken
  /// out, and near with the best pose. Nothing where there is no covariance.
  std::optional<UncertaintyGrid> projection_far;
  std::optional<UncertaintyGrid> projection_near;
  double board_distance_m = 0;  ///< median of the boards' middles from the camera
  DomainCertificate domain;
  std::vector<int> held;  ///< indices of parameters that were not estimated; their sigma is 0
  StartReport start;      ///< how the search for a start went
  std::vector<OtherOptimum> other_optima;  ///< that the corners do not rule out, the likeliest first
  BundleSummary solver;
  HuberLoss loss{.threshold_px = 0};
  bool is_settled = true;  ///< noise estimate and set of outliers came to rest in the rounds allowed
  ShapeReport shape;
  WeakPrior weak_prior;                     ///< what holds a lens together that the views do not determine
  std::optional<BetterModel> better_model;  ///< where the model was named
  std::optional<ModelChoice> model_choice;  ///< where it was not
  std::optional<ModelSpread> model_spread;  ///< where other models predict corners as well
  HoldoutReport holdout;
  ImageBias image_bias;
  /// Whether the board's squares are square, from the corners; nothing where the views do not tell.
  std::optional<BoardStretch> board_stretch;
  ViewVariations variations;  ///< what changes from view to view although it should not
  std::vector<Finding> findings;

  /// One standard deviation of parameter i; NaN without a covariance.
  [[nodiscard]] double parameterStd(int i) const;
  /// Whether the views disagree by more than the corners' noise makes them, beyond chance: then `covariance`
  /// is too small, and `by_views` is what counts.
  [[nodiscard]] bool isNoiseExceeded() const;
  /// The covariance to go by: where noise is exceeded, in every direction the larger of both. Where a bend
  /// was ignored, that of the camera with the bend, and on top the square of what the bend would change.
  /// Exactly symmetric: its lower triangle, as files state it, is all of it. There must be a covariance.
  [[nodiscard]] Eigen::MatrixXd statedCovariance() const;
  /// Its one standard deviation of parameter i; NaN without a covariance.
  [[nodiscard]] double statedStd(int i) const;
  /// Of the corners of the views in use, how many were left out.
  [[nodiscard]] double outlierShare() const;
  /// Two parameters of which the views tell a combination well and each alone badly.
  struct Correlation {
    int first = 0;
    int second = 0;
    double value = 0;  ///< -1 to 1
  };
  /// The strongest of statedCovariance() if it is above 0.95 in size. fx and fy that are held equal do not
  /// count.
  [[nodiscard]] std::optional<Correlation> strongestCorrelation() const;
  /// Errors over what neighbouring corners differ by: 1 for noise alone, more where they vary smoothly. NaN
  /// without neighbours.
  [[nodiscard]] double smoothness() const;
  /// Do all views err in the same way at the same place of the image, and by enough to matter?
  [[nodiscard]] bool hasBias() const;
  [[nodiscard]] Verdict verdict() const { return verdictOf(findings); }
  /// False if any finding is a failure: the parameters are then not to be used.
  [[nodiscard]] bool isUsable() const { return verdict() != Verdict::kNo; }
};

/// Looks at everything but `findings` and says what is wrong with the result; pure judgement, no estimation.
[[nodiscard]] std::vector<Finding> judge(const CalibrationResult& result);

}  // namespace alidade
