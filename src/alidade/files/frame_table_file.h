// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/target/frame_table.h"

namespace alidade {

/// Reads a CSV table of images that were taken at the same time: the header names the cameras, a row is a
/// frame, an empty field is a camera without an image. Lines that start with '#' and empty lines are skipped.
/// @throws Error (kInput) that names the line
[[nodiscard]] FrameTable readFrameTable(const std::string& path);

}  // namespace alidade
