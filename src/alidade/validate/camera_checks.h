// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "alidade/record/camera_record.h"
#include "alidade/validate/file_check.h"

namespace alidade {

/// What to bear in mind about the file that a record comes from.
struct RecordContext {
  bool is_size_guessed = false;  ///< the file does not state `image_size`; see sizeAround()
  /// The principal point of the rectified images, px, if the file states it.
  std::optional<Eigen::Vector2d> rectified_center = std::nullopt;
};

/// Checks the numbers of a camera: focal lengths, aspect, principal point, tangential coefficients, and which
/// share of the image has a ray. Checks what the record states beside them: the domain, self-check points,
/// the covariance, the uncertainty of pixels, and the verdict of the calibration. What is not stated has no
/// check.
[[nodiscard]] std::vector<FileCheck> checkCamera(const CameraRecord& record,
                                                 const RecordContext& context = {});

/// The image size, px, to check a camera by if its file does not state one: its principal point is the
/// centre.
[[nodiscard]] ImageSize sizeAround(const AnyCamera& camera);

}  // namespace alidade
