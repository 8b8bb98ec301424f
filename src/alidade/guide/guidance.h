// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/observation.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/camera/any_camera.h"
#include "alidade/guide/coverage.h"
#include "alidade/target/board.h"
#include "alidade/target/view.h"

namespace alidade {

/// A view that someone could take.
struct ViewCandidate {
  SE3 camera_from_board;
  /// Some of the corners that would be seen, evenly over the board, at the pixels where the camera puts them;
  /// their weights sum to the number of all that would be seen.
  std::vector<Observation> corners;
  bool is_whole = false;  ///< all corners would be seen
};

/// What a user can do.
struct CandidateLimits {
  double nearest_m = 0;  ///< distances of the board's middle
  double farthest_m = 0;
  bool is_upright = false;  ///< the board is held with its columns along the image's height
};

/// Poses of a board all over the image: its middle at places 7 x 5 (along the longer and the shorter side),
/// at three distances within the limits, spanning 30, 60 and 95 % of the image's smaller side without tilt,
/// and tilted by 0, 20 or 40 degrees to each side. At least half of the corners lie inside the image, with a
/// margin of a fiftieth of its smaller side, on squares of which none appears narrower than 6 pixels, and
/// none are seen from less than 15 degrees above the board. A partly visible board shows at least one
/// complete side, by which detection identifies the part. The order depends only on the arguments.
[[nodiscard]] std::vector<ViewCandidate> viewCandidates(const AnyCamera& camera, ImageSize size,
                                                        const Board& board, const CandidateLimits& limits);

/// What is known about a camera.
struct CameraKnowledge {
  AnyCamera camera;
  ImageSize size;
  /// N x N: of the parameters, with everything else free; per px^2, so that covariance = variance *
  /// information^-1 along `directions`. May be singular.
  Eigen::MatrixXd information;
  Eigen::MatrixXd directions;  ///< what is free among the parameters, one a column: N x M
  double variance = 1;         ///< of a corner's coordinate, px^2
};

/// A view to take, and what it gains.
struct NextView {
  SE3 camera_from_board;
  BoardSighting sighting;
  double fill = 0;            ///< as ViewCoverage::fill
  bool is_whole = false;      ///< all corners are seen
  bool is_on_end = false;     ///< the board stands on its short side
  double worst_px = 0;        ///< NextViewSearch::worst() with this view among the others
  std::size_t candidate = 0;  ///< among those of the search
};

/// Looks for the view that lowers the worst projection uncertainty most: among viewCandidates(), the one for
/// which the largest standard deviation over the image (ProjectionUncertainty, at infinity) is least once the
/// view's normal equations, its pose eliminated, are added to the information. A view of part of a board must
/// be better by a tenth than one of the whole board.
///
/// This is G-optimal design (Kiefer and Wolfowitz 1960, The equivalence of two extremum problems), one
/// observation at a time. Where the views leave a direction undetermined, so that some pixel is uncertain by
/// more than the image's diagonal, a prior is added: corners of variance 1 px^2 would know each parameter to
/// what moves some pixel by the diagonal. The largest gain is then that in the weakest direction.
class NextViewSearch {
 public:
  /// Builds all candidates and their information, once for any number of searches.
  NextViewSearch(const CameraKnowledge& known, const Board& board, const CandidateLimits& limits);

  /// False where the prior was needed.
  [[nodiscard]] bool isDetermined() const { return is_determined_; }
  /// The largest standard deviation of a pixel over the image, px; with the prior where that is needed. NaN
  /// where no pixel has a ray.
  [[nodiscard]] double worst() const;
  /// Empty if no candidate can be taken or none adds information.
  [[nodiscard]] std::optional<NextView> best() const;
  /// Goes on as if a candidate had been taken.
  void take(const NextView& view) { information_ += gains_[view.candidate]; }

 private:
  void addPriorIfUndetermined();

  CameraKnowledge known_;
  Board board_;
  CandidateLimits limits_;
  bool is_determined_ = true;
  Eigen::MatrixXd information_;  // M x M, along the directions
  Eigen::MatrixXd jacobians_;    // of pixels by the directions: M x 2 for each that has a ray, side by side
  std::vector<ViewCandidate> candidates_;
  std::vector<Eigen::MatrixXd> gains_;  // M x M
};

/// What one view says about the parameters with its pose free: N x N, per px^2. Corners that the camera does
/// not show are left out.
[[nodiscard]] Eigen::MatrixXd viewInformation(const AnyCamera& camera, const SE3& camera_from_board,
                                              const std::vector<Observation>& corners);

/// Largest number of further views in a forecast.
inline constexpr int kMaxForecast = 20;

/// How far a calibration is from the required uncertainty.
struct TargetReport {
  double target_px = 0;
  /// How many more views are needed, each the best after the previous ones: 0 if it is reached, empty if
  /// kMaxForecast are not enough or none can be suggested.
  std::optional<int> num_more_views;
  double forecast_px = 0;  ///< the worst uncertainty after those, or after as many as were tried

  [[nodiscard]] bool isReached() const { return num_more_views == 0; }
};

/// What the photographs show, and what to do next.
struct Guidance {
  CoverageReport coverage = {};
  Board board;             ///< that `next` shows: of several, the one with the most views
  bool is_chosen = false;  ///< there are several
  /// False where the views leave some direction of the parameters undetermined: `next` is then the view that
  /// tells most about it, and there is no uncertainty yet.
  bool is_determined = false;
  /// The largest standard deviation of a pixel over the image, px, at infinity (ProjectionUncertainty): the
  /// larger of that by the covariance and that by the covariance between views. NaN if not determined.
  double worst_px = 0;
  /// worst_px divided by its value from the covariance alone, at least 1; scales forecasts.
  double inflation = 1;
  std::optional<NextView> next = {};        ///< empty if no view would add information
  std::optional<TargetReport> target = {};  ///< if a target was given
};

/// @param views  those that were given to the calibration
/// @param target_px  positive
[[nodiscard]] Guidance guide(const Calibration& calibration, std::span<const View> views,
                             std::optional<double> target_px = std::nullopt);

/// Text for users: where to put the board, and the gain. Lines are not indented and end with a newline.
[[nodiscard]] std::string nextViewText(const Guidance& guidance, ImageSize size);
/// The same in one sentence without a line end.
[[nodiscard]] std::string shortNextViewText(const Guidance& guidance, ImageSize size);
[[nodiscard]] std::string targetText(const Guidance& guidance);

}  // namespace alidade
