// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "alidade/record/camera_record.h"

namespace alidade {

/// Writes a camera file, so that a reader sees the old file or the whole new one. Formats of other tools hold
/// the camera and the size of its images alone, exactly: the file is read back before it is written.
/// @param format  id as `alidade convert --to` takes it: "alidade", "opencv", "ros", "kalibr", ...; the
/// extension of
///                `path` decides where a format has several notations
/// @throws Error (kUsage) for an unknown format, naming the known ones; Error (kInput) for a camera that the
/// format cannot hold exactly, or a file that cannot be written
void saveCamera(const std::string& path, const CameraRecord& record, std::string_view format = "alidade");

}  // namespace alidade
