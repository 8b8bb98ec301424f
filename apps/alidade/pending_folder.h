// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace alidade {

/// Refuses a folder for the output that holds, at any depth, one of the files that are read, by its own name
/// or by that of the file that it links to. Sources that do not exist do not matter.
void refuseFolderOfInputs(const std::string& folder, const std::vector<std::string>& sources);

/// Whether a text file says that a command of this program wrote it: "created_by: alidade 0.1.0 simulate", or
/// the same in a comment.
[[nodiscard]] bool isWrittenBy(const std::filesystem::path& file, std::string_view command);

/// A folder that appears under its name only when it is complete; until then it has another one beside it.
///
/// An earlier folder is moved aside, and deleted when the new one is in its place.
/// Replacing a folder deletes only regular files that an earlier run of the same command wrote, and then
/// folders that are empty: whatever else is there makes the constructor refuse, and is never deleted.
class PendingFolder {
 public:
  /// How the command knows its own.
  struct Own {
    std::function<bool(const std::filesystem::path& relative)> is_name;  ///< of an entry, inside the folder
    /// By what its files say of themselves: names alone may be those of anybody's files.
    std::function<bool(const std::filesystem::path& folder)> is_result;
  };

  /// @param may_replace  accept a target that holds an earlier result and nothing else
  /// @throws Error (kInput) for a target that is no folder, is the current folder or one above it, or holds
  /// anything else than files that may be replaced
  PendingFolder(const std::string& target, bool may_replace, Own own);
  ~PendingFolder();
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  /// Path of an entry while the folder is pending.
  [[nodiscard]] std::string path(const std::string& name) const { return (pending_ / name).string(); }
  void makeSubfolder(const std::string& name) const;
  /// Puts the folder in place. @throws Error (kInput)
  void commit();

 private:
  [[nodiscard]] std::filesystem::path siblingPath(const std::string& ending) const;
  // @returns whether it exists. @throws Error (kInput) where it is no folder, or holds anything else than
  // what may be replaced
  [[nodiscard]] bool checkTarget() const;
  void removeOurEntries(const std::filesystem::path& folder) const;

  bool may_replace_;
  Own own_;
  std::filesystem::path target_;
  std::filesystem::path pending_;
};

}  // namespace alidade
