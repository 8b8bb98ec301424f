// SPDX-License-Identifier: MIT
#include "pending_folder.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
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

// False if the name is taken.
bool makeFolder(const fs::path& folder, const fs::path& named) {
  std::error_code error;
  const bool is_made = fs::create_directory(folder, error);
  if (!error) return is_made;
  throw inputError({.where = named.string(),
                    .found = "cannot create the folder: " + error.message(),
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

bool isBelow(const fs::path& path, const fs::path& folder) {
  std::error_code ignored;  // of folders that do not exist, which hold nothing
  for (fs::path parent = path.parent_path(); !parent.empty(); parent = parent.parent_path()) {
    if (fs::equivalent(parent, folder, ignored)) return true;
    if (parent == parent.parent_path()) return false;
  }
  return false;
}

}  // namespace

void refuseFolderOfInputs(const std::string& folder, const std::vector<std::string>& sources) {
  for (const std::string& source : sources) {
    if (source.empty()) continue;
    std::error_code error;
    const fs::path own = fs::absolute(source, error).lexically_normal();
    const fs::path target = fs::weakly_canonical(source, error);
    if (!isBelow(own, folder) && !isBelow(target, folder)) continue;
    throw usageError({.where = "--output " + folder,
                      .found = "this is the folder of the input " + source,
                      .expected = "a different folder",
                      .next_step = "choose another folder, otherwise the results would replace the inputs or "
                                   "be read as inputs next time"});
  }
}

bool isWrittenBy(const fs::path& file, std::string_view command) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    for (const std::string_view start : {"created_by: alidade ", "# alidade "}) {
      if (!line.starts_with(start)) continue;
      const std::string_view rest = std::string_view(line).substr(start.size());
      return rest.substr(rest.find(' ') + 1).starts_with(command);
    }
  }
  return false;
}

PendingFolder::PendingFolder(const std::string& target, bool may_replace, Own own)
    : may_replace_(may_replace), own_(std::move(own)) {
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
  const bool is_there = checkTarget();
  // Of a run that was killed a folder may have been left, in a container even by a process of the same
  // number.
  fs::path pending = siblingPath("tmp");
  for (int i = 2; !makeFolder(pending, target); ++i) pending = siblingPath(fmt::format("{}.tmp", i));
  pending_ = pending;
  if (is_there) fs::permissions(pending_, fs::status(target_).permissions(), error);
}

PendingFolder::~PendingFolder() {
  // Only ever a folder that this object made under a name that nobody had.
  std::error_code ignored;
  if (!pending_.empty()) fs::remove_all(pending_, ignored);
}

fs::path PendingFolder::siblingPath(const std::string& ending) const {
  constexpr std::size_t kMaxBytes = 200;  // of a name, so that the longer one is none too long
  return target_.parent_path() /
         fmt::format(".{}.{}.{}", target_.filename().string().substr(0, kMaxBytes), getpid(), ending);
}

bool PendingFolder::checkTarget() const try {
  if (!fs::exists(target_)) return false;
  if (!fs::is_directory(target_)) {
    throw inputError(
        {.where = target_.string(), .found = "a file", .expected = "the path of a folder, or a new path"});
  }
  const bool is_result = may_replace_ && own_.is_result(target_);
  for (const fs::directory_entry& entry : entriesBelow(target_)) {
    const fs::path relative = entry.path().lexically_relative(target_);
    const fs::file_type type = entry.symlink_status().type();
    if (may_replace_ && type == fs::file_type::directory && own_.is_name(relative)) continue;
    if (is_result && type == fs::file_type::regular && own_.is_name(relative)) continue;
    throw inputError(
        {.where = target_.string(),
         .found = "a folder that contains '" + relative.string() + "'",
         .expected = may_replace_ ? "an empty folder, or one with only a result of this command"
                                  : "a new or empty folder",
         .next_step = "choose another name" +
                      std::string(may_replace_ ? "" : ", or add --overwrite to replace an earlier result")});
  }
  return true;
} catch (const fs::filesystem_error& error) {
  throw inputError({.where = target_.string(),
                    .found = "cannot be read: " + error.code().message(),
                    .expected = "a readable folder, or a new name"});
}

void PendingFolder::makeSubfolder(const std::string& name) const {
  expect(makeFolder(pending_ / name, target_ / name), "a new folder has no entries");
}

void PendingFolder::removeOurEntries(const fs::path& folder) const try {
  // Deepest first; fs::remove deletes one file or one empty folder and nothing more.
  const std::vector<fs::directory_entry> entries = entriesBelow(folder);
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    const fs::file_type type = entry->symlink_status().type();
    std::error_code ignored;
    if (type != fs::file_type::directory && type != fs::file_type::regular) continue;
    if (own_.is_name(entry->path().lexically_relative(folder))) fs::remove(entry->path(), ignored);
  }
  fs::remove(folder);
} catch (const fs::filesystem_error&) {
  // What cannot be removed stays under a name that is in nobody's way.
}

void PendingFolder::commit() {
  const fs::path old = siblingPath("old");
  // Again: time has passed. What has come since then, the system itself refuses to replace by a plain rename.
  const bool replaces = checkTarget() && may_replace_;
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
