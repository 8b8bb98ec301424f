// SPDX-License-Identifier: MIT
#include "alidade/rig/joint_fit.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <vector>

#include "alidade/adjust/noise/covariance.h"
#include "alidade/adjust/noise/joint_information.h"
#include "alidade/core/statistics.h"

namespace alidade {
namespace {

constexpr int kTangent = 6;
constexpr std::size_t kFewestFrames = 3;  // of the camera, on each side of a step

// The unknowns of a rig, including the first camera's pose.
Fit withAllPosesFree(Fit fit) {
  for (FitCamera& camera : fit.cameras) camera.is_rig_pose_fixed = false;
  return fit;
}

// For each camera and frame, in ascending order: true if the camera sees a board with a second one.
std::vector<std::vector<bool>> linkedFrames(const Fit& fit, const std::set<std::size_t>& frames) {
  std::vector<std::vector<bool>> is_linked(fit.cameras.size(), std::vector<bool>(frames.size()));
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(fit)) {
    if (of_placement.size() < 2) continue;
    const std::size_t frame = fit.placements[fit.views[of_placement.front()].placement].frame;
    const auto rank = static_cast<std::size_t>(std::distance(frames.begin(), frames.find(frame)));
    for (const std::size_t v : of_placement) is_linked[fit.views[v].camera][rank] = true;
  }
  return is_linked;
}

// In the result, first_frame is a rank among the frames.
// @param is_linked  see linkedFrames()
PoseStep likeliestStep(const std::vector<Reduced>& frames, const std::vector<std::vector<bool>>& is_linked,
                       const JointColumns& columns, const Eigen::MatrixXd& free,
                       const Eigen::MatrixXd& inverse, double variance) {
  PoseStep best;
  for (std::size_t c = 0; c < columns.pose.size(); ++c) {
    const Eigen::Index at = columns.pose[c];
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(kTangent, columns.count);
    Eigen::Matrix<double, kTangent, 1> score = Eigen::Matrix<double, kTangent, 1>::Zero();
    auto num_before = static_cast<std::size_t>(std::ranges::count(is_linked[c], true));
    std::size_t num_after = 0;
    for (std::size_t f = frames.size(); f-- > 0;) {
      if (is_linked[c][f]) {
        --num_before;
        ++num_after;
      }
      rows += frames[f].information.middleRows<kTangent>(at);
      score += frames[f].gradient.segment<kTangent>(at);
      if (std::min(num_before, num_after) < kFewestFrames) continue;
      const Eigen::MatrixXd mixed = rows * free;
      const Eigen::MatrixXd own = rows.middleCols<kTangent>(at) - mixed * inverse * mixed.transpose();
      const ScaledInverse covariance = scaledInverse(own);
      if (!covariance.inverse) continue;
      const Eigen::Matrix<double, kTangent, 1> tangent = -*covariance.inverse * score;
      const double mean_square = -tangent.dot(score) / (kTangent * variance);
      if (!(mean_square > 0)) continue;
      const double normal = normalOfMeanSquare(mean_square, kTangent);
      if (normal > best.normal) best = {.camera = c, .first_frame = f, .tangent = tangent, .normal = normal};
    }
  }
  return best;
}

}  // namespace

std::optional<PoseStep> likeliestPoseStep(const Fit& given, double variance) {
  constexpr double kSure = 4.5;  // by chance once in 300000 tests; a rig needs a few hundred
  const Fit fit = withAllPosesFree(given);
  const JointColumns columns = jointColumns(fit);
  const std::vector<Reduced> frames = jointInformation(fit, columns);
  std::set<std::size_t> in_order;
  for (const FitPlacement& placement : fit.placements) in_order.insert(placement.frame);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(columns.count, columns.count);
  for (const Reduced& frame : frames) information += frame.information;
  // All unknowns are free except the pose of the first camera.
  const Eigen::MatrixXd all = jointDirections(fit, columns, information);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < all.cols(); ++i) {
    if (all.col(i).segment<kTangent>(columns.pose.front()).isZero(0)) kept.push_back(i);
  }
  const Eigen::MatrixXd free = all(Eigen::seqN(0, all.rows()), kept);
  const ScaledInverse inverse = scaledInverse(free.transpose() * information * free);
  if (!inverse.inverse) return std::nullopt;
  PoseStep step =
      likeliestStep(frames, linkedFrames(fit, in_order), columns, free, *inverse.inverse, variance);
  if (step.normal < kSure) return std::nullopt;
  step.first_frame = *std::next(in_order.begin(), static_cast<std::ptrdiff_t>(step.first_frame));
  return step;
}

}  // namespace alidade
