// SPDX-License-Identifier: MIT
#include "alidade/files/content_cache.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/digest.h"
#include "alidade/core/error.h"
#include "alidade/files/text/atomic_file.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTagName = "CACHEDIR.TAG";
// Defined at https://bford.info/cachedir.
constexpr std::string_view kTag =
    "Signature: 8a477f597d28d172789f06886806bc55\n"
    "# Results of alidade that can be computed again. You may delete this folder.\n";
constexpr std::size_t kMaxEntryBytes = std::size_t{1} << 28U;

bool holdsOtherFiles(const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    // Another program may be creating the same cache; its tag has a hidden name at first.
    const std::string name = entry.path().filename().string();
    if (name != kTagName && !name.starts_with('.')) return true;
  }
  return false;
}

Error notACacheError(const std::string& folder) {
  return usageError({.where = "--cache " + folder,
                     .found = "a folder with other files",
                     .expected = "a new or empty folder, or a cache of alidade",
                     .next_step = "choose another folder"});
}

// Header that detects changed bytes and misnamed entries.
std::string headOf(std::string_view key, std::string_view text) {
  return "alidade_cache 1 " + digestOf(digestOf(key) + digestOf(text)) + "\n";
}

}  // namespace

ContentCache::ContentCache(std::string folder) : folder_(std::move(folder)) {
  const std::string tag = (fs::path(folder_) / kTagName).string();
  try {
    fs::create_directories(folder_);
    if (fs::exists(tag)) {
      if (!fs::is_regular_file(tag) || readBinaryFile(tag, kMaxEntryBytes) != kTag)
        throw notACacheError(folder_);
      return;
    }
    if (holdsOtherFiles(folder_)) throw notACacheError(folder_);
  } catch (const fs::filesystem_error& error) {
    throw inputError({.where = "--cache " + folder_,
                      .found = error.code().message(),
                      .expected = "a folder that can be made and written to"});
  }
  writeFileAtomically(tag, kTag);
}

std::string ContentCache::pathOf(std::string_view key) const {
  // One folder per 256th of the entries, as some file systems are slow with many files in one folder.
  const std::string name = digestOf(key);
  return (fs::path(folder_) / name.substr(0, 2) / name.substr(2)).string();
}

std::optional<std::string> ContentCache::find(std::string_view key) const {
  const std::string path = pathOf(key);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return std::nullopt;
  std::string content;
  try {
    // Reading a pipe here would block.
    if (fs::is_regular_file(status)) content = readBinaryFile(path, kMaxEntryBytes);
  } catch (const Error&) {
    content.clear();  // damaged
  }
  const std::size_t head_size = headOf("", "").size();
  if (content.size() >= head_size) {
    std::string text = content.substr(head_size);
    if (content.starts_with(headOf(key, text))) return text;
  }
  noteDamaged(path);
  return std::nullopt;
}

void ContentCache::reject(std::string_view key) const {
  noteDamaged(pathOf(key));
}

void ContentCache::noteDamaged(const std::string& path) const {
  const std::lock_guard lock(mutex_);
  if (num_damaged_++ == 0) damaged_ = path;
}

void ContentCache::keep(std::string_view key, std::string_view text) const {
  const std::string path = pathOf(key);
  try {
    fs::create_directories(fs::path(path).parent_path());
    writeFileAtomically(path, headOf(key, text) + std::string(text), Durability::kQuick);
  } catch (const Error& error) {
    const std::lock_guard lock(mutex_);
    if (unwritten_.empty()) unwritten_ = error.what();
  } catch (const fs::filesystem_error& error) {
    const std::lock_guard lock(mutex_);
    if (unwritten_.empty()) unwritten_ = path + ": cannot be written: " + error.code().message();
  }
}

std::vector<std::string> ContentCache::complaints() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> sentences;
  if (num_damaged_ == 1) {
    sentences.push_back("the cache entry " + damaged_ + " is damaged; its result was computed again");
  } else if (num_damaged_ > 1) {
    sentences.push_back(
        fmt::format("{} cache entries are damaged, the first one {}; their results were computed again",
                    num_damaged_, damaged_));
  }
  if (!unwritten_.empty()) sentences.push_back("some results are not in the cache: " + unwritten_);
  return sentences;
}

}  // namespace alidade
