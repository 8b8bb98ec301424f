// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "alidade/files/camera_file.h"

namespace CLI {
class App;
}

namespace alidade {

/// Gives the command's flags that were not given by hand the values in a settings file.
/// @throws Error (kInput) for a key that is no flag of the command, or a value it does not take
void applySettingsFile(CLI::App& app, const std::string& path);

/// The flags and values in force, without those that cannot change the result (--jobs, --quiet, ...) and
/// without the inputs, in order of name.
[[nodiscard]] std::vector<Setting> effectiveSettings(const CLI::App& app);

}  // namespace alidade
