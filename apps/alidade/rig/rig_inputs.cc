// SPDX-License-Identifier: MIT
#include "rig/rig_inputs.h"

#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/frame_table_file.h"
#include "board_views.h"
#include "console.h"

namespace alidade {
namespace {

// "left" for photos/left/, photos/left*.png and left.csv.
std::string nameOf(const std::string& input) {
  std::filesystem::path path(input);
  if (!path.has_filename()) path = path.parent_path();
  std::string name = path.filename().string();
  name = name.substr(0, name.find_first_of("*?[%"));
  if (isCornersFile(input) || std::filesystem::path(name).has_extension())
    name = std::filesystem::path(name).stem().string();
  while (!name.empty() && (name.back() == '_' || name.back() == '-' || name.back() == '.')) name.pop_back();
  return name;
}

}  // namespace

void RigInputs::addOptions(CLI::App& app) {
  addBoardOption(app, boards);
  app.add_option("--names", names, "Names of the cameras, separated by commas. Default: from the inputs")
      ->delimiter(',');
  app.add_option("--match", match,
                 "CSV file that says which images were taken together: a column for each camera, a row for "
                 "each frame. Default: images whose names match")
      ->type_name("FILE");
  addDetectionOptions(app, detection);
}

std::vector<std::string> RigInputs::sources() const {
  std::vector<std::string> sources = {match};
  for (const std::string& input : inputs) {
    const std::vector<std::string> files = isCornersFile(input) ? std::vector{input} : withImages({input});
    sources.insert(sources.end(), files.begin(), files.end());
  }
  return sources;
}

std::vector<std::string> RigInputs::cameraNames(const std::string& command) const {
  std::vector<std::string> result = names;
  if (result.empty()) {
    for (const std::string& input : inputs) result.push_back(nameOf(input));
  }
  const std::set<std::string> unique(result.begin(), result.end());
  if (result.size() != inputs.size() || unique.size() != result.size() || unique.contains("")) {
    throw usageError(
        {.where = names.empty() ? command : "--names",
         .found = "the names " + join(result, ", ") + fmt::format(" for {} cameras", inputs.size()),
         .expected = "a different name for each camera",
         .next_step = "give --names, for example --names left,right"});
  }
  return result;
}

FrameTable RigInputs::frames() const {
  return match.empty() ? FrameTable() : readFrameTable(match);
}

RigInputViews readRigViews(const std::string& command, const RigInputs& inputs,
                           const std::vector<std::string>& names, const CommonOptions& common,
                           const CancelFlag* cancel) {
  RigInputViews result;
  for (std::size_t c = 0; c < inputs.inputs.size(); ++c) {
    GivenViews given = readViews({.command = command,
                                  .inputs = {inputs.inputs[c]},
                                  .boards = inputs.boards,
                                  .detection = inputs.detection},
                                 common, cancel);
    if (c == 0) result.boards = given.boards;
    if (given.boards != result.boards) {
      throw inputError({.where = inputs.inputs[c],
                        .found = "other boards than in " + inputs.inputs.front(),
                        .expected = "the same boards for all cameras, in the same order"});
    }
    if (!common.quiet && !common.json) {
      printMessage(
          fmt::format("{}: a board in {} of {} images", names[c], given.num_found, given.num_images));
      if (!given.reasons.empty()) {
        const std::string lines = listed(given.reasons);
        printMessage(lines.substr(0, lines.size() - 1));
      }
    }
    result.cameras.push_back(
        {.name = names[c], .views = std::move(given.views), .images = std::move(given.images)});
  }
  return result;
}

}  // namespace alidade
