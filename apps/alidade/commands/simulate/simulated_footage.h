// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "alidade/core/cancel.h"
#include "alidade/simulate/footage_simulator.h"
#include "pending_folder.h"

namespace alidade {

/// Writes camera.yaml, poses.yaml, trajectory.txt, tracks.csv and, if requested, images/*.png.
/// @param tracks  of the simulator
/// @throws Error (kInput) for files that cannot be written; Cancelled once `cancel` is raised
void writeFootage(const FootageSimulator& simulator, const std::vector<TrueTrack>& tracks,
                  const PendingFolder& folder, bool with_images, bool is_quiet, const CancelFlag* cancel);

}  // namespace alidade
