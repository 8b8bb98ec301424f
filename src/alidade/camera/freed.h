// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// What whoever uses the camera fits anyway, so that an error of the parameters that looks like it does no
/// harm.
enum class Freed {
  kRotation,  ///< the camera's orientation
  kPose,      ///< orientation and position
};

}  // namespace alidade
