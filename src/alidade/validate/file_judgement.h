// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "alidade/files/camera_source.h"
#include "alidade/validate/camera_checks.h"

namespace alidade {

/// What was found out about a camera of a file, or about a file that cannot be read.
struct FileJudgement {
  std::string file;    ///< "rig.yaml", or "rig.yaml#cam1" where it holds several
  std::string format;  ///< id; empty = cannot be read
  std::string model;
  std::string size;  ///< "640x480"; empty = not stated
  std::vector<Diagnosis> checks;
  bool can_show_slips = false;  ///< the file itself, or what it was compared with, can show a wrong number

  [[nodiscard]] std::size_t count(Severity status) const;
  [[nodiscard]] bool isReadable() const { return !format.empty(); }
  [[nodiscard]] bool isValid() const { return count(Severity::kFailure) == 0; }
};

/// Every check of a camera of `source` by itself.
[[nodiscard]] FileJudgement judgeCamera(const CameraSource& source, std::size_t index);

/// The judgement of a camera that is not supported, beside others of its file.
[[nodiscard]] FileJudgement judgeRefused(const CameraSource& source, const RefusedCamera& camera);

/// The judgement of a file that cannot be read, with the reason.
[[nodiscard]] FileJudgement judgeUnreadable(const std::string& path, const std::string& reason);

}  // namespace alidade
