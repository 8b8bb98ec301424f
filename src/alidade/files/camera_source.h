// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "alidade/files/formats/stated_camera.h"
#include "alidade/record/camera_record.h"

namespace alidade {

/// All cameras that a file of some format states.
struct CameraSource {
  std::string path;                   ///< without "#NAME"
  std::string_view format;            ///< id: "ros"
  std::string_view format_name;       ///< for people: "ROS camera_info (YAML)"
  std::vector<StatedCamera> cameras;  ///< at least one, but with ReadOptions::only
  /// Beside them in the file; none where one camera was named.
  std::vector<RefusedCamera> refused = {};
};

/// `path` without "#NAME".
[[nodiscard]] std::string cameraFilePath(const std::string& path);

/// Reads a camera file of any format (cameraFormats), which its content tells. `path` may end in "#NAME" to
/// mean one camera of several, by its name or its number from 0.
/// @throws Error (kInput) for a file that cannot be read, of no known format, with contents that are no
/// camera, or without the camera that is asked for, naming what there is; for a file of this program that
/// fails its own self-check, see requireSelfCheck()
[[nodiscard]] CameraSource loadCameras(const std::string& path, const ReadOptions& options = {});

/// The same without the self-check: for who reports on files as they are, and for nobody who computes with
/// their cameras.
[[nodiscard]] CameraSource readCamerasToJudge(const std::string& path, const ReadOptions& options = {});

/// What the content of a file says that it is.
enum class FileKind {
  kCamera,   ///< of a known format; whether it is right is for loadCameras to tell
  kOther,    ///< text of no known format
  kDamaged,  ///< cannot be read, or is not what its extension says
};
[[nodiscard]] FileKind kindOfFile(const std::string& path);

/// The same from text; `name` stands for the file in messages.
[[nodiscard]] CameraSource parseCameras(const std::string& text, const std::string& name,
                                        const ReadOptions& options = {});

/// How FILE#... calls a camera of a file: its name, or its number.
[[nodiscard]] std::string cameraLabel(const StatedCamera& camera);
[[nodiscard]] std::string cameraLabel(const RefusedCamera& camera);

/// Passes if all cameras of the source are supported.
/// @throws Error (kInput) with the names of those that are not
void requireAll(const CameraSource& source);

/// The one camera of a file, in this program's own terms. Errors of loadCameras; Error (kInput) too if there
/// are several, supported or not, or if neither the file nor `options` says how large the image is.
[[nodiscard]] CameraRecord loadCamera(const std::string& path, const ReadOptions& options = {});

/// The only camera of a source, in this program's own terms; errors as of loadCamera.
[[nodiscard]] CameraRecord onlyCamera(const CameraSource& source);

/// A stated camera as a camera file; `where` is for messages. @throws Error (kInput) without an image size
[[nodiscard]] CameraRecord recordOf(const StatedCamera& camera, const std::string& where);

}  // namespace alidade
