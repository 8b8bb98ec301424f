// SPDX-License-Identifier: MIT
#include "alidade/files/camera_list.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 7> kExtensions = {".yaml", ".yml",         ".json", ".xml",
                                                         ".txt",  ".cameramodel", ".cam"};

bool hasCameraExtension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

void listFolder(const std::string& folder, CameraList& list) {
  std::error_code error;
  std::vector<std::string> names;
  std::vector<std::string> folders;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    const std::string name = entry->path().filename().string();
    if (name.starts_with('.')) continue;
    if (entry->is_directory(ignored)) {
      folders.push_back(name);
      continue;
    }
    // A link to nothing stands for a camera file that is missed.
    const bool is_file = entry->is_regular_file(ignored) || !entry->exists(ignored);
    if (is_file && hasCameraExtension(entry->path())) names.push_back(name);
  }
  if (error) {
    throw inputError({.where = folder,
                      .found = "a folder that cannot be read: " + error.message(),
                      .expected = "a folder of camera files"});
  }
  std::sort(names.begin(), names.end(), naturalLess);
  std::sort(folders.begin(), folders.end(), naturalLess);
  for (const std::string& name : folders) list.folders.push_back((fs::path(folder) / name).string());
  std::size_t num_found = 0;
  for (const std::string& name : names) {
    const std::string path = (fs::path(folder) / name).string();
    if (kindOfFile(path) == FileKind::kOther) {
      list.skipped.push_back(path);
      continue;
    }
    list.files.push_back({.path = path, .is_from_folder = true});
    ++num_found;
  }
  if (num_found == 0) {
    throw inputError({.where = folder,
                      .found = names.empty()
                                   ? "no file with the extension of a camera file"
                                   : std::to_string(names.size()) + " files, none of a known format",
                      .expected = "camera files (yaml, yml, json, xml, txt, cameramodel)",
                      .next_step = folders.empty() ? ""
                                                   : "sub-folders are not searched; list them explicitly: " +
                                                         (fs::path(folder) / folders.front()).string()});
  }
}

}  // namespace

CameraList listCameraFiles(std::span<const std::string> inputs) {
  CameraList list;
  for (const std::string& input : inputs) {
    std::error_code ignored;
    if (fs::is_directory(input, ignored)) {
      listFolder(input, list);
    } else {
      list.files.push_back({.path = input});
    }
  }
  return list;
}

}  // namespace alidade
