// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace alidade {

/// Names of the output images in one folder, by the images' short names: the same with the extension .png, or
/// as it is for JPEG files; folders become a part of the name. Where that would be the same for several
/// images, these keep their own extension before .png.
/// @throws Error (kInput) where two are the same nevertheless
[[nodiscard]] std::vector<std::string> outputNames(const std::vector<std::string>& image_names);

/// Refuses a folder for the output that holds, at any depth, one of the files that are read, by its own name
/// or by that of the file that it links to. Sources that do not exist do not matter.
/// @throws Error (kUsage)
void refuseFolderOfInputs(const std::string& folder, const std::vector<std::string>& sources);

}  // namespace alidade
