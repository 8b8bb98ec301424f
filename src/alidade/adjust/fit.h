// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/corner_noise.h"
#include "alidade/adjust/lens_prior.h"
#include "alidade/adjust/observation.h"
#include "alidade/adjust/param_constraint.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board_shape.h"
#include "alidade/target/checkerboard.h"
#include "alidade/target/view.h"

namespace alidade {

/// A camera of a rig. A single camera is a rig of one, at the rig's origin.
struct FitCamera {
  std::string model = {};           ///< an id of the model list
  ImageSize size = {};              ///< of its images, pixels
  std::vector<double> params = {};  ///< in the model's storage order: fx fy cx cy, then the lens
  ParamConstraint constraint = {};
  WeakPrior weak_prior = {};
  CornerNoise noise = {};  ///< of its corners
  SE3 camera_from_rig = {};
  bool is_rig_pose_fixed = true;
};

/// A board, and whether its shape is estimated.
struct FitBoard {
  Checkerboard target;
  BoardShape shape = {};
  bool is_shape_fixed = true;
};

/// Where a board stands in one frame, an instant of the rig.
struct FitPlacement {
  std::size_t frame = 0;
  std::size_t board = 0;  ///< index into Fit::boards
  SE3 rig_from_board = {};
};

/// One board in one image.
struct FitView {
  std::size_t camera = 0;                    ///< index into Fit::cameras
  std::size_t placement = 0;                 ///< index into Fit::placements
  std::size_t source = 0;                    ///< index of the view among those that were given
  std::vector<Observation> corners = {};     ///< in use, in rising order of id; on the flat board
  std::vector<Eigen::Vector2d> errors = {};  ///< projected minus observed, px, not weighted; set by solve()
  std::string image = {};                    ///< its name; empty before a calibration is finished
};

enum class Termination {
  kConverged,
  kIterationLimit,
  kStalled,  ///< no step lowers the cost any more, far from a stationary point
  kFailed,   ///< the start cannot be evaluated or the linear algebra broke down
};

/// Stable name for files and JSON.
[[nodiscard]] std::string_view terminationName(Termination termination);

/// Lens parameter of a camera of a fit.
struct FitParam {
  std::size_t camera = 0;
  int index = 0;
  friend bool operator==(const FitParam&, const FitParam&) = default;
};

struct SolveSummary {
  Termination termination = Termination::kFailed;
  std::string reason = {};              ///< the solver's own words
  int num_iterations = 0;               ///< steps tried
  std::vector<FitParam> at_limit = {};  ///< parameters that the optimum pushes against the end of their range
  /// Half the sum of rho over all corners, px^2 of a corner of weight 1, with the priors' share; NaN where
  /// the start cannot be evaluated.
  double cost = 0;
};

/// Everything that a solve takes and gives: cameras, boards, where the boards stand, and what was seen of
/// them.
struct Fit {
  std::vector<FitCamera> cameras = {};
  std::vector<FitBoard> boards = {};
  std::vector<FitPlacement> placements = {};
  std::vector<FitView> views = {};
  HuberLoss loss = kNoLoss;
  SolveSummary summary = {};
};

/// The pose of the board in the camera's frame.
[[nodiscard]] SE3 cameraFromBoard(const Fit& fit, const FitView& view);
/// Moves the placement of the view, the camera staying where it is in the rig.
void setCameraFromBoard(Fit& fit, const FitView& view, const SE3& camera_from_board);

/// Of a fit of one camera, of one board.
/// @throws std::logic_error where there are others
[[nodiscard]] const FitCamera& onlyCamera(const Fit& fit);
[[nodiscard]] FitCamera& onlyCamera(Fit& fit);
[[nodiscard]] const FitBoard& onlyBoard(const Fit& fit);
[[nodiscard]] FitBoard& onlyBoard(Fit& fit);

/// Corners moved to where they lie on the bent board, as the solver takes them.
[[nodiscard]] std::vector<Observation> onShape(const Checkerboard& board, const BoardShape& shape,
                                               std::span<const Observation> flat);
[[nodiscard]] std::vector<Observation> cornersOnShape(const Fit& fit, const FitView& view);

/// Over all views.
[[nodiscard]] std::size_t numCorners(const Fit& fit);

/// A view of the first camera and the first board in a frame of its own. Views stay sorted by source.
/// @param source  see FitView
void addView(Fit& fit, std::size_t source, std::vector<Observation> corners, const SE3& camera_from_board);

/// A fit of one camera and one board without views.
[[nodiscard]] Fit emptyFit(std::string model, ImageSize size, std::vector<double> params,
                           const Checkerboard& board, HuberLoss loss);

/// The fit without some views, and without placements that no other view has.
/// @param is_out  one a view
[[nodiscard]] Fit withoutViews(const Fit& fit, const std::vector<bool>& is_out);
[[nodiscard]] Fit withoutView(const Fit& fit, std::size_t view);

/// The weights of all corners by their camera's noise; the largest relative change of one.
double updateWeights(Fit& fit);

}  // namespace alidade
