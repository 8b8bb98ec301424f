// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/observation.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/any_camera.h"
#include "alidade/guide/coverage.h"
#include "alidade/target/board.h"

namespace alidade {

/// A view that a user could take.
struct ViewCandidate {
  SE3 camera_from_board;
  /// Some of the corners that would be seen, spread evenly over the board, at their projected pixels. Their
  /// weights sum to the number of all corners that would be seen.
  std::vector<Observation> corners;
  bool is_whole = false;  ///< all corners would be seen
};

/// Limits of what a user can do.
struct CandidateLimits {
  double nearest_m = 0;  ///< distances of the board's centre
  double farthest_m = 0;
  bool is_upright = false;  ///< the board is held with its columns along the image's height
};

/// Poses of a board all over the image: its centre at 7 x 5 places (along the longer and the shorter side),
/// at three distances within the limits, spanning 30, 60 and 95 % of the image's smaller side without tilt,
/// and tilted by 0, 20 or 40 degrees to each side. At least half of the corners lie inside the image, with a
/// margin of a fiftieth of its smaller side, no square appears narrower than 6 pixels, and no line of sight
/// is less than 15 degrees from the board's plane. A partly visible board shows at least one complete side,
/// by which detection identifies the visible part. The order depends only on the arguments.
[[nodiscard]] std::vector<ViewCandidate> viewCandidates(const AnyCamera& camera, ImageSize size,
                                                        const Board& board, const CandidateLimits& limits);

/// Present knowledge of a camera.
struct CameraKnowledge {
  AnyCamera camera;
  ImageSize size;
  /// N x N: information on the parameters, with everything else free; per px^2, so that covariance = variance
  /// * information^-1 along `directions`. May be singular.
  Eigen::MatrixXd information;
  Eigen::MatrixXd directions;  ///< free directions of the parameters, one per column: N x M
  double variance = 1;         ///< of a corner's coordinate, px^2
};

/// A view to take, and its gain.
struct NextView {
  SE3 camera_from_board;
  BoardSighting sighting;
  double fill = 0;            ///< same as ViewCoverage::fill
  bool is_whole = false;      ///< all corners are seen
  bool is_on_end = false;     ///< the board stands on its short side
  double worst_px = 0;        ///< NextViewSearch::worst() after adding this view
  std::size_t candidate = 0;  ///< index among the candidates of the search
};

/// Looks for the view that lowers the worst projection uncertainty most: among viewCandidates(), the one for
/// which the largest standard deviation over the image (ProjectionUncertainty, at infinity) is smallest once
/// the view's normal equations, with its pose eliminated, are added to the information. A view of part of a
/// board must be better by a tenth than one of the whole board.
///
/// This is G-optimal design (Kiefer and Wolfowitz 1960, The equivalence of two extremum problems), one
/// observation at a time. Where the views leave a direction undetermined, so that some pixel is uncertain by
/// more than the image's diagonal, a prior is added: for corners of variance 1 px^2, the standard deviation
/// of each parameter is the change that moves some pixel by the diagonal. The largest gain is then in the
/// weakest direction.
class NextViewSearch {
 public:
  /// Builds all candidates and their information, once for any number of searches.
  NextViewSearch(const CameraKnowledge& known, const Board& board, const CandidateLimits& limits);

  /// False if the prior was needed.
  [[nodiscard]] bool isDetermined() const { return is_determined_; }
  /// The largest standard deviation of a pixel over the image, px; with the prior if that is needed. NaN if
  /// no pixel has a ray.
  [[nodiscard]] double worst() const;
  /// Empty if no candidate is possible or none adds information.
  [[nodiscard]] std::optional<NextView> best() const;
  /// Continues as if a candidate had been taken.
  void take(const NextView& view) { information_ += gains_[view.candidate]; }

 private:
  void addPriorIfUndetermined();

  CameraKnowledge known_;
  Board board_;
  CandidateLimits limits_;
  bool is_determined_ = true;
  Eigen::MatrixXd information_;  // M x M, along the directions
  Eigen::MatrixXd jacobians_;    // of pixels by the directions: M x 2 for each pixel with a ray, side by side
  std::vector<ViewCandidate> candidates_;
  std::vector<Eigen::MatrixXd> gains_;  // M x M
};

/// Information of one view about the parameters with its pose free: N x N, per px^2. Corners that the camera
/// does not show are ignored.
[[nodiscard]] Eigen::MatrixXd viewInformation(const AnyCamera& camera, const SE3& camera_from_board,
                                              const std::vector<Observation>& corners);

/// Largest number of further views in a forecast.
inline constexpr int kMaxForecast = 20;

/// Distance of a calibration from the required uncertainty.
struct TargetReport {
  double target_px = 0;
  bool is_reached = false;
  /// Number of views still needed, each the best one after the previous ones: 0 if the target is reached,
  /// empty if kMaxForecast are not enough or no further view can be suggested.
  std::optional<int> num_more_views;
  double forecast_px = 0;  ///< worst uncertainty after those views, or after as many as were tried
};

/// Advice on what to do next.
struct Guidance {
  Board board;             ///< the board of `next`; if there are several, the one with the most views
  bool is_chosen = false;  ///< several boards exist, so texts name this one
  /// False if the views leave a direction of the parameters undetermined: `next` is then the view that gives
  /// most information about it, and the uncertainty is unknown.
  bool is_determined = false;
  /// The largest standard deviation of a pixel over the image, px, at infinity (ProjectionUncertainty): the
  /// larger of the values from the covariance and from the covariance between views. NaN if not determined.
  double worst_px = 0;
  /// worst_px divided by its value from the covariance alone, at least 1; scales forecasts.
  double inflation = 1;
  std::optional<NextView> next = {};        ///< empty if no view would add information
  std::optional<TargetReport> target = {};  ///< if a target was given
};

/// @param target_px  positive
[[nodiscard]] Guidance guide(const Calibration& calibration, const CoverageReport& coverage,
                             std::optional<double> target_px = std::nullopt);

/// Text for users: where to put the board, and the gain. Lines are not indented and end with a newline.
[[nodiscard]] std::string nextViewText(const Guidance& guidance, ImageSize size);
/// The same in one sentence without a newline.
[[nodiscard]] std::string shortNextViewText(const Guidance& guidance, ImageSize size);
[[nodiscard]] std::string targetText(const Guidance& guidance);

}  // namespace alidade
