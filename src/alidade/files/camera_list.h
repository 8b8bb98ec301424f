// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

struct ListedFile {
  std::string path;
  bool is_from_folder = false;  ///< a folder was named, or a pattern matches it
};

/// The files that inputs stand for, each once. An input is a file ("FILE#NAME" too), a folder, or a pattern
/// with * ? or [ that is not itself a file name. A folder means its files with an extension that camera files
/// have (yaml, yml, json, xml, txt, cameramodel, cam), and those of its sub-folders; links to nothing are
/// listed, hidden files and folders are not. Each folder is in natural order (cam2 before cam10), its files
/// before its sub-folders. No file is opened.
/// @throws Error (kInput) for an input that does not exist, a folder without such a file, or one that cannot
/// be read
[[nodiscard]] std::vector<ListedFile> listCameraFiles(std::span<const std::string> inputs);

}  // namespace alidade
