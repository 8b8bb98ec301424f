// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/rig/joint_views.h"
#include "alidade/rig/rig_calibration.h"

namespace alidade {

/// Links parts of a rig whose cameras never see one board at the same time, through boards that are fixed to
/// each other: those of a room in which the rig moves, or of a body that moves before fixed cameras. Boards
/// of one body are found where a part sees two of them in several frames. Parts that see different boards of
/// one body at the same time are then linked as if by one board. The rest are linked by motion: the pose of
/// part Q and of board L follow from those of part P and board K, as for a camera on a robot, where the turns
/// of K before P are about more than one axis.
///
/// Changes the parts, camera_from_rig and the bodies; leaves parts apart that contradict, or turn too little:
/// then `little_motion` tells about the one that turns most.
void linkByMotion(JointViews& views);

/// The turns of bodies of several boards, in the rig's frame.
[[nodiscard]] RigTurns turnsOf(const Fit& fit);

/// "by 20 degrees about the vertical axis (y) of left, and by 3 degrees about others".
[[nodiscard]] std::string turnsText(const RigTurns& turns, const std::string& camera);

}  // namespace alidade
