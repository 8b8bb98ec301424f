// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace alidade {

/// A folder that appears under its name only when it is complete; until then it has another one beside it.
///
/// An earlier folder is moved aside, and deleted when the new one is in its place.
/// Replacing a folder deletes only regular files that `is_ours` knows by their path inside of it, and then
/// folders that are empty: whatever else is there makes the constructor refuse, and is never deleted.
class PendingFolder {
 public:
  using IsOurs = std::function<bool(const std::filesystem::path& relative)>;

  /// @param may_replace  accept a target that holds files, if all of them are ours
  /// @throws Error (kInput) for a target that is no folder, is the current folder or one above it, or holds
  /// anything else than files that may be replaced
  PendingFolder(const std::string& target, bool may_replace, IsOurs is_ours);
  ~PendingFolder();
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  /// Path of an entry while the folder is pending.
  [[nodiscard]] std::string path(const std::string& name) const { return (pending_ / name).string(); }
  void makeSubfolder(const std::string& name) const;
  /// Puts the folder in place. @throws Error (kInput)
  void commit();

 private:
  [[nodiscard]] std::filesystem::path siblingPath(const char* ending) const;
  // @returns whether it exists. @throws Error (kInput) where it is no folder, or holds anything else than
  // what may be replaced
  bool checkTarget(bool may_replace) const;
  void removeOurEntries(const std::filesystem::path& folder) const;

  IsOurs is_ours_;
  std::filesystem::path target_;
  std::filesystem::path pending_;
};

}  // namespace alidade
