// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/corner_noise.h"
#include "alidade/adjust/board/lens_prior.h"
#include "alidade/adjust/board/observation.h"
#include "alidade/camera/entrance_pupil.h"
#include "alidade/core/error.h"
#include "alidade/core/image.h"
#include "alidade/geometry/se3.h"
#include "alidade/target/board.h"
#include "alidade/target/board_shape.h"
#include "alidade/target/view.h"

namespace alidade {

class AnyCamera;
class CorrectionField;

/// The intrinsics that a solve must not change.
struct ParamConstraint {
  std::vector<int> held = {};  ///< indices of fixed parameters
  bool same_focal = false;     ///< fx and fy change by the same step, so they stay equal

  [[nodiscard]] bool isNone() const { return held.empty() && !same_focal; }
  [[nodiscard]] bool holds(int i) const { return std::ranges::find(held, i) != held.end(); }
};

/// The remaining free directions, one per column: N parameters x M.
[[nodiscard]] Eigen::MatrixXd freeDirections(int num_params, const ParamConstraint& constraint);

/// A camera of a rig. A single camera is a rig of one, at the rig's origin.
struct FitCamera {
  std::string model = {};  ///< an id of the model list
  ImageSize size = {};     ///< of its images, pixels
  /// In the model's storage order: fx fy cx cy, then the lens. Then s1, or s1 and s2, of the
  /// EntrancePupil if it is estimated.
  std::vector<double> params = {};
  /// How the lens deviates from these. The corners of a fit, and all that is computed from it, are free of
  /// it: where this camera would see them without. Null: not at all.
  std::shared_ptr<const CorrectionField> correction = {};
  ParamConstraint constraint = {};
  WeakPrior weak_prior = {};
  CornerNoise noise = {};  ///< of its corners
  SE3 camera_from_rig = {};
  bool is_rig_pose_fixed = true;
  double delay =
      0;  ///< of its images within each frame, in intervals between frames; for views with a PoseDeviation
  bool is_delay_fixed = true;

  [[nodiscard]] std::size_t numLensParams() const;
  [[nodiscard]] bool hasPupil() const { return params.size() > numLensParams(); }
};

/// A camera from FitCamera::params.
[[nodiscard]] AnyCamera cameraOf(std::string_view model, std::span<const double> params);
[[nodiscard]] AnyCamera cameraOf(const FitCamera& camera);
/// FitCamera::params of a camera.
[[nodiscard]] std::vector<double> fitParams(const AnyCamera& camera);
/// How many of them are the entrance pupil's: 0 if it does not move.
[[nodiscard]] std::size_t numPupil(const AnyCamera& camera);
/// Replaces the lens and keeps the entrance pupil.
void setLens(std::string_view model, std::span<const double> lens, FitCamera& camera);

/// False if a solver has left the range of cameras.
[[nodiscard]] inline bool hasFocalLengths(const FitCamera& camera) {
  return camera.params[0] > 0 && camera.params[1] > 0;
}

/// How a board bends differently in each view about its own shape, see estimateFlex(); FitView::flex_m are
/// the bends.
struct Flex {
  double std_m = 0;      ///< standard deviation of bend_x and bend_y, metres; 0 for a rigid board
  double precision = 0;  ///< inverse variance per m^2, times the variance (px^2) of a corner of weight 1
  double num_free = 0;   ///< number of bends that the corners determine, not the scatter
};

/// A board, and the estimated parts of its shape.
struct FitBoard {
  Board target;
  BoardShape shape = {};
  bool is_shape_fixed = true;  ///< of the bend
  /// For an uneven board, whose points have offsets: their scatter about zero, in the plane and normal to it.
  /// Inverse variances per m^2, times the variance (px^2) of a corner of weight 1. See withOffsets().
  std::optional<Eigen::Vector2d> offset_precision = {};
  double num_free_offsets = 0;  ///< number of offset coordinates that the corners determine, not the scatter
  Flex flex = {};
  /// Its place among boards that are fixed to each other, see FitPlacement; nothing for the first of them.
  std::optional<SE3> body_from_board = {};
  bool is_body_pose_fixed = false;

  [[nodiscard]] bool isUneven() const { return offset_precision.has_value(); }
  [[nodiscard]] bool isFlexible() const { return flex.std_m > 0; }
  [[nodiscard]] bool isBodyPoseFree() const { return body_from_board && !is_body_pose_fixed; }
  /// The pose of the board from that of its body.
  [[nodiscard]] SE3 poseOf(const SE3& x_from_body) const {
    return body_from_board ? x_from_body * *body_from_board : x_from_body;
  }
  /// The tangent of the board's pose by that of its body's.
  [[nodiscard]] Eigen::Matrix<double, 6, 6> tangentByBody() const { return poseOf({}).inverse().adjoint(); }
};

/// The position of a body in one frame (instant) of the rig: of one board, or of several that are fixed to
/// each other. The body's frame is that of its first board.
struct FitPlacement {
  std::size_t frame = 0;
  std::size_t body = 0;  ///< the body's first board, an index into Fit::boards
  SE3 rig_from_body = {};
};

/// Deviation of a board's pose in one view from its placement, because the image was taken a moment before or
/// after the others of its frame: a tangent of camera_from_board. The board moves along its path through the
/// frames for the camera's delay, and scatters in time and about the path.
struct PoseDeviation {
  static constexpr int kSize = 7;
  using Normal = Eigen::Matrix<double, kSize, 1>;

  SE3::Tangent velocity = SE3::Tangent::Zero();      ///< of the board, per interval between frames
  SE3::Tangent acceleration = SE3::Tangent::Zero();  ///< per interval squared
  /// Effects of the scatter's coordinates, one standard deviation each: of the time, then of the path.
  Eigen::Matrix<double, 6, kSize> root = Eigen::Matrix<double, 6, kSize>::Zero();
  /// The scatter in these coordinates, which are independent with variance 1 if the weights of corners are
  /// inverse variances. Estimated by solve().
  Normal normal = Normal::Zero();

  [[nodiscard]] SE3::Tangent tangent(double delay) const {
    return delay * velocity + delay * delay / 2 * acceleration + root * normal;
  }
  [[nodiscard]] SE3::Tangent tangentByDelay(double delay) const { return velocity + delay * acceleration; }
};

/// One board in one image.
struct FitView {
  std::size_t camera = 0;                    ///< index into Fit::cameras
  std::size_t board = 0;                     ///< index into Fit::boards
  std::size_t placement = 0;                 ///< of its body, index into Fit::placements
  std::size_t source = 0;                    ///< index of the view among the input views
  std::vector<Observation> corners = {};     ///< in use, in ascending order of id; on the flat board
  std::vector<Eigen::Vector2d> errors = {};  ///< projected minus observed, px, not weighted; set by solve()
  std::string image = {};                    ///< its name; may be empty
  Eigen::Vector2d flex_m{0, 0};              ///< bend_x and bend_y that the board has in this view only
  std::optional<PoseDeviation> deviation = {};
};

enum class Termination {
  kConverged,
  kIterationLimit,
  kStalled,  ///< no step reduces the cost, although the point is not stationary
  kFailed,   ///< the initial guess cannot be evaluated, or the linear algebra failed
};

/// Stable name for files and JSON.
[[nodiscard]] std::string_view terminationName(Termination termination);

/// A parameter of one camera of a fit.
struct FitParam {
  std::size_t camera = 0;
  int index = 0;
  friend bool operator==(const FitParam&, const FitParam&) = default;
};

struct SolveSummary {
  Termination termination = Termination::kFailed;
  std::string reason = {};              ///< message of the solver
  int num_iterations = 0;               ///< steps tried
  std::vector<FitParam> at_limit = {};  ///< parameters at the end of their range
  /// Half the sum of rho over all corners, px^2 of a corner of weight 1, including the priors; NaN if the
  /// initial guess cannot be evaluated.
  double cost = 0;
};

/// The input and the result of a solve: cameras, boards, placements of the boards, and observed
/// corners.
struct Fit {
  std::vector<FitCamera> cameras = {};
  std::vector<FitBoard> boards = {};
  std::vector<FitPlacement> placements = {};
  std::vector<FitView> views = {};
  HuberLoss loss = kNoLoss;
  SolveSummary summary = {};
};

/// The deviation of a view that has one, as a tangent of camera_from_board.
[[nodiscard]] SE3::Tangent deviationTangent(const Fit& fit, const FitView& view);

/// The pose of the board in the rig, without the view's deviation.
[[nodiscard]] SE3 rigFromBoard(const Fit& fit, const FitView& view);
/// The pose of the board in the camera frame.
[[nodiscard]] SE3 cameraFromBoard(const Fit& fit, const FitView& view);
/// Where the image shows a corner of the fit, px, also with a correction field.
[[nodiscard]] Eigen::Vector2d seenPixel(const FitCamera& camera, const Eigen::Vector2d& of_corner);
/// Moves the placement of the view; the camera keeps its place in the rig, and the view its deviation.
void setCameraFromBoard(Fit& fit, const FitView& view, const SE3& camera_from_board);

/// The only camera, or the only board, of a fit.
/// @throws std::logic_error if there are several
template <class AnyFit>
requires std::is_same_v<const AnyFit, const Fit>
[[nodiscard]] auto& onlyCamera(AnyFit& fit) {
  expect(fit.cameras.size() == 1, "the fit has one camera");
  return fit.cameras.front();
}
/// The same as a camera that projects.
[[nodiscard]] AnyCamera cameraOf(const Fit& fit);
template <class AnyFit>
requires std::is_same_v<const AnyFit, const Fit>
[[nodiscard]] auto& onlyBoard(AnyFit& fit) {
  expect(fit.boards.size() == 1, "the fit has one board");
  return fit.boards.front();
}

[[nodiscard]] inline const FitBoard& boardOf(const Fit& fit, const FitView& view) {
  return fit.boards[view.board];
}

/// " (SPEC)" to append to the name of a board or view; empty for the only board of a fit.
[[nodiscard]] std::string boardSuffix(const Fit& fit, std::size_t board);

/// True if any board is uneven.
[[nodiscard]] bool isAnyUneven(const Fit& fit);

/// True if any board bends differently in each view.
[[nodiscard]] bool isAnyFlexible(const Fit& fit);

/// Number of offset coordinates of all boards, and bends of single views, that the corners determine.
[[nodiscard]] double numFreeOffsets(const Fit& fit);

/// The views of each placement; those of a body may show different boards.
[[nodiscard]] std::vector<std::vector<std::size_t>> viewsOfPlacements(const Fit& fit);

/// The number of views that show a board.
[[nodiscard]] std::size_t numViews(const Fit& fit, std::size_t board);

/// Fixes the present bend of all boards.
void fixShapes(Fit& fit);

/// Corners with their positions on the bent board, as used by the solver.
[[nodiscard]] std::vector<Observation> onShape(const Board& board, const BoardShape& shape,
                                               std::span<const Observation> flat);
[[nodiscard]] std::vector<Observation> cornersOnShape(const Fit& fit, const FitView& view);

/// Takes the boards as rigid.
void stiffen(Fit& fit);

/// The board's shape in a view, with the bend that it has there only.
[[nodiscard]] BoardShape shapeIn(const FitBoard& board, const FitView& view);

/// The number of corners in all views.
[[nodiscard]] std::size_t numCorners(const Fit& fit);

/// The cost without the prior, for a fit of one camera.
[[nodiscard]] double cornersCost(const Fit& fit);

/// Adds a view of the first camera, in a separate frame. Views stay sorted by source.
/// @param source  see FitView
/// @param board   index into Fit::boards
void addView(Fit& fit, std::size_t source, std::vector<Observation> corners, const SE3& camera_from_board,
             std::size_t board = 0);

/// A fit of one camera without views.
[[nodiscard]] Fit emptyFit(std::string model, ImageSize size, std::vector<double> params,
                           std::span<const Board> boards, HuberLoss loss);
[[nodiscard]] Fit emptyFit(std::string model, ImageSize size, std::vector<double> params, const Board& board,
                           HuberLoss loss);

/// The fit without some views, and without placements that no remaining view uses.
/// @param is_out  one per view
[[nodiscard]] Fit withoutViews(const Fit& fit, const std::vector<bool>& is_out);
[[nodiscard]] Fit withoutView(const Fit& fit, std::size_t view);

/// Sets the weights of all corners from the noise of their camera; returns the largest relative change.
double updateWeights(Fit& fit);

}  // namespace alidade
