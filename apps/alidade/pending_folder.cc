// SPDX-License-Identifier: MIT
#include "pending_folder.h"

#include <algorithm>
#include <vector>

#include <unistd.h>

#include <fmt/format.h>

#include "alidade/core/error.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

void makeFolder(const fs::path& folder, const fs::path& named) {
  std::error_code error;
  if (fs::create_directory(folder, error)) return;
  throw inputError(
      {.where = named.string(),
       .found = "cannot make the folder: " + (error ? error.message() : "its temporary name is taken"),
       .expected = "a folder that exists and can be written to around it"});
}

// True if `folder` is `inner` or one of the folders above it.
bool contains(const fs::path& folder, const fs::path& inner) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), inner.begin(), inner.end());
  return end == folder.end();
}

}  // namespace

PendingFolder::PendingFolder(const std::string& target, bool may_replace, IsOurs is_ours)
    : is_ours_(std::move(is_ours)) {
  std::error_code error;
  target_ = fs::weakly_canonical(fs::absolute(target), error);
  if (!target_.has_filename()) target_ = target_.parent_path();
  if (error || contains(target_, fs::current_path())) {
    throw inputError({.where = target,
                      .found = error ? error.message() : "the current folder or one above it",
                      .expected = "the name of a new folder",
                      .next_step = "choose another name"});
  }
  if (fs::exists(target_, error)) refuseForeignEntries(may_replace);
  const fs::path pending =
      target_.parent_path() / fmt::format(".{}.{}.tmp", target_.filename().string().substr(0, 200), getpid());
  makeFolder(pending, target);
  pending_ = pending;
}

PendingFolder::~PendingFolder() {
  // Only ever a folder that this object made under a name that nobody had.
  std::error_code ignored;
  if (!pending_.empty()) fs::remove_all(pending_, ignored);
}

void PendingFolder::refuseForeignEntries(bool may_replace) const {
  if (!fs::is_directory(target_)) {
    throw inputError(
        {.where = target_.string(), .found = "a file", .expected = "the name of a folder to make"});
  }
  for (const auto& entry : fs::recursive_directory_iterator(target_)) {
    const fs::path relative = entry.path().lexically_relative(target_);
    if (entry.is_directory() && !entry.is_symlink() && is_ours_(relative)) continue;
    if (may_replace && entry.symlink_status().type() == fs::file_type::regular && is_ours_(relative))
      continue;
    throw inputError(
        {.where = target_.string(),
         .found = "a folder that holds '" + relative.string() + "'",
         .expected = may_replace ? "a folder with nothing in it but what this command makes"
                                 : "a new or empty folder",
         .next_step = "choose another name" +
                      std::string(may_replace ? "" : ", or give --overwrite to replace an earlier result")});
  }
}

void PendingFolder::makeSubfolder(const std::string& name) const {
  makeFolder(pending_ / name, target_ / name);
}

void PendingFolder::commit() {
  std::error_code error;
  if (fs::exists(target_)) {
    refuseForeignEntries(true);  // again: time has passed
    std::vector<fs::path> entries;
    for (const auto& entry : fs::recursive_directory_iterator(target_)) entries.push_back(entry.path());
    // Deepest first; fs::remove deletes one file or one empty folder and nothing more.
    for (auto entry = entries.rbegin(); entry != entries.rend() && !error; ++entry) fs::remove(*entry, error);
    if (!error) fs::remove(target_, error);
  }
  if (!error) fs::rename(pending_, target_, error);
  if (error)
    throw inputError({.where = target_.string(), .found = "cannot be put in place: " + error.message()});
  pending_.clear();
}

}  // namespace alidade
