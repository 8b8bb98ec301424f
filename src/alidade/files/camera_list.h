// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

struct ListedFile {
  std::string path;
  bool is_from_folder = false;  ///< it was not named itself
};

/// The camera files that inputs stand for.
struct CameraList {
  std::vector<ListedFile> files;     ///< in natural order (cam2 before cam10) within each folder
  std::vector<std::string> skipped;  ///< files in folders that are text, but of no known format
  std::vector<std::string> folders;  ///< in folders, not looked into
};

/// An input is a camera file ("FILE#NAME" too), or a folder: of its files with an extension that camera files
/// have (yaml, yml, json, xml, txt, cameramodel, cam), those whose content is of a known format, and those
/// that are damaged or links to nothing. Hidden files are passed over; sub-folders are named and not looked
/// into. A file is not opened here, a folder's files are.
/// @throws Error (kInput) for a folder without a camera file, or one that cannot be read
[[nodiscard]] CameraList listCameraFiles(std::span<const std::string> inputs);

}  // namespace alidade
