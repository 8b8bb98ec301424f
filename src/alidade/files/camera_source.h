// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "alidade/files/formats/stated_camera.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// `path` without "#NAME".
[[nodiscard]] std::string cameraFilePath(const std::string& path);

/// Reads a camera file of any format in docs/formats.md; the format is detected from the content. `path` may
/// end in "#NAME" to select one camera of several, by its name or its number from 0.
/// @throws NotACameraFile for a file that is not a camera file; Error (kInput) for a file that cannot be
/// read, has no known format although it names a camera, contains no camera, lacks the selected camera (the
/// message lists the available ones), or fails its self-check (its points do not project to its pixels)
[[nodiscard]] CameraSource loadCameras(const std::string& path, const ReadOptions& options = {});

/// The same without the self-check, for reports about files. Do not compute with these cameras.
[[nodiscard]] CameraSource readCamerasToJudge(const std::string& path, const ReadOptions& options = {});

/// The same from text; messages use `name` as the file name.
[[nodiscard]] CameraSource parseCameras(const std::string& text, const std::string& name,
                                        const ReadOptions& options = {});

/// True if a format recognises the file, for folders with files of any kind; large files are none.
[[nodiscard]] bool hasCameraFormat(const std::string& path);

/// Checks that all cameras of the source are supported.
/// @throws Error (kInput) with the names of the unsupported ones
void requireAll(const CameraSource& source);

/// The only camera of a file, as a record. Throws like loadCameras(), and Error (kInput) if there are several
/// cameras, supported or not, or if neither the file nor `options` states the image size.
[[nodiscard]] CameraRecord loadCamera(const std::string& path, const ReadOptions& options = {});

/// The only camera of a source, as a record; throws like loadCamera().
[[nodiscard]] CameraRecord onlyCamera(const CameraSource& source);

/// A stated camera as a record; `where` is for messages. @throws Error (kInput) without an image size
[[nodiscard]] CameraRecord recordOf(const StatedCamera& camera, const std::string& where);

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
