// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/noise/cross_validation.h"
#include "alidade/calibrate/start/reports.h"
#include "alidade/camera/projection_uncertainty.h"
#include "alidade/geometry/dense_matrix.h"

namespace alidade {

/// Normal deviate from which the disagreement of views counts as more than corner noise: about 1 in 100 clean
/// sets exceeds it.
inline constexpr double kBeyondChance = 3;

/// Covariance of the intrinsics from the disagreement of the views.
struct ViewCovariance {
  DenseMatrix covariance;  ///< N x N, parameters in storage order; do not use if pooled
  /// Degrees of freedom of each parameter's variance: the variance is roughly a multiple of chi square, and
  /// the parameter's error over its square root follows Student's t. 0 for a held parameter.
  std::vector<double> freedom;
  /// Variance by this covariance over that by corner noise, averaged over the free directions, scaled to 1
  /// for the latter; about 1 if there is only independent noise.
  double excess = 0;
  /// The same as a standard normal deviate: the certainty that it exceeds chance.
  double excess_sigmas = 0;

  /// How many views count as one, see serialFactor().
  double serial_factor = 1;

  /// The views are too few for their own covariance: no more than there are free directions, or with less
  /// than two degrees of freedom for some parameter. The mean over all directions, `excess`, then stabilises
  /// each.
  bool is_pooled = false;

  /// N x N: in every direction the larger of the covariance by corner noise and of this one, the latter
  /// increased for its few degrees of freedom (the smallest of a free parameter), so that 1.96 of its
  /// standard deviations cover 95 %. If pooled, it is in every direction the larger of the covariance by
  /// noise times the excess (above 1, and increased for the effective number of views, less one) and of this
  /// one, increased as for two degrees of freedom; 95 % is then covered on average over directions.
  DenseMatrix larger;

  /// N x 1: a known error that all views have in common, which no disagreement shows (an ignored bend of the
  /// board); empty: none. Not in `covariance` and `larger`.
  DenseMatrix common_error = {};

  /// Half the width of parameter i's 95 % interval over 1.96: usable like the standard deviation of a normal
  /// variable, combined with the common error as a root sum of squares. 0 for a held parameter.
  [[nodiscard]] double effectiveStd(int i) const;
};

/// The parameters of a fit's camera, and the accuracy with which the views determine them.
struct ParameterUncertainty {
  /// One standard deviation of the coordinate of a corner of weight 1, from the residuals. The same number of
  /// corners with this noise would be equally informative.
  double coordinate_sigma_px = 0;
  /// N x N covariance of the parameters in storage order; nothing if the views do not determine them.
  std::optional<DenseMatrix> covariance = {};
  /// The same without assuming that the corners of a view are independent, and with an ignored bend as a
  /// common error; empty without a covariance or with too few views. If it is much larger, the views have
  /// errors that the model and the noise do not explain.
  std::optional<ViewCovariance> by_views = {};
  /// Set if boards were held flat although tests detect bends.
  std::optional<IgnoredBend> ignored_bend = {};
  /// N x boards: the changes of the parameters by stretches of the boards that the views show and the fit
  /// ignores, one standard deviation each.
  DenseMatrix ignored_stretches = {};
  /// One sigma of bend_x and bend_y of each board of the fit; if the board is held flat, the value if it were
  /// estimated. NaN if unknown.
  std::vector<Eigen::Vector2d> bend_std_m = {};
  /// N x N, per px^2: information of the corners about the parameters with all poses free, and the boards'
  /// bends if these are estimated and determined; along free_directions, covariance = coordinate_sigma_px^2 *
  /// its inverse.
  DenseMatrix information = {};
  DenseMatrix free_directions = {};  ///< N x M: the estimated directions, one per column
  double scaled_condition = 0;       ///< of `information`, its diagonal scaled to 1; near 0: undetermined
  /// One standard deviation of each number of the entrance pupil, metres; empty if it is not estimated. The
  /// other members are about the lens, with the pupil free.
  std::vector<double> pupil_std_m = {};

  /// One standard deviation of parameter i, in storage order, from statedCovariance(): the one to report. NaN
  /// without a covariance.
  [[nodiscard]] double parameterStd(int i) const;
  /// The same as if corner noise were the only error; from `covariance`.
  [[nodiscard]] double parameterStdByNoise(int i) const;
  /// True if the views disagree by more than corner noise, beyond chance: `covariance` is then too small, and
  /// `by_views` must be used.
  [[nodiscard]] bool isNoiseExceeded() const;
  /// The covariance to use: if noise is exceeded, in every direction the larger of both. If a bend was
  /// ignored, that of the camera with the bend, plus the square of the change due to the bend; likewise for
  /// a stretch. Exactly symmetric, so the lower triangle in files is complete. @pre there is a covariance
  [[nodiscard]] DenseMatrix statedCovariance() const;
  /// Two parameters whose combination is known well, but each of them poorly.
  struct Correlation {
    int first = 0;
    int second = 0;
    double value = 0;  ///< -1 to 1
  };
  /// The strongest correlation in statedCovariance() if its size is above 0.95. fx and fy that are held equal
  /// do not count.
  [[nodiscard]] std::optional<Correlation> strongestCorrelation() const;
};

/// Errors, the same in all views, that a calibration assumes to be absent. The first kNumBoardCauses are
/// errors of a board: boards are printed and mounted individually, so each has its own.
enum class CommonCause {
  kStretch,    ///< width over height of the squares, less 1
  kGradingX,   ///< of the squares along x: change at the edges, over the board's half width
  kGradingY,   ///< the same along y
  kTwist,      ///< height of the board's corners over its plane, over its half width
  kGap,        ///< between tags: the gap that is seen less that of the board, as shares of a tag's side
  kPupil,      ///< shift of the entrance pupil towards the scene at 1 rad off the axis, metres
  kFocus,      ///< share by which the focal length changes per inverse distance, metres
  kOutward,    ///< outward displacement of corners at the board's edges, px
  kHeld,       ///< held value of a parameter: what the views give in its place, less it
  kHeldFocal,  ///< held values of both focal lengths: those that the views give over them, less 1
};
/// Their names, for JSON, without those of held values.
inline constexpr std::array<std::string_view, 8> kCommonCauses = {
    "stretch", "grading_x", "grading_y", "twist", "gap", "pupil_m", "focus_m", "outward_px"};

inline constexpr int kNumBoardCauses = 5;

/// An error common to all views of a board, or to all views.
struct CommonError {
  CommonCause cause;
  std::size_t board = 0;                 ///< index of the board, for causes related to a board
  int parameter = -1;                    ///< index of the held parameter, for kHeld
  double value = 0;                      ///< in the unit of the cause
  double sigma = 0;                      ///< one standard deviation
  std::vector<double> params_step = {};  ///< N: parameter change if it were taken into account

  [[nodiscard]] double sigmas() const { return std::abs(value) / sigma; }
  [[nodiscard]] bool isSignificant() const { return sigmas() > 3; }
};

/// The effect of omitting one view, to first order.
struct ViewInfluence {
  /// The largest displacement of any function of the intrinsics, in its own standard deviations: those by
  /// noise, or, if the other views disagree beyond chance, those by their disagreement if larger.
  double move_sigmas = 0;
  /// Disagreement of the view with the others beyond what noise explains, as a standard normal deviate; at
  /// most 1 in 1000 views of a clean set exceeds 3.1. If all views disagree because no lens of the model
  /// matches the real one, it is relative to the typical disagreement.
  double surprise_sigmas = 0;
};

/// Variation between single views, each with its own pose, with the camera fixed as estimated from all.
///
/// F is the statistic of one value per view against one for all: about 1 if nothing varies, NaN with too few
/// views. The spread is one standard deviation between views, without the contribution of noise (DerSimonian
/// and Laird 1986, Meta-analysis in clinical trials, Controlled Clinical Trials 7(3)).
struct ViewVariations {
  /// Both focal lengths scaled by one factor: zoom, focus or crop changed between images. The spread is a
  /// share of the focal length.
  double focal_f = std::numeric_limits<double>::quiet_NaN();
  double focal_spread = 0;
  /// The image sheared and stretched from row to row: the board or the camera moved while the rows were read
  /// one after the other. With a free pose, a plane can disagree with a camera in only two ways, and these
  /// are the two; so this also explains a varying focal length. The spread is a share of the image's height.
  double rows_f = std::numeric_limits<double>::quiet_NaN();
  double rows_spread = 0;
  /// Share of the variation explained by the rows that the focal length alone explains: near 1 if focal
  /// lengths vary, about a half if images are sheared at random.
  double focal_share = 0;
};

/// A change of both focal lengths, in proportion, from one view on, in the order of the views: the surest
/// one.
struct FocalStep {
  std::size_t first_view = 0;
  double share = 0;   ///< of the focal length
  double sigmas = 0;  ///< its size as a standard normal deviate: by noise, or by the disagreement of views if
                      ///< that is less certain
};

/// Views of two cameras, or of two settings of one.
struct TwoCameras {
  std::vector<std::size_t> minority = {};  ///< indices of the views of the camera with fewer views
  std::vector<double> params_step = {};    ///< N: its parameters minus those of the other one, to first order
};

/// Evidence of single views and boards against the common camera.
struct ViewEvidence {
  std::vector<ViewInfluence> influences =
      {};  ///< one per view; empty if the views do not determine the camera
  std::vector<CommonError> common_errors = {};  ///< one per cause that the views determine
  ViewVariations variations = {};               ///< variation between views that should not exist
  std::optional<FocalStep> focal_step = {};     ///< nothing with few views or several boards
  std::optional<TwoCameras> two_cameras = {};   ///< evidence for two cameras among the views
};

/// Test whether errors at one place of the image point the same way in different views. A lens that does not
/// follow its model causes the same error at the same place of the image in all views; a bent board does so
/// at the same place of the board, and noise nowhere.
struct ImageBias {
  /// The views' common error relative to 0, in standard deviations for views whose errors have random signs.
  /// Noise gives about 0, and errors common to the corners of one view do not count. Sums of products have a
  /// longer tail than a normal variable, and the maximum for n views is sqrt(n (n - 1) / 2): a few similar
  /// views prove little.
  double z = std::numeric_limits<double>::quiet_NaN();
  /// RMS of the common error, px for a corner of weight 1; 0 if its square is negative.
  double rms_px = std::numeric_limits<double>::quiet_NaN();

  /// True if z exceeds the effect of noise. Less than one clean set in a hundred exceeds this limit.
  [[nodiscard]] bool isSeen() const { return z > kSeenZ; }
  static constexpr double kSeenZ = 4;
};

/// A camera of the same model, far from the result in stated standard deviations, that the corners do not
/// rule out.
struct OtherOptimum {
  std::vector<double> params;  ///< N, in storage order, solved to convergence on the corners of the result
  double rms_px = 0;           ///< weighted; compare with weightedRms() of the fit
  /// Excess of its cost over the result's: twice the difference over the variance of a coordinate. Below 0 if
  /// refinement lowered it below the result's, which has then converged to the wrong optimum.
  double excess_chi2 = 0;
  /// The largest parameter difference in stated standard deviations of the result.
  double sigmas = 0;
  /// The largest difference of the pixels of distant points over the image, after the best rotation, px; NaN
  /// if the two cameras have no pixel of the image in common.
  double projection_px = 0;
};

/// The error of the pixel of a scene point that is not exceeded with a probability of 95 %, over the whole
/// image: for distant points after alignment by the best rotation, for points at a finite distance after
/// alignment by the best pose. It is the sum of
///
/// - the stated covariance, or if larger, the difference to a second camera that explains the corners equally
/// well, or outside the region that boards covered, the covariance of a more flexible model at the same lens,
/// because a stiff model extrapolates with a covariance that is too small. For stiff models this applies
/// inside too, about that second camera; and
/// - the deviation of the lens from its model that all views have in common (ImageBias).
struct Accuracy {
  double distance_m = std::numeric_limits<double>::infinity();  ///< of the points
  int columns = 0;                                              ///< of the grid, from border to border
  int rows = 0;
  std::vector<Eigen::Vector2d> pixels = {};  ///< row by row
  std::vector<double> error_px = {};         ///< 95 %, one per pixel; NaN if the pixel has no ray
  std::vector<bool> is_covered = {};         ///< within the corners of some view
  double covered_share = 0;                  ///< of the pixels with a ray
  double covered_px = std::numeric_limits<double>::quiet_NaN();  ///< the largest error where boards were seen
  double worst_px = std::numeric_limits<double>::quiet_NaN();    ///< the largest error of all
  Eigen::Vector2d worst_pixel{0, 0};
  double deviation_px = 0;  ///< of the lens from its model, 95 %; included

  /// Share of the pixels with a ray for which the error is at most `tolerance_px`.
  [[nodiscard]] double shareWithin(double tolerance_px) const;
  /// The same for the covered pixels.
  [[nodiscard]] double coveredShareWithin(double tolerance_px) const;
};

/// How accurately a fit determines its camera.
struct Uncertainty : ParameterUncertainty, ViewEvidence {
  /// tau of CornerNoise: the standard deviation per axis that detection noise does not explain. NaN if no
  /// corner states its sigma.
  double unexplained_sigma_px = std::numeric_limits<double>::quiet_NaN();
  /// coordinate_sigma_px from differences between neighbouring corners only, in which errors that vary
  /// smoothly over the board (a lens that does not follow the model, a bent board) cancel; NaN without
  /// neighbours.
  double local_sigma_px = 0;
  /// Total errors over those that neighbouring corners do not share, at least 1: large if the lens or the
  /// board deviates from its model.
  double smoothness = 1;
  std::size_t num_places = 0;  ///< of the boards, see placesOf()
  /// Pixel uncertainty by statedCovariance(): for points at infinity after the best rotation, and for near
  /// ones after the best pose. Nothing without a covariance.
  std::optional<UncertaintyGrid> projection_far = {};
  std::optional<UncertaintyGrid> projection_near = {};
  double board_distance_m = 0;  ///< median distance of the boards' centres from the camera
  HoldoutReport holdout = {};
  ImageBias image_bias = {};
  std::vector<OtherOptimum> other_optima = {};  ///< not ruled out by the corners, the likeliest first
  std::optional<Accuracy> accuracy = {};        ///< of projected points; nothing without a covariance

  /// True if all views have the same error at the same place of the image, and it is large enough to matter.
  [[nodiscard]] bool hasBias() const;
};

}  // namespace alidade
