// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "alidade/record/camera_record.h"

namespace alidade {

/// The text that saveCamera() writes to a file of this name.
[[nodiscard]] std::string cameraText(const CameraRecord& record, std::string_view format,
                                     const std::string& path = "");

/// Writes a camera file atomically. Formats of other tools contain only the camera and the image size. The
/// camera must be representable exactly; the text is read back before the file is written.
/// @param format  id as for `alidade convert --to`: "alidade", "opencv", "ros", "kalibr", ...; if a format
///                has several notations, the extension of `path` selects one
/// @throws Error (kUsage) for an unknown format, naming the known ones; Error (kInput) for a camera that is
/// not exactly representable by the format, or a file that cannot be written
void saveCamera(const std::string& path, const CameraRecord& record, std::string_view format = "alidade");

}  // namespace alidade
