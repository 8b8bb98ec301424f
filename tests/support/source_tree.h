// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace alidade {

/// Path of a file or folder of this project, such as "testdata/checkerboard/camera.yaml".
[[nodiscard]] std::string sourcePath(std::string_view name);

}  // namespace alidade
