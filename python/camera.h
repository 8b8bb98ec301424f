// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "alidade/geometry/se3.h"
#include "alidade/record/camera_record.h"
#include "arrays.h"

namespace alidade::python {

/// A camera in Python: the content of a camera file, and assumptions made in reading it. Immutable.
struct CameraValue {
  CameraRecord record;
  std::vector<std::string> remarks = {};
  std::optional<SE3> camera_from_rig = {};  ///< for a camera of a rig
};

/// Creator stated in files that Python writes, like those of the program.
[[nodiscard]] std::string creatorName();

/// The parameters by name, as a dict in storage order.
[[nodiscard]] py::dict parametersDict(const AnyCamera& camera);

}  // namespace alidade::python
