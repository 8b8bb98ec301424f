// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"

namespace alidade {

/// Columns of the unknowns of a fit in its equations: the parameters of each camera, then camera_from_rig
/// (SE3's tangent) of each camera that is not fixed, then the bends of the boards whose bend is estimated,
/// then on request the offsets of uneven boards. The placements are eliminated, with the bends that a
/// flexible board has in each.
struct JointColumns {
  std::vector<int> params;   ///< first column of each camera's parameters
  std::vector<int> pose;     ///< of each camera's pose; -1 for a fixed one
  std::vector<int> bend;     ///< of each board's bends; -1 for a fixed one
  std::vector<int> offsets;  ///< of each board's offsets, three per point; -1 for an even board
  int count = 0;
};
enum class Offsets { kLeaveOut, kInclude };
[[nodiscard]] JointColumns jointColumns(const Fit& fit, Offsets offsets = Offsets::kLeaveOut);

/// Calls `visit` with the normal equations of each frame in turn. Frames are independent of each other; views
/// of one frame are not. Priors are not included.
void forEachFrame(const Fit& fit, const JointColumns& columns, LossWeights weights,
                  const std::function<void(const Reduced&)>& visit);

/// The equations of all frames, without the weights of the loss.
[[nodiscard]] std::vector<Reduced> jointInformation(const Fit& fit, const JointColumns& columns);

/// Free directions in these columns, one per column. Those of each lens are combined so that its corners
/// determine each equally well: nearly compensating parameters of a lens would otherwise cost the whole rig
/// its numerical accuracy.
/// @param information  with these columns
[[nodiscard]] Eigen::MatrixXd jointDirections(const Fit& fit, const JointColumns& columns,
                                              const Eigen::MatrixXd& information);

}  // namespace alidade
