// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>

namespace alidade {

/// The files below a folder and what they hold, by path from there; folders and links hold nothing.
using FolderContent = std::map<std::string, std::string>;

inline FolderContent contentOf(const std::filesystem::path& folder) {
  FolderContent content;
  if (!std::filesystem::is_directory(folder)) return content;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    std::string& text = content[entry.path().lexically_relative(folder).string()];
    if (entry.is_symlink() || !entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  return content;
}

/// What the contract of docs/files.md lets be replaced: a result that is as it was written, by the same
/// command with --overwrite. It is known here from what was done, not from the list in the folder.
class LastResult {
 public:
  void set(std::string command, FolderContent content) {
    command_ = std::move(command);
    content_ = std::move(content);
  }
  /// Files may have gone; folders that hold none have no owner.
  [[nodiscard]] bool mayBeReplacedBy(const std::string& command, const FolderContent& now) const {
    if (command != command_ || !now.contains(".alidade_result")) return false;
    return std::ranges::all_of(now, [&](const auto& entry) {
      const auto written = content_.find(entry.first);
      return written != content_.end() && written->second == entry.second;
    });
  }

 private:
  std::string command_;
  FolderContent content_;
};

}  // namespace alidade
