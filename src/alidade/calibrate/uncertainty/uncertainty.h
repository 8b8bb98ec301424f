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

/// From so many normal deviates on, views disagree by more than the corners' noise makes them: of clean sets
/// about 1 in 100 exceeds it.
inline constexpr double kBeyondChance = 3;

/// The intrinsics' uncertainty by how much the views disagree.
struct ViewCovariance {
  DenseMatrix covariance;  ///< N x N, parameters in storage order; not to be used where pooled
  /// Degrees of freedom of each parameter's variance: it is a multiple of chi square, roughly, and the
  /// parameter's error over its root follows Student's t. 0 for a parameter that is held.
  std::vector<double> freedom;
  /// Variance by this covariance over that by the corners' noise, averaged over the free directions in which
  /// the latter is 1; about 1 where there is nothing but independent noise.
  double excess = 0;
  /// The same in standard deviations of a normal variable: how surely it is more than chance.
  double excess_sigmas = 0;

  /// The views are too few for a covariance of their own: no more than there are free directions, or with
  /// less than two degrees of freedom for some parameter. Then the mean over all directions, `excess`,
  /// steadies each.
  bool is_pooled = false;

  /// N x N: in every direction the larger of the covariance by the corners' noise and of this one, the latter
  /// made larger for its few degrees of freedom (the least of a free parameter), so that 1.96 of its standard
  /// deviations hold 95 %. Pooled, it is in every direction the larger of the covariance by noise times the
  /// excess (above 1, and made larger for the number of views that say equally much, less one) and of this
  /// one, made larger as for two degrees of freedom; 95 % is then held on average over directions.
  DenseMatrix larger;

  /// N x 1: an error that all views have in common and that is known, which no disagreement shows (a bend of
  /// the board that was ignored); empty: none. Not in `covariance` and `larger`.
  DenseMatrix common_error = {};

  /// Half the width of parameter i's 95 % interval over 1.96: one standard deviation that can be used like
  /// one of a normal variable, together with the root mean square of the common error. 0 for a parameter that
  /// is held.
  [[nodiscard]] double effectiveStd(int i) const;
};

/// The parameters of a fit's camera, and how accurately the views determine them.
struct ParameterUncertainty {
  /// One standard deviation of the coordinate of a corner of weight 1, from the residuals. The same number of
  /// corners with this noise would be equally informative.
  double coordinate_sigma_px = 0;
  /// N x N covariance of the parameters in storage order; nothing where the views do not determine them.
  std::optional<DenseMatrix> covariance = {};
  /// The same without assuming that the corners of a view are independent, and with an ignored bend as a
  /// common error; empty without a covariance or with too few views. Where it is much larger,
  /// the views have errors that the model and the noise do not explain.
  std::optional<ViewCovariance> by_views = {};
  /// Where boards were held flat although tests say that they are bent.
  std::optional<IgnoredBend> ignored_bend = {};
  /// One sigma of bend_x and bend_y of each board of the fit, or with the board held flat what it would be;
  /// NaN if unknown.
  std::vector<Eigen::Vector2d> bend_std_m = {};
  /// N x N, per px^2: what the corners say about the parameters with all poses free, and the boards' bends
  /// where these are estimated and determined; along free_directions, covariance = coordinate_sigma_px^2 *
  /// its inverse.
  DenseMatrix information = {};
  DenseMatrix free_directions =
      {};                       ///< N x M: what was estimated of the parameters, one direction per column
  double scaled_condition = 0;  ///< of `information`, its diagonal scaled to 1; near 0: undetermined

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
};

/// Errors that a calibration excludes, the same in all views. The first kNumBoardCauses are mistakes of a
/// board: boards are printed and mounted one by one, so that each has its own.
enum class CommonCause {
  kStretch,   ///< width over height of the squares, less 1
  kGradingX,  ///< of the squares along x: how far the edges are farther out, over the board's half width
  kGradingY,  ///< the same along y
  kTwist,     ///< height of the board's corners over its plane, over its half width
  kPupil,     ///< how far the entrance pupil is nearer to the scene at 1 rad off the axis, metres
  kFocus,     ///< share by which the focal length changes with the inverse of the distance, metres
  kOutward,   ///< how far corners at the board's edges are seen too far from its middle, px
};
/// Their names, for JSON.
inline constexpr std::array<std::string_view, 7> kCommonCauses = {
    "stretch", "grading_x", "grading_y", "twist", "pupil_m", "focus_m", "outward_px"};

inline constexpr int kNumBoardCauses = 4;

/// An error that all views of a board, or all views, have in common.
struct CommonError {
  CommonCause cause;
  std::size_t board = 0;                 ///< index of the board, for causes that belong to a board
  double value = 0;                      ///< in the unit of the cause
  double sigma = 0;                      ///< one standard deviation
  std::vector<double> params_step = {};  ///< N: what taking it into account would change

  [[nodiscard]] double sigmas() const { return std::abs(value) / sigma; }
  [[nodiscard]] bool isSignificant() const { return sigmas() > 3; }
};

/// The effect of leaving out one view, to first order.
struct ViewInfluence {
  /// The most by which any function of the intrinsics would move, in standard deviations of its own: those by
  /// noise, or where the other views disagree with one another beyond chance, those by their disagreement if
  /// larger.
  double move_sigmas = 0;
  /// How much more the view disagrees with the others than noise makes views disagree, in standard deviations
  /// of a normal variable; at most 1 in 1000 views of a clean set exceeds 3.1. Where all views disagree
  /// because no lens of the model follows the real one, against what is typical among them.
  double surprise_sigmas = 0;
};

/// Variation between single views, each with its own pose, while the camera stays as estimated from all.
///
/// F is the statistic of one value a view against the same for all: about 1 where nothing varies, NaN with
/// too few views. The spread is one standard deviation between views, without what noise adds to it
/// (DerSimonian and Laird 1986, Meta-analysis in clinical trials, Controlled Clinical Trials 7(3)).
struct ViewVariations {
  /// Both focal lengths times the same factor: zoom, focus or crop changed between images. The spread is a
  /// share of the focal length.
  double focal_f = std::numeric_limits<double>::quiet_NaN();
  double focal_spread = 0;
  /// The image sheared and stretched from row to row: the board or the camera moved while the rows were read
  /// one after the other. A plane seen from a free pose leaves two ways to disagree with a camera, and these
  /// are the two; so this explains a varying focal length as well. The spread is a share of the image's
  /// height.
  double rows_f = std::numeric_limits<double>::quiet_NaN();
  double rows_spread = 0;
  /// Of what the rows explain, the share that the focal length explains alone: near 1 if focal lengths vary,
  /// about a half if images are sheared at random.
  double focal_share = 0;
};

/// Views of two cameras, or of two settings of one.
struct TwoCameras {
  std::vector<std::size_t> minority = {};  ///< indices of the views of the camera with fewer views
  std::vector<double> params_step = {};    ///< N: its parameters less those of the other one, to first order
};

/// Evidence of single views and boards against the camera that all agree on.
struct ViewEvidence {
  std::vector<ViewInfluence> influences =
      {};  ///< one per view; empty if the views do not determine the camera
  std::vector<CommonError> common_errors = {};  ///< one per cause that the views determine
  ViewVariations variations = {};               ///< what changes from view to view although it should not
  std::optional<TwoCameras> two_cameras = {};   ///< evidence for two cameras among the views
};

/// Do errors at one place of the image point the same way in different views? A lens that does not follow its
/// model errs in the same way in all views at the same place of the image; a bent board does so at the same
/// place of the board, and noise nowhere.
struct ImageBias {
  /// How far what the views agree in exceeds 0, in standard deviations of what it is if each view has its
  /// errors with a sign by chance. Noise gives about 0, and whatever corners of one view have in common does
  /// not count. Sums of products have a longer tail than a normal variable, and no more than the root of half
  /// the number of views squared can be reached: with few views that look alike, little can be proved.
  double z = std::numeric_limits<double>::quiet_NaN();
  /// Root mean square of what they agree in, px of a corner of weight 1; 0 where it is negative.
  double rms_px = std::numeric_limits<double>::quiet_NaN();

  /// Is z larger than noise makes it? Less than one clean set in a hundred exceeds this limit.
  [[nodiscard]] bool isSeen() const { return z > kSeenZ; }
  static constexpr double kSeenZ = 4;
};

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

/// The error of the pixel of a scene point that is not exceeded with a probability of 95 %, over the whole
/// image: of distant points after alignment by the best rotation, of points at a finite distance after
/// alignment by the best pose. It adds up
///
/// - the stated covariance, or if larger, the difference to another camera that explains the corners as well,
///   or outside the region that boards covered, the covariance of a more flexible model at the same lens: a
///   stiff model extrapolates with a small covariance, and wrongly. For stiff models inside too, about that
///   other camera; and
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

  /// Share of the pixels with a ray whose error is at most `tolerance_px`.
  [[nodiscard]] double shareWithin(double tolerance_px) const;
  /// The same of the covered pixels.
  [[nodiscard]] double coveredShareWithin(double tolerance_px) const;
};

/// How accurately a fit determines its camera.
struct Uncertainty : ParameterUncertainty, ViewEvidence {
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
  /// Pixel uncertainty by statedCovariance(): of points infinitely far away with the best rotation taken
  /// out, and of near ones with the best pose. Nothing where there is no covariance.
  std::optional<UncertaintyGrid> projection_far = {};
  std::optional<UncertaintyGrid> projection_near = {};
  double board_distance_m = 0;  ///< median of the boards' middles from the camera
  HoldoutReport holdout = {};
  ImageBias image_bias = {};
  std::vector<OtherOptimum> other_optima = {};  ///< that the corners do not rule out, the likeliest first
  std::optional<Accuracy> accuracy = {};        ///< of projected points; nothing without a covariance

  /// Do all views err in the same way at the same place of the image, and by enough to matter?
  [[nodiscard]] bool hasBias() const;
};

}  // namespace alidade
