// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "alidade/core/error.h"

namespace alidade {

/// The help of --overwrite.
inline constexpr const char* kOverwriteText =
    "Replace an earlier, unchanged result of this command; other files are never changed";

/// Refuses a folder for the output that holds, at any depth, one of the files that are read, by its own name
/// or by that of the file that it links to. Sources that do not exist do not matter.
void refuseFolderOfInputs(const std::string& folder, const std::vector<std::string>& sources);

/// A folder that appears under its name only when it is complete; until then it has a temporary name.
///
/// A complete folder holds a list of its files with the size and the CRC-32 of each. An earlier result is
/// replaced only if all that it holds is on its list and as it was written: what was added, changed or comes
/// from elsewhere makes the constructor refuse, and is never deleted. The earlier folder is moved aside
/// first, and deleted when the new one is in its place.
class PendingFolder {
 public:
  /// The name of the list.
  static constexpr const char* kListName = ".alidade_result";

  /// @param command  that makes the folder, and whose earlier results may be replaced
  /// @param may_replace  accept a target that holds an earlier result and nothing else
  /// @param is_quiet  do not name what killed runs left beside the folder, which nobody else removes
  /// @throws Error (kInput) for a target that is no folder, is the current folder or one above it, or holds
  /// anything but what may be replaced
  PendingFolder(const std::string& target, std::string command, bool may_replace, bool is_quiet = true);
  ~PendingFolder();
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  /// Path of an entry while the folder is pending.
  [[nodiscard]] std::string path(const std::string& name) const { return (pending_ / name).string(); }
  void makeSubfolder(const std::string& name) const;
  /// Puts the folder in place. @throws Error (kInput)
  void commit();
  /// Runs what writes entries. @throws Error what that throws, naming the entries as they are going to be
  template <class Write>
  void write(const Write& entries) const {
    try {
      entries();
    } catch (const Error& error) {
      throw Error(error.code(), {.found = renamed(error.what())});
    }
  }

 private:
  [[nodiscard]] std::string renamed(std::string message) const;
  [[nodiscard]] std::filesystem::path siblingPath(const std::string& ending) const;
  [[nodiscard]] std::vector<std::string> leftovers() const;
  // @returns whether it exists. @throws Error (kInput) where it is no folder, or holds anything else than
  // what may be replaced
  [[nodiscard]] bool checkTarget() const;
  // Files first, then the folders that held them, at last the folder itself.
  [[nodiscard]] std::vector<std::filesystem::path> ownEntries(const std::filesystem::path& folder) const;

  std::string command_;
  bool may_replace_;
  std::filesystem::path target_;
  std::filesystem::path pending_;
};

}  // namespace alidade
