// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/record/camera_record.h"

namespace alidade {

/// Reads a camera file strictly: unknown, missing, duplicate and misspelt keys, wrong types, numbers that are
/// not finite and unknown models are errors that name line, key, found and expected. Only the first four keys
/// are needed. The file has to pass its own self-check, see requireSelfCheck().
/// @throws Error (kInput)
[[nodiscard]] CameraRecord readCameraFile(const std::string& path);

/// The same from text; `name` stands for the file in messages.
[[nodiscard]] CameraRecord parseCameraFile(const std::string& text, const std::string& name);

/// Passes if the camera projects the file's self-check points to their pixels (none: nothing to compare), so
/// that a number changed by hand is not used silently.
/// @throws Error (kInput) with the worst point and by how much it is off
void requireSelfCheck(const CameraRecord& file, const std::string& where);

/// The file as text, with every number in the fewest digits that read back as the same double.
[[nodiscard]] std::string cameraFileText(const CameraRecord& file);

/// Writes atomically. @throws Error (kInput)
void writeCameraFile(const std::string& path, const CameraRecord& file);

}  // namespace alidade
