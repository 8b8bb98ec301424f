// SPDX-License-Identifier: MIT
#include "pending_folder.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <map>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <boost/crc.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/text/atomic_file.h"
#include "console.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

// Returns false if the name is taken.
bool makeFolder(const fs::path& folder, const fs::path& named) {
  std::error_code error;
  const bool is_made = fs::create_directory(folder, error);
  if (!error) return is_made;
  throw inputError({.where = named.string(),
                    .found = "cannot create the folder: " + error.message(),
                    .expected = "a writable parent folder"});
}

// Everything below a folder, each folder before its content. @throws fs::filesystem_error
std::vector<fs::directory_entry> entriesBelow(const fs::path& folder) {
  return {fs::recursive_directory_iterator(folder), fs::recursive_directory_iterator()};
}

// True if `folder` is `inner` or one of the folders above it.
bool contains(const fs::path& folder, const fs::path& inner) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), inner.begin(), inner.end());
  return end == folder.end();
}

// Exchanges names atomically, so that a killed process leaves one of the two in place. False if the file
// system cannot.
bool exchangeNames(const fs::path& a, const fs::path& b) {
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
}

// As far as the system permits: only root may change an owner.
void takeOwnerAndMode(const fs::path& from, const fs::path& to) {
  struct stat status {};
  if (::stat(from.c_str(), &status) != 0) return;
  const bool is_owned = ::chown(to.c_str(), status.st_uid, status.st_gid) == 0;
  constexpr mode_t kAll = 07777;
  constexpr mode_t kOwnersOnly = 05777;  // without the set-group bit of a foreign group
  ::chmod(to.c_str(), status.st_mode & (is_owned ? kAll : kOwnersOnly));
}

// True if the entry is on a different file system than its folder.
bool isMounted(const fs::path& entry, const fs::path& folder) {
  struct stat own {};
  struct stat above {};
  return ::lstat(entry.c_str(), &own) == 0 && ::stat(folder.c_str(), &above) == 0 &&
         own.st_dev != above.st_dev;
}

// "SIZE CRC-32" of a file, to detect changes.
std::string markOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  boost::crc_32_type crc;
  std::streamsize size = 0;
  std::vector<char> bytes(std::size_t{1} << 16U);
  while (file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())), file.gcount() > 0) {
    crc.process_bytes(bytes.data(), static_cast<std::size_t>(file.gcount()));
    size += file.gcount();
  }
  return fmt::format("{} {:08x}", size, crc.checksum());
}

// The marks of the files that a run wrote, by relative path.
using FileList = std::map<std::string, std::string>;

// One line per file: its mark and its path. A path with a line break is not listed, and so is never deleted.
constexpr const char* kListStart = "# written by alidade ";

void writeList(const fs::path& folder, const std::string& command) {
  FileList list;
  for (const fs::directory_entry& entry : entriesBelow(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_regular_file() && name.find('\n') == std::string::npos) list[name] = markOf(entry.path());
  }
  std::string text = kListStart + command +
                     "; --overwrite replaces these files while they are unchanged: size, CRC-32, path\n";
  for (const auto& [name, mark] : list) text += mark + " " + name + "\n";
  writeFileAtomically((folder / PendingFolder::kListName).string(), text);
}

// Empty if there is no list of this command.
FileList readList(const fs::path& folder, const std::string& command) {
  FileList list;
  std::ifstream file(folder / PendingFolder::kListName);
  std::string line;
  if (!std::getline(file, line) || !line.starts_with(kListStart + command + ";")) return list;
  while (std::getline(file, line)) {
    const std::size_t end = line.find(' ', line.find(' ') + 1);
    if (end != std::string::npos) list[line.substr(end + 1)] = line.substr(0, end);
  }
  return list;
}

bool isBelow(const fs::path& path, const fs::path& folder) {
  std::error_code ignored;  // of missing folders, which are empty
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
    throw flagError("--output " + folder, "this is the folder of the input " + source, "a different folder",
                    "choose another folder, otherwise the results would replace the inputs or "
                    "be read as inputs next time");
  }
}

PendingFolder::PendingFolder(const std::string& target, std::string command, bool may_replace, bool is_quiet)
    : command_(std::move(command)), may_replace_(may_replace) {
  std::error_code error;
  if (fs::is_symlink(fs::symlink_status(target, error)) && !fs::exists(target, error)) {
    throw inputError({.where = target,
                      .found = "a link to a folder that does not exist",
                      .expected = "a new or empty folder"});
  }
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
  // A killed run may have left its folder, in a container even with the same process number.
  fs::path pending = siblingPath("tmp");
  for (int i = 2; !makeFolder(pending, target); ++i) pending = siblingPath(fmt::format("{}.tmp", i));
  pending_ = pending;
  if (is_there) takeOwnerAndMode(target_, pending_);
  if (is_quiet) return;
  for (const std::string& name : leftovers())
    printMessage("note: '" + name +
                 "' beside the output is left over from an interrupted run\n  next: delete it");
}

PendingFolder::~PendingFolder() {
  // Only removes a folder that this object created under an unused name.
  std::error_code ignored;
  if (!pending_.empty()) fs::remove_all(pending_, ignored);
}

fs::path PendingFolder::siblingPath(const std::string& ending) const {
  constexpr std::size_t kMaxBytes = 200;  // of a name, so that the extended one is not too long
  return target_.parent_path() /
         fmt::format(".{}.{}.{}", target_.filename().string().substr(0, kMaxBytes), getpid(), ending);
}

bool PendingFolder::checkTarget() const try {
  if (!fs::exists(target_)) return false;
  if (!fs::is_directory(target_)) {
    throw inputError(
        {.where = target_.string(), .found = "a file", .expected = "the path of a folder, or a new path"});
  }
  std::set<fs::path> own;
  if (may_replace_) {
    for (const fs::path& entry : ownEntries(target_)) own.insert(entry);
  }
  for (const fs::directory_entry& entry : entriesBelow(target_)) {
    if (own.contains(entry.path())) continue;
    const fs::path relative = entry.path().lexically_relative(target_);
    throw inputError(
        {.where = target_.string(),
         .found = "a folder that contains '" + relative.string() + "'",
         .expected = may_replace_ ? "an empty folder, or one with only the unchanged result of this command"
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

std::vector<std::string> PendingFolder::leftovers() const {
  // Pattern of siblingPath(): ".NAME.PROCESS.tmp", ".NAME.PROCESS.2.tmp", ".NAME.PROCESS.old".
  std::vector<std::string> names;
  const std::string own = siblingPath("").filename().string();
  const std::string start = own.substr(0, own.find_last_of('.', own.size() - 2) + 1);
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(target_.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(start) || !(name.ends_with(".tmp") || name.ends_with(".old"))) continue;
    const auto process =
        parseInt(std::string_view(name).substr(start.size(), name.find('.', start.size()) - start.size()));
    if (!process || *process <= 0 || entry.path() == pending_) continue;
    if (*process == ::getpid() || (::kill(*process, 0) != 0 && errno == ESRCH)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

std::vector<fs::path> PendingFolder::ownEntries(const fs::path& folder) const {
  const FileList list = readList(folder, command_);
  if (list.empty()) return {};
  std::vector<fs::path> files;
  std::vector<fs::path> folders;
  const std::vector<fs::directory_entry> entries = entriesBelow(folder);
  for (const fs::directory_entry& entry : entries) {
    if (isMounted(entry.path(), folder)) continue;
    const auto type = entry.symlink_status().type();
    const std::string name = entry.path().lexically_relative(folder).string();
    if (type == fs::file_type::directory) {
      const bool is_listed =
          std::ranges::any_of(list, [&](const auto& file) { return file.first.starts_with(name + "/"); });
      if (is_listed) folders.push_back(entry.path());
    } else if (type == fs::file_type::regular) {
      const auto listed = list.find(name);
      const bool is_own = listed != list.end() && markOf(entry.path()) == listed->second;
      if (is_own || name == kListName) files.push_back(entry.path());
    }
  }
  // Each folder precedes its content, so the order is reversed.
  files.insert(files.end(), folders.rbegin(), folders.rend());
  return files;
}

std::string PendingFolder::renamed(std::string message) const {
  const std::string pending = pending_.string();
  for (std::size_t at = 0; (at = message.find(pending, at)) != std::string::npos;)
    message.replace(at, pending.size(), target_.string());
  return message;
}

void PendingFolder::commit() {
  writeList(pending_, command_);
  const fs::path old = siblingPath("old");
  // Checks again, since time has passed. The system refuses to replace later changes by a plain rename.
  const bool replaces = checkTarget() && may_replace_;
  // fs::remove deletes one file or one empty folder and nothing more. Entries that cannot be removed stay
  // under a name that is not in the way.
  const auto removeOwn = [this](const fs::path& folder) {
    std::error_code ignored;
    for (const fs::path& entry : ownEntries(folder)) fs::remove(entry, ignored);
    fs::remove(folder, ignored);
  };
  std::error_code error;
  if (replaces) {
    if (exchangeNames(pending_, target_)) return removeOwn(std::exchange(pending_, {}));
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
  if (replaces) removeOwn(old);
}

}  // namespace alidade
