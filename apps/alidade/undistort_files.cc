// SPDX-License-Identifier: MIT
#include "undistort_files.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>

#include "alidade/core/error.h"
#include "alidade/imagery/image_file.h"

namespace alidade {
namespace {

namespace fs = std::filesystem;

bool isBelow(const fs::path& path, const fs::path& folder) {
  std::error_code ignored;  // of folders that do not exist, which hold nothing
  for (fs::path parent = path.parent_path(); !parent.empty(); parent = parent.parent_path()) {
    if (fs::equivalent(parent, folder, ignored)) return true;
    if (parent == parent.parent_path()) return false;
  }
  return false;
}

}  // namespace

std::vector<std::string> outputNames(const std::vector<std::string>& image_names) {
  std::vector<std::string> flat;
  std::vector<std::string> names;
  std::map<std::string, int> counts;
  for (std::string name : image_names) {
    std::replace(name.begin(), name.end(), '/', '_');
    flat.push_back(name);
    names.push_back(hasJpegName(name) ? name : fs::path(name).replace_extension(".png").string());
    ++counts[names.back()];
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (counts.at(names[i]) > 1 && !hasJpegName(flat[i])) names[i] = flat[i] + ".png";
  }
  std::map<std::string, std::string> sources;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [earlier, is_new] = sources.emplace(names[i], image_names[i]);
    if (is_new) continue;
    throw inputError(
        {.where = image_names[i],
         .found = "this image and " + earlier->second + " would both be written to '" + names[i] + "'",
         .expected = "different output names",
         .next_step = "undistort them in two runs with different output folders"});
  }
  return names;
}

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

}  // namespace alidade
