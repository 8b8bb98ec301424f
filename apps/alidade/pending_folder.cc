// SPDX-License-Identifier: MIT
#include "pending_folder.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include <fmt/format.h>

#include "alidade/core/error.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

void makeFolder(const fs::path& folder, const fs::path& named) {
  std::error_code error;
  if (fs::create_directory(folder, error)) return;
  throw inputError({.where = named.string(),
                    .found = "cannot create the folder: " +
                             (error ? error.message() : "its temporary name already exists"),
                    .expected = "a writable parent folder"});
}

// All that is below a folder, each folder before what it holds. @throws fs::filesystem_error
std::vector<fs::directory_entry> entriesBelow(const fs::path& folder) {
  return {fs::recursive_directory_iterator(folder), fs::recursive_directory_iterator()};
}

// True if `folder` is `inner` or one of the folders above it.
bool contains(const fs::path& folder, const fs::path& inner) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), inner.begin(), inner.end());
  return end == folder.end();
}

// In one step, so that a process that is killed leaves one of the two in place. False where the file system
// cannot.
bool exchangeNames(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

}  // namespace

PendingFolder::PendingFolder(const std::string& target, bool may_replace, IsOurs is_ours)
    : is_ours_(std::move(is_ours)) {
  std::error_code error;
  const fs::path absolute = fs::absolute(target, error);
  if (!error) target_ = fs::weakly_canonical(absolute, error);
  if (!target_.has_filename()) target_ = target_.parent_path();
  const fs::path current = error ? fs::path() : fs::current_path(error);
  if (error || contains(target_, current)) {
    throw inputError({.where = target,
                      .found = error ? error.message() : "this is the current folder or one of its parents",
                      .expected = "the name of a new folder",
                      .next_step = "choose another name"});
  }
  checkTarget(may_replace);
  const fs::path pending = siblingPath("tmp");
  makeFolder(pending, target);
  pending_ = pending;
}

PendingFolder::~PendingFolder() {
  // Only ever a folder that this object made under a name that nobody had.
  std::error_code ignored;
  if (!pending_.empty()) fs::remove_all(pending_, ignored);
}

fs::path PendingFolder::siblingPath(const char* ending) const {
  constexpr std::size_t kMaxBytes = 200;  // of a name, so that the longer one is none too long
  return target_.parent_path() /
         fmt::format(".{}.{}.{}", target_.filename().string().substr(0, kMaxBytes), getpid(), ending);
}

bool PendingFolder::checkTarget(bool may_replace) const try {
  if (!fs::exists(target_)) return false;
  if (!fs::is_directory(target_)) {
    throw inputError(
        {.where = target_.string(), .found = "a file", .expected = "the path of a folder, or a new path"});
  }
  for (const fs::directory_entry& entry : entriesBelow(target_)) {
    const fs::path relative = entry.path().lexically_relative(target_);
    const fs::file_type type = entry.symlink_status().type();
    if (type == fs::file_type::directory && is_ours_(relative)) continue;
    if (may_replace && type == fs::file_type::regular && is_ours_(relative)) continue;
    throw inputError(
        {.where = target_.string(),
         .found = "a folder that contains '" + relative.string() + "'",
         .expected = may_replace ? "an empty folder, or one with only results of this command"
                                 : "a new or empty folder",
         .next_step = "choose another name" +
                      std::string(may_replace ? "" : ", or add --overwrite to replace an earlier result")});
  }
  return true;
} catch (const fs::filesystem_error& error) {
  throw inputError({.where = target_.string(),
                    .found = "cannot be read: " + error.code().message(),
                    .expected = "a readable folder, or a new name"});
}

void PendingFolder::makeSubfolder(const std::string& name) const {
  makeFolder(pending_ / name, target_ / name);
}

void PendingFolder::removeOurEntries(const fs::path& folder) const try {
  // Deepest first; fs::remove deletes one file or one empty folder and nothing more.
  const std::vector<fs::directory_entry> entries = entriesBelow(folder);
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    const fs::file_type type = entry->symlink_status().type();
    std::error_code ignored;
    if (type != fs::file_type::directory && type != fs::file_type::regular) continue;
    if (is_ours_(entry->path().lexically_relative(folder))) fs::remove(entry->path(), ignored);
  }
  fs::remove(folder);
} catch (const fs::filesystem_error&) {
  // What cannot be removed stays under a name that is in nobody's way.
}

void PendingFolder::commit() {
  const fs::path old = siblingPath("old");
  const bool replaces = checkTarget(true);  // again: time has passed
  std::error_code error;
  if (replaces) {
    if (exchangeNames(pending_, target_)) {
      removeOurEntries(std::exchange(pending_, {}));
      return;
    }
    fs::rename(target_, old, error);
    if (error) {
      throw inputError({.where = target_.string(), .found = "cannot be replaced: " + error.message()});
    }
  }
  fs::rename(pending_, target_, error);
  if (error) {
    std::error_code stuck;
    if (replaces) fs::rename(old, target_, stuck);
    throw inputError({.where = target_.string(),
                      .found = "cannot be moved into place: " + error.message(),
                      .next_step = stuck ? "the earlier result is now in '" + old.string() + "'" : ""});
  }
  pending_.clear();
  if (replaces) removeOurEntries(old);
}

}  // namespace alidade
