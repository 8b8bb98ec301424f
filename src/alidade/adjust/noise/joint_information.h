// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "alidade/adjust/board/reduced.h"

namespace alidade {

/// Columns of the unknowns of a fit in its equations: the parameters of each camera, then camera_from_rig
/// (SE3's tangent) of each camera that is not fixed, then body_from_board (SE3's tangent) of each board that
/// is not fixed, then the bends of the boards whose bend is estimated, then the delays of cameras that are
/// not fixed, then on request the offsets of uneven boards. The placements are eliminated, with the bends
/// that a flexible board has in each and the scatter of views that deviate from them.
struct JointColumns {
  std::vector<int> params;   ///< first column of each camera's parameters
  std::vector<int> pose;     ///< of each camera's pose; -1 for a fixed one
  std::vector<int> body;     ///< of each board's place in its body; -1 for a fixed one
  std::vector<int> bend;     ///< of each board's bends; -1 for a fixed one
  std::vector<int> delay;    ///< of each camera's delay; -1 for a fixed one
  std::vector<int> offsets;  ///< of each board's offsets, three per point; -1 for an even board
  int num_others = 0;        ///< number of columns before the offsets
  int count = 0;
};
enum class Offsets { kLeaveOut, kInclude };
[[nodiscard]] JointColumns jointColumns(const Fit& fit, Offsets offsets = Offsets::kLeaveOut);

/// The equations of each frame, without the weights of the loss. Frames are independent of each other; views
/// of one frame are not. Priors are not included.
[[nodiscard]] std::vector<Reduced> jointInformation(const Fit& fit, const JointColumns& columns);

/// A symmetric matrix over the offsets: in full, or 3 x 3 blocks for each point in turn and the product of
/// some rows with themselves. These are few if there are few views.
struct OffsetMatrix {
  Eigen::MatrixXd full = {};
  Eigen::MatrixXd blocks = {};
  Eigen::MatrixXd roots = {};
  double sign = 1;  ///< of the product

  [[nodiscard]] Eigen::MatrixXd times(const Eigen::MatrixXd& X) const;
  [[nodiscard]] Eigen::VectorXd diagonal() const;
};

/// The equations of all frames together.
struct JointEquations {
  Eigen::MatrixXd information;  ///< of all unknowns with those before the offsets
  OffsetMatrix of_offsets;      ///< the information of the offsets with each other
  Eigen::VectorXd gradient;
};
[[nodiscard]] JointEquations jointEquations(const Fit& fit, const JointColumns& columns, LossWeights weights);

/// Free directions in these columns, one per column. Those of each lens are combined so that its corners
/// determine each equally well: nearly compensating parameters of a lens would otherwise cost the whole rig
/// its numerical accuracy.
/// @param information  with these columns
[[nodiscard]] Eigen::MatrixXd jointDirections(const Fit& fit, const JointColumns& columns,
                                              const Eigen::MatrixXd& information);

}  // namespace alidade
