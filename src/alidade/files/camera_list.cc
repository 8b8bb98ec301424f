// SPDX-License-Identifier: MIT
#include "alidade/files/camera_list.h"

#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <set>
#include <string_view>
#include <utility>

#include "alidade/core/aliases.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/file_text.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 7> kExtensions = {".yaml", ".yml",         ".json", ".xml",
                                                         ".txt",  ".cameramodel", ".cam"};
// Of other programs, for cameras and for much else; and what the name or content of a camera says.
constexpr std::string_view kReadExtensions = ".toml .ini .cfg .conf .calib .mat .bin";
constexpr std::string_view kForeignExtensions =
    ".toml .ini .cfg .conf .jsonl .csv .calib .mat .npy .npz .pkl .pickle";
constexpr std::string_view kCameraWords =
    "calib [camera camera. cameramatrix intrinsic distortion distcoef focal mtx";

bool hasExtension(const fs::path& path, std::span<const std::string_view> extensions) {
  return std::ranges::find(extensions, bareWord(path.extension().string())) != extensions.end();
}

// True for a file with an extension of camera files, or one of other programs that a format recognises.
bool isCameraFile(const fs::path& path) {
  return hasExtension(path, kExtensions) ||
         (hasExtension(path, split(kReadExtensions, ' ')) && hasCameraFormat(path.string()));
}

// True for a file of another program that probably holds a camera: users expect it to be mentioned.
bool isForeignCamera(const fs::path& path) {
  if (!hasExtension(path, split(kForeignExtensions, ' '))) return false;
  std::string text(std::size_t{1} << 16U, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text = bareWord(path.filename().string() + "\n" + text);
  return std::ranges::any_of(split(kCameraWords, ' '),
                             [&](std::string_view word) { return text.find(word) != std::string::npos; });
}

class Lister {
 public:
  void addInput(const std::string& input) {
    std::error_code ignored;
    if (fs::is_directory(input, ignored)) return addNamedFolder(input);
    // If this cannot be determined (no permission), reading the file reports it.
    const bool is_missing = fs::status(cameraFilePath(input), ignored).type() == fs::file_type::not_found;
    if (!is_missing) return add(input, false);
    if (input.find_first_of("*?[") == std::string::npos) throw missingPathError(cameraFilePath(input));
    for (const std::string& match : matchesOf(input)) {
      fs::is_directory(match, ignored) ? addNamedFolder(match) : add(match, true);
    }
  }

  [[nodiscard]] std::vector<ListedFile> finish() { return std::move(files_); }

 private:
  void add(const std::string& path, bool is_from_folder) {
    if (paths_.insert(fs::path(path).lexically_normal().string()).second)
      files_.push_back({.path = path, .is_from_folder = is_from_folder});
  }

  void addNamedFolder(const std::string& folder) {
    if (addFolder(folder) == 0) {
      throw detail::errorAt(folder, "no file with the extension of a camera file",
                            "yaml, yml, json, xml, txt, cameramodel or cam, also in sub-folders",
                            "give camera files, or the folder that contains them");
    }
  }

  // Returns the number of files in it, including its sub-folders.
  std::size_t addFolder(const std::string& folder) {
    // A link may point to a parent folder.
    std::error_code error;
    const fs::path canonical = fs::canonical(folder, error);
    if (!error && !open_.insert(canonical.string()).second) return 0;
    std::vector<std::string> names;
    std::vector<std::string> folders;
    std::size_t num_found = 0;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      std::error_code ignored;
      const std::string name = entry->path().filename().string();
      if (name.starts_with('.')) continue;
      // A dangling link counts as a missing camera file.
      const bool is_file = entry->is_regular_file(ignored) || !entry->exists(ignored);
      if (entry->is_directory(ignored)) {
        folders.push_back(name);
      } else if (const bool is_camera = is_file && isCameraFile(entry->path());
                 is_camera || (is_file && isForeignCamera(entry->path()))) {
        names.push_back(name);
        num_found += is_camera ? 1 : 0;
      }
    }
    if (error) {
      throw detail::errorAt(folder, "a folder that cannot be read: " + error.message(),
                            "a folder of camera files");
    }
    std::sort(names.begin(), names.end(), naturalLess);
    std::sort(folders.begin(), folders.end(), naturalLess);
    for (const std::string& name : names) add((fs::path(folder) / name).string(), true);
    for (const std::string& name : folders) num_found += addFolder((fs::path(folder) / name).string());
    open_.erase(canonical.string());
    return num_found;
  }

  static std::vector<std::string> matchesOf(const std::string& pattern) {
    glob_t matches{};
    const int status = ::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &matches);
    std::vector<std::string> paths;
    if (status == 0) paths.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
    ::globfree(&matches);
    std::sort(paths.begin(), paths.end(), naturalLess);
    if (paths.empty()) {
      throw detail::errorAt(pattern, "no file matches this pattern", "a pattern that matches camera files",
                            "check the pattern and the folder");
    }
    return paths;
  }

  std::vector<ListedFile> files_;
  std::set<std::string> paths_;
  std::set<std::string> open_;  // folders that are being listed
};

}  // namespace

std::vector<ListedFile> listCameraFiles(std::span<const std::string> inputs) {
  Lister lister;
  for (const std::string& input : inputs) lister.addInput(input);
  return lister.finish();
}

bool isNamedAsCameraFile(const std::string& path) {
  const fs::path file = cameraFilePath(path);
  std::error_code ignored;
  return hasExtension(file, kExtensions) && bareWord(file.extension().string()) != ".txt" &&
         fs::is_regular_file(file, ignored);
}

}  // namespace alidade
