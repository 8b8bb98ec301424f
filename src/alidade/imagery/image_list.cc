// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_list.h"

#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include <boost/algorithm/string/predicate.hpp>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 10> kImageExtensions = {".jpg",  ".jpeg", ".png", ".bmp", ".tif",
                                                               ".tiff", ".pgm",  ".ppm", ".pnm", ".webp"};
constexpr std::array<std::string_view, 5> kVideoExtensions = {".mp4", ".avi", ".mov", ".mkv", ".webm"};

bool hasExtension(const fs::path& path, std::span<const std::string_view> extensions) {
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](std::string_view extension) { return boost::iends_with(path.native(), extension); });
}

bool isFolder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

Error unreadableError(const fs::path& path, const std::error_code& error) {
  return inputError({.where = path.string(),
                     .found = "cannot be read: " + error.message(),
                     .expected = "a readable file or folder",
                     .next_step = "change the permissions (chmod u+rx for folders)"});
}

/// What is in a folder, in natural order, without hidden entries.
std::vector<fs::path> entriesOf(const fs::path& folder, std::error_code& error) {
  std::vector<fs::path> entries;
  fs::directory_iterator entry(folder, error);
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    if (!entry->path().filename().string().starts_with('.')) entries.push_back(entry->path());
  }
  std::sort(entries.begin(), entries.end(),
            [](const fs::path& a, const fs::path& b) { return naturalLess(a.string(), b.string()); });
  return entries;
}

/// Links that lead nowhere count, so that reading complains about them rather than nobody.
bool isImage(const fs::path& path) {
  return hasExtension(path, kImageExtensions) && !isFolder(path);
}

Error noImagesError(const fs::path& folder, const std::vector<fs::path>& entries) {
  std::vector<fs::path> files;
  std::optional<fs::path> folder_with_images;
  for (const fs::path& entry : entries) {
    if (!isFolder(entry)) {
      files.push_back(entry);
    } else if (!folder_with_images) {
      std::error_code error;  // a sub-folder that cannot be read is just not suggested
      const std::vector<fs::path> below = entriesOf(entry, error);
      if (std::any_of(below.begin(), below.end(), isImage)) folder_with_images = entry;
    }
  }
  std::string found = "a folder without images";
  if (entries.empty()) found += "; it is empty";
  if (!files.empty()) {
    found += "; it contains " + std::to_string(files.size()) +
             (files.size() == 1 ? " file, " : " files, e.g. ") + files.front().filename().string();
  }
  std::string expected = "files that end in";
  for (const std::string_view extension : kImageExtensions) expected += " " + std::string(extension);
  return inputError({.where = folder.string(),
                     .found = found,
                     .expected = expected,
                     .next_step = folder_with_images ? "there are images one level below: give '" +
                                                           folder_with_images->string() + "'"
                                                     : "give the folder that contains the images"});
}

Error videoError(const fs::path& path) {
  return inputError({.where = path.string(),
                     .found = "a video, which is not supported",
                     .expected = "images",
                     .next_step = "extract frames first: mkdir frames && ffmpeg -i '" + path.string() +
                                  "' -vf fps=2 frames/%05d.png"});
}

void addFolder(const fs::path& folder, std::vector<std::string>& paths) {
  std::error_code error;
  const std::vector<fs::path> entries = entriesOf(folder, error);
  if (error) throw unreadableError(folder, error);
  const std::size_t num_before = paths.size();
  for (const fs::path& entry : entries) {
    if (isImage(entry)) paths.push_back(entry.string());
  }
  if (paths.size() == num_before) throw noImagesError(folder, entries);
}

void addExisting(const std::string& path, std::vector<std::string>& paths) {
  if (isFolder(path)) return addFolder(path, paths);
  if (hasExtension(path, kVideoExtensions)) throw videoError(path);
  paths.push_back(path);
}

std::vector<std::string> expandPattern(const std::string& pattern) {
  glob_t matches{};
  const int status = ::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &matches);
  std::vector<std::string> paths;
  if (status == 0) paths.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  ::globfree(&matches);
  if (paths.empty()) {
    throw inputError({.where = pattern,
                      .found = "no file matches this pattern",
                      .expected = "a pattern that matches images",
                      .next_step = "check the pattern and the folder, and put quotes around the pattern"});
  }
  return paths;
}

void addInput(const std::string& input, std::vector<std::string>& paths) {
  std::error_code error;
  const fs::file_status status = fs::status(input, error);
  if (fs::exists(status)) return addExisting(input, paths);
  if (input.find_first_of("*?[") != std::string::npos) {
    for (const std::string& match : expandPattern(input)) addExisting(match, paths);
    return;
  }
  if (status.type() == fs::file_type::not_found) throw missingPathError(input);
  throw unreadableError(input, error);
}

}  // namespace

std::vector<std::string> listImages(std::span<const std::string> inputs) {
  if (inputs.empty()) {
    throw usageError({.where = "images",
                      .found = "no input",
                      .expected = "at least one folder, file or pattern",
                      .next_step = "give the folder that contains the images"});
  }
  std::vector<std::string> paths;
  for (const std::string& input : inputs) addInput(input, paths);

  // Sorted first, so that which of two spellings of a path stays does not depend on the inputs' order.
  std::sort(paths.begin(), paths.end(), naturalLess);
  std::set<fs::path> seen;
  std::erase_if(paths, [&seen](const std::string& path) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(path, error);
    return !seen.insert(error ? fs::path(path) : canonical).second;
  });
  return paths;
}

std::vector<std::string> shortNames(const std::vector<std::string>& paths) {
  std::string shared = paths.front().substr(0, paths.front().rfind('/') + 1);
  for (const std::string& path : paths) {
    while (!path.starts_with(shared)) {
      shared.pop_back();
      shared.resize(shared.rfind('/') + 1);  // 0 without a slash
    }
  }
  return mapped(paths, [&](const std::string& path) { return path.substr(shared.size()); });
}

}  // namespace alidade
