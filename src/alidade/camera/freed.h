// SPDX-License-Identifier: MIT
#pragma once

namespace alidade {

/// What users of a camera estimate themselves. Parameter errors that are equivalent to it do no harm.
enum class Freed {
  kRotation,  ///< the camera's orientation
  kPose,      ///< orientation and position
};

}  // namespace alidade
