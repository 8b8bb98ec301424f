// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "alidade/core/cancel.h"
#include "alidade/simulate/footage_simulator.h"
#include "pending_folder.h"

namespace alidade {

struct FootageOutput {
  bool with_images = true;
  bool is_quiet = false;
};

struct FootageCounts {
  std::size_t num_tracks = 0;
  std::size_t num_pixels = 0;  ///< of all tracks
};

/// Writes camera.yaml, poses.yaml, trajectory.txt, tracks.csv and images/*.png.
/// @throws Error (kInput) for files that cannot be written; Cancelled once `cancel` is raised
FootageCounts writeFootage(const FootageSimulator& simulator, const PendingFolder& folder,
                           const FootageOutput& output, const CancelFlag* cancel);

}  // namespace alidade
