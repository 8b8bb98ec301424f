// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "alidade/files/camera_source.h"
#include "commands/rig/rig_diff.h"

namespace alidade {

/// Compares each camera or rig of folder A with that of folder B. Then follow those that only one folder has,
/// and files that cannot be read.
/// @param diff_files  compares two files, "FILE#NAME" too
/// @throws Error (kInput) if neither folder has a camera file
[[nodiscard]] std::vector<DiffResult> diffFolders(
    const std::string& folder_a, const std::string& folder_b, const ReadOptions& options,
    const std::function<DiffResult(const std::string&, const std::string&)>& diff_files);

}  // namespace alidade
