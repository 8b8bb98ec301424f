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

/// Refuses an output folder that contains, at any depth, one of the input files, by its own name or as the
/// target of a link. Missing sources are ignored.
void refuseFolderOfInputs(const std::string& folder, const std::vector<std::string>& sources);

/// A folder that appears under its name only when it is complete; until then it has a temporary name.
///
/// A complete folder holds a list of its files with the size and the CRC-32 of each. An earlier result is
/// replaced only if everything in it is on its list and unchanged; otherwise the constructor throws, and
/// nothing is deleted. The earlier folder is moved aside first, and deleted when the new one is in place.
class PendingFolder {
 public:
  /// Name of the list file.
  static constexpr const char* kListName = ".alidade_result";

  /// @param command  creates the folder; its earlier results may be replaced
  /// @param may_replace  accept a target that contains only an earlier result
  /// @param is_quiet  do not report leftovers of killed runs beside the folder, which nothing else removes
  /// @throws Error (kInput) for a target that is not a folder, is the current folder or a parent of it, or
  /// contains anything that must not be replaced
  PendingFolder(const std::string& target, std::string command, bool may_replace, bool is_quiet = true);
  ~PendingFolder();
  PendingFolder(const PendingFolder&) = delete;
  PendingFolder& operator=(const PendingFolder&) = delete;

  /// Path of an entry while the folder is pending.
  [[nodiscard]] std::string path(const std::string& name) const { return (pending_ / name).string(); }
  void makeSubfolder(const std::string& name) const;
  /// Moves the folder to its final name. @throws Error (kInput)
  void commit();
  /// Runs code that writes entries. @throws Error from it, with the final names of the entries
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
  // @returns true if it exists.
  // @throws Error (kInput) if it is not a folder, or contains anything that must not be replaced
  [[nodiscard]] bool checkTarget() const;
  // Files first, then their folders, finally the folder itself.
  [[nodiscard]] std::vector<std::filesystem::path> ownEntries(const std::filesystem::path& folder) const;

  std::string command_;
  bool may_replace_;
  std::filesystem::path target_;
  std::filesystem::path pending_;
};

}  // namespace alidade
