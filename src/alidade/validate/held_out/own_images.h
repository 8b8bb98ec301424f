// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "alidade/geometry/se3.h"
#include "alidade/record/camera_record.h"
#include "alidade/target/checkerboard.h"
#include "alidade/validate/camera_checks.h"
#include "alidade/validate/held_out/held_out_images.h"

namespace alidade {

/// Whether a view has the board where the other has it: its middle within 2 % of its distance and its
/// orientation within 0.02 rad, from whichever end or side of the board its corners are counted.
///
/// The same corners lead a file's own camera to the recorded pose far more exactly, but the camera that is
/// tested may have been edited: 1 % in the focal length moves the board by 1 %, 5 px in the principal point
/// of a 640x480 camera turn it by 0.01 rad. Two photographs that are held by hand hardly ever agree that well
/// in all six numbers; on a tripod before a board that stands they do, and then they are as good as the same.
[[nodiscard]] bool isSameBoardPose(const Checkerboard& board, const SE3& camera_from_board,
                                   const SE3& other_from_board);

/// The check `held_out_names`: whether images are those that the camera was made from, which is so where both
/// name (without folders) and pose of the board are those of a view that the file records.
/// @param recorded  the file's views, at least one
/// @param views     of the images, as the tested camera sees them
/// @param num_given  images with a board
[[nodiscard]] Diagnosis ownImagesCheck(std::span<const ViewRecord> recorded, const Checkerboard& board,
                                       std::span<const HeldOutView> views, int num_given);

}  // namespace alidade
