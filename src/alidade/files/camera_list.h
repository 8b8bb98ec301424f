// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

namespace alidade {

struct ListedFile {
  std::string path;
  bool is_from_folder = false;  ///< comes from a named folder or one that a pattern matches
};

/// Lists the files that inputs refer to, each once. An input is a file ("FILE#NAME" too), a folder, or a
/// pattern with * ? or [ that is not itself a file name. A folder stands for its files with an extension of
/// camera files (yaml, yml, json, xml, txt, cameramodel, cam), those in which other programs keep cameras
/// (toml, conf, mat, bin, csv, npz and others) if a format recognises them or their name or content speaks of
/// a camera, and those of its sub-folders. Dangling links are listed, hidden files and folders are not. Each
/// folder is in natural order (cam2 before cam10), its files before its sub-folders.
/// @throws Error (kInput) for an input that does not exist, a folder without such a file, or one that cannot
/// be read
[[nodiscard]] std::vector<ListedFile> listCameraFiles(std::span<const std::string> inputs);

/// True for an existing file ("FILE#NAME" too) with an extension that only camera files have: not txt, which
/// lists of images have as well.
[[nodiscard]] bool isNamedAsCameraFile(const std::string& path);

}  // namespace alidade
