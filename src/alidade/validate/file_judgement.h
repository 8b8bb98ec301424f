// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "alidade/files/camera_source.h"
#include "alidade/validate/file_check.h"

namespace alidade {

/// What was found out about a camera of a file.
struct CameraJudgement {
  std::string name;                     ///< selects it after FILE#: its name, or its number
  std::optional<AnyCamera> camera;      ///< nothing: its model is not supported
  std::optional<ImageSize> image_size;  ///< px; nothing: the file does not state it
  std::vector<FileCheck> checks;        ///< at least one
  bool can_show_slips = false;  ///< the file itself, or what it was compared with, can show a wrong number

  /// The most severe of its checks.
  [[nodiscard]] Severity severity() const;
};

/// What was found out about a file.
struct FileJudgement {
  std::string file;                      ///< as given; may end in "#NAME"
  std::string format;                    ///< id; empty: it cannot be read
  std::string error;                     ///< why it cannot be read; empty: it can
  std::vector<CameraJudgement> cameras;  ///< in the file's order; none if it cannot be read

  /// The most severe of all checks; a failure if the file cannot be read.
  [[nodiscard]] Severity severity() const;
};

/// Checks a camera of `file` by itself.
[[nodiscard]] CameraJudgement judgeCamera(const StatedCamera& stated, const std::string& file);

/// The judgement of a camera that is not supported, in a file with others.
[[nodiscard]] CameraJudgement judgeRefused(const RefusedCamera& camera, const std::string& file);

/// `message` without the path that it begins with: "cam.yaml:4: fx: found ..." becomes "line 4: fx: found
/// ...".
[[nodiscard]] std::string withoutPath(const std::string& message, const std::string& file);

}  // namespace alidade
