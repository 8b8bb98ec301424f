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
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/video_reader.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 10> kImageExtensions = {".jpg",  ".jpeg", ".png", ".bmp", ".tif",
                                                               ".tiff", ".pgm",  ".ppm", ".pnm", ".webp"};

// Photographs that cannot be read count as images, so that reading names them.
constexpr std::array<std::string_view, 2> kHeicExtensions = {".heic", ".heif"};

bool hasImageName(const fs::path& path) {
  const auto isEnd = [&](std::string_view extension) { return boost::iends_with(path.native(), extension); };
  return std::ranges::any_of(kImageExtensions, isEnd) || std::ranges::any_of(kHeicExtensions, isEnd);
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

/// Entries of a folder in natural order, without hidden ones.
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

/// True for dangling links too, so that reading complains about them.
bool isImage(const fs::path& path) {
  return hasImageName(path) && !isFolder(path);
}

Error noImagesError(const fs::path& folder, const std::vector<fs::path>& entries) {
  std::vector<fs::path> files;
  std::optional<fs::path> folder_with_images;
  for (const fs::path& entry : entries) {
    if (!isFolder(entry)) {
      files.push_back(entry);
    } else if (!folder_with_images) {
      std::error_code error;  // an unreadable sub-folder is simply not suggested
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
  const auto video =
      std::ranges::find_if(files, [](const fs::path& file) { return hasVideoName(file.string()); });
  std::string next_step = "give the folder that contains the images";
  if (folder_with_images)
    next_step = "there are images one level below: give '" + folder_with_images->string() + "'";
  if (video != files.end()) next_step = "give videos by their names: '" + video->string() + "'";
  return inputError({.where = folder.string(), .found = found, .expected = expected, .next_step = next_step});
}

void addFolder(const fs::path& folder, InputFiles& files) {
  std::error_code error;
  const std::vector<fs::path> entries = entriesOf(folder, error);
  if (error) throw unreadableError(folder, error);
  const std::size_t num_before = files.images.size();
  for (const fs::path& entry : entries) {
    if (isImage(entry)) files.images.push_back(entry.string());
  }
  if (files.images.size() == num_before) throw noImagesError(folder, entries);
}

void addExisting(const std::string& path, InputFiles& files) {
  if (isFolder(path)) return addFolder(path, files);
  (hasVideoName(path) ? files.videos : files.images).push_back(path);
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

// The parts of "img%04d.png" before and after the number, and the minimum number of digits. The number is in
// the name of the file, not of a folder.
struct NumberedName {
  fs::path folder;
  std::string before;
  std::string after;
  std::size_t num_digits = 1;

  // The number in a file name; nothing if the name has a different form.
  [[nodiscard]] std::optional<int> numberOf(const std::string& name) const {
    if (name.size() < before.size() + num_digits + after.size()) return std::nullopt;
    if (!name.starts_with(before) || !name.ends_with(after)) return std::nullopt;
    const std::string digits = name.substr(before.size(), name.size() - before.size() - after.size());
    const bool is_padded = digits.size() > num_digits && digits.front() == '0';
    const bool is_number = digits.find_first_not_of("0123456789") == std::string::npos;
    return is_number && !is_padded ? parseInt(digits) : std::nullopt;
  }
};

std::optional<NumberedName> parseNumberedName(const std::string& pattern) {
  const fs::path path(pattern);
  const std::string name = path.filename().string();
  const std::size_t percent = name.find('%');
  if (percent == std::string::npos) return std::nullopt;
  const std::size_t end = name.find_first_not_of("0123456789", percent + 1);
  if (end == std::string::npos || name[end] != 'd') return std::nullopt;
  const std::string width = name.substr(percent + 1, end - percent - 1);
  constexpr int kMostDigits = 9;
  const int num_digits = width.empty() ? 1 : parseInt(width).value_or(0);
  if (num_digits < 1 || num_digits > kMostDigits) return std::nullopt;
  return NumberedName{.folder = path.parent_path(),
                      .before = name.substr(0, percent),
                      .after = name.substr(end + 1),
                      .num_digits = static_cast<std::size_t>(num_digits)};
}

ImageSequence expandSequence(const std::string& pattern, const NumberedName& name) {
  std::error_code error;
  const fs::path folder = name.folder.empty() ? "." : name.folder;
  std::vector<std::pair<int, std::string>> numbered;
  const std::vector<fs::path> entries = entriesOf(folder, error);
  if (error == std::errc::no_such_file_or_directory) throw missingPathError(folder.string());
  if (error) throw unreadableError(folder, error);
  for (const fs::path& entry : entries) {
    const std::string file = entry.filename().string();
    const std::optional<int> number = isFolder(entry) ? std::nullopt : name.numberOf(file);
    if (number) numbered.emplace_back(*number, (name.folder / file).string());
  }
  if (numbered.empty()) {
    throw inputError(
        {.where = pattern,
         .found = "no file matches this pattern",
         .expected = "files with a number in place of %...d",
         .next_step = "check the folder and the number of digits: %04d stands for 0012, %d for 12"});
  }
  std::sort(numbered.begin(), numbered.end());
  return {.pattern = pattern, .files = mapped(numbered, [](const auto& file) { return file.second; })};
}

void addInput(const std::string& input, InputFiles& files) {
  std::error_code error;
  const fs::file_status status = fs::status(input, error);
  if (fs::exists(status)) return addExisting(input, files);
  if (const std::optional<NumberedName> name = parseNumberedName(input)) {
    files.sequences.push_back(expandSequence(input, *name));
    return;
  }
  if (input.find_first_of("*?[") != std::string::npos) {
    for (const std::string& match : expandPattern(input)) addExisting(match, files);
    return;
  }
  if (status.type() == fs::file_type::not_found) throw missingPathError(input);
  throw unreadableError(input, error);
}

// Sorts in natural order, removes files that are in `seen`, and adds the rest to it.
void sortOut(std::vector<std::string>& paths, std::set<fs::path>& seen) {
  // Sorted first, so that the order of the inputs does not decide which of two spellings of a path stays.
  std::sort(paths.begin(), paths.end(), naturalLess);
  std::erase_if(paths, [&seen](const std::string& path) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(path, error);
    return !seen.insert(error ? fs::path(path) : canonical).second;
  });
}

}  // namespace

std::vector<std::string> InputFiles::all() const {
  std::vector<std::string> files = images;
  for (const ImageSequence& sequence : sequences)
    files.insert(files.end(), sequence.files.begin(), sequence.files.end());
  files.insert(files.end(), videos.begin(), videos.end());
  return files;
}

InputFiles listInputs(std::span<const std::string> inputs) {
  if (inputs.empty()) {
    throw usageError({.where = "images",
                      .found = "no input",
                      .expected = "at least one folder, file or pattern",
                      .next_step = "give the folder that contains the images"});
  }
  InputFiles files;
  for (const std::string& input : inputs) addInput(input, files);

  std::set<fs::path> seen;
  sortOut(files.images, seen);
  std::sort(files.sequences.begin(), files.sequences.end(),
            [](const ImageSequence& a, const ImageSequence& b) { return naturalLess(a.pattern, b.pattern); });
  for (ImageSequence& sequence : files.sequences) sortOut(sequence.files, seen);
  std::erase_if(files.sequences, [](const ImageSequence& sequence) { return sequence.files.empty(); });
  sortOut(files.videos, seen);
  return files;
}

std::vector<std::string> listImages(std::span<const std::string> inputs) {
  const InputFiles files = listInputs(inputs);
  if (files.videos.empty()) {
    std::vector<std::string> images = files.all();
    std::sort(images.begin(), images.end(), naturalLess);
    return images;
  }
  const std::string& video = files.videos.front();
  throw inputError({.where = video,
                    .found = "a video",
                    .expected = "images",
                    .next_step = "extract frames first: mkdir frames && ffmpeg -i '" + video +
                                 "' -vf fps=2 frames/%05d.png"});
}

std::vector<std::string> shortNames(const std::vector<std::string>& paths) {
  std::string shared = paths.front().substr(0, paths.front().rfind('/') + 1);
  for (const std::string& path : paths) {
    while (!path.starts_with(shared)) {
      shared.pop_back();
      shared.resize(shared.rfind('/') + 1);  // empty without a slash
    }
  }
  return mapped(paths, [&](const std::string& path) { return path.substr(shared.size()); });
}

}  // namespace alidade
