// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "alidade/camera/any_camera.h"
#include "alidade/validate/file_check.h"

namespace alidade::detail {

/// A camera and the image size in pixels to check it by.
struct CheckedNumbers {
  const AnyCamera& camera;
  ImageSize size;
  bool is_size_guessed = false;  ///< the file does not state the size
  /// The numbers are those that Alidade wrote: the self-check proves it. A principal point far from the
  /// centre is then the camera of a part of an image.
  bool is_proven = false;
};

/// Whether the focal lengths are possible for the image size: a field of view between 0.2 and 170 degrees.
[[nodiscard]] FileCheck checkFocalLength(const CheckedNumbers& numbers);

/// Whether pixels are about square.
[[nodiscard]] FileCheck checkAspect(const CheckedNumbers& numbers);

/// Whether the principal point fits the image. It does not if it fits only with cx and cy swapped, or only an
/// image of another size, or if it lies outside the image.
[[nodiscard]] FileCheck checkPrincipalPoint(const CheckedNumbers& numbers);

/// Whether the principal point fits that of the rectified images, px, which ROS files state too.
[[nodiscard]] FileCheck checkProjectionMatrix(const CheckedNumbers& numbers,
                                              const Eigen::Vector2d& rectified_center);

/// Whether p1 and p2 are possible; std::nullopt for models without them.
[[nodiscard]] std::optional<FileCheck> checkTangential(const CheckedNumbers& numbers);

/// Which share of the image has a ray.
[[nodiscard]] FileCheck checkOneToOne(const CheckedNumbers& numbers, const DomainCertificate& domain);

}  // namespace alidade::detail
