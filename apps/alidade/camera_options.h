// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/camera_source.h"

namespace CLI {
class App;
}

namespace alidade {

/// What a user can add to a camera file of another tool that leaves things open.
struct CameraOptions {
  std::string size;     ///< "640x480"; empty = the file says
  std::string read_as;  ///< model; empty = the file says

  /// @throws Error (kUsage) for a size that is none
  [[nodiscard]] ReadOptions readOptions() const;
};

/// The one camera of a file of any format. What was passed over or assumed in reading it is told, unless
/// `quiet`.
[[nodiscard]] CameraRecord readCameraTelling(const std::string& path, const ReadOptions& options, bool quiet);

/// The flags --image-size and --read-as.
void addCameraOptions(CLI::App& app, CameraOptions& options);

}  // namespace alidade
