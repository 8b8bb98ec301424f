// SPDX-License-Identifier: MIT
#include "alidade/core/distinct_names.h"

#include <filesystem>
#include <set>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"

namespace alidade {
namespace {

bool areDistinct(const std::vector<std::string>& names) {
  const std::set<std::string> unique(names.begin(), names.end());
  return unique.size() == names.size() && !unique.contains("");
}

// The folder that contains the file or folder, after resolving "." and ".." in the path.
std::filesystem::path folderOf(const std::string& path) {
  const std::filesystem::path whole = std::filesystem::absolute(path).lexically_normal();
  return whole.has_filename() ? whole.parent_path() : whole.parent_path().parent_path();
}

}  // namespace

std::vector<std::string> distinctNames(std::vector<std::string> names, std::span<const std::string> paths) {
  expect(names.size() == paths.size(), "a name for each path");
  std::vector<std::filesystem::path> folders = mapped(paths, folderOf);
  const auto isAnyLeft = [&] {
    for (const std::filesystem::path& folder : folders) {
      if (folder.has_relative_path()) return true;
    }
    return false;
  };
  while (!areDistinct(names)) {
    if (!isAnyLeft()) return {};
    names = mapped(folders, [](const std::filesystem::path& folder) { return folder.filename().string(); });
    for (std::filesystem::path& folder : folders) folder = folder.parent_path();
  }
  return names;
}

}  // namespace alidade
