// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"

namespace alidade {

/// What a calibration takes for exact, the same in all views. The first kNumBoardCauses are mistakes of a
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

/// One further column for each cause, in the order of CommonCause: first those of each board in turn, then
/// the others. For the views of one board; the columns of other boards are zero.
class CommonColumns {
 public:
  /// @param board  index of the board that the view shows
  CommonColumns(const Fit& fit, std::size_t board)
      : first_(kNumBoardCauses * static_cast<int>(board)),
        num_board_columns_(kNumBoardCauses * static_cast<int>(fit.boards.size())),
        middle_(fit.boards[board].target.middle()),
        focal_{onlyCamera(fit).params[0], onlyCamera(fit).params[1]} {}

  [[nodiscard]] int size() const {
    return num_board_columns_ + static_cast<int>(kCommonCauses.size()) - kNumBoardCauses;
  }
  [[nodiscard]] ExtraElements<kCommonCauses.size()> elements(const CornerRows& rows, int axis) const {
    // A point of the board moves as by a translation of the pose.
    using Row = Eigen::Map<const Eigen::RowVector3d>;
    const auto at = static_cast<std::size_t>(axis);
    const Row J(rows.J_px_pose[at]);
    const Eigen::Vector3d& p = rows.corner.p_board;
    const Eigen::Vector3d out = p - middle_;
    const double X = out.x() / middle_.x();
    const double Y = out.y() / middle_.y();
    const Eigen::Vector3d p_cam = rows.camera_from_board * p;
    const double angle = std::atan2(p_cam.head<2>().norm(), p_cam.z());
    const Eigen::Vector3d optical_axis = rows.camera_from_board.rotation.matrix().row(2);
    const double distance_m = (rows.camera_from_board * middle_).norm();
    const double* by_params = rows.J_px_params[at];
    const double outward = std::hypot(Row(rows.J_px_pose[0]).dot(out), Row(rows.J_px_pose[1]).dot(out));
    const int rest = num_board_columns_;
    return {.column = {first_, first_ + 1, first_ + 2, first_ + 3, rest, rest + 1, rest + 2},
            .value = {J[0] * p.x(), J[0] * middle_.x() * X * X, J[1] * middle_.y() * Y * Y,
                      J[2] * middle_.x() * X * Y, -angle * angle * J.dot(optical_axis),
                      (focal_[0] * by_params[0] + focal_[1] * by_params[1]) / distance_m,
                      outward > 0 ? rows.root_weight * (X * X + Y * Y) * J.dot(out) / outward : 0.0}};
  }

 private:
  int first_;
  int num_board_columns_;
  Eigen::Vector3d middle_;
  std::array<double, 2> focal_;
};

/// The normal equations of each view with CommonColumns and the loss' weights, for the functions below.
[[nodiscard]] std::vector<Reduced> viewScores(const Fit& fit);

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

/// Each of the errors that explains the corners best, to first order (one step of Gauss and Newton with
/// intrinsics and poses following). One cause may look like several: the most significant is taken into
/// account in the estimates of the others, then the next, until no other is significant. The sigma is the
/// larger of that by the corners' noise and that by how much the views disagree (White 1980, A
/// heteroskedasticity-consistent covariance matrix estimator, by view), which a lens that does not follow its
/// model raises. Without those that the views do not determine.
/// @param scores  see viewScores()
/// @param directions  what is free among the intrinsics, see freeDirections()
/// @param flexible  the same for a flexibleFit() of a stiff model, whose deviations from the lens would look
/// like one of these errors; empty for other models
/// @param variance  of the coordinate of a corner of weight 1, px^2
/// @param smoothness  the errors over those that neighbours do not share, at least 1: a lens that deviates
/// from its model errs alike in all views, so that they agree on it; the sigma is larger by this
[[nodiscard]] std::vector<CommonError> commonErrors(std::span<const Reduced> scores,
                                                    const Eigen::MatrixXd& directions,
                                                    std::span<const Reduced> flexible, double variance,
                                                    double smoothness);

/// What leaving out one view would do, to first order.
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

/// One a view (Cook 1977, Detection of influential observation in linear regression, for blocks). Empty where
/// the views do not determine the intrinsics. What a view determines all by itself, no other disagrees with.
[[nodiscard]] std::vector<ViewInfluence> viewInfluences(std::span<const Reduced> scores,
                                                        const Eigen::MatrixXd& directions, double variance);

}  // namespace alidade
