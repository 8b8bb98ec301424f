// SPDX-License-Identifier: MIT
#include "commands/camera/folder_diff.h"

#include <set>
#include <span>

#include "alidade/core/error.h"
#include "alidade/core/error_text.h"
#include "alidade/fleet/fleet_unit.h"

namespace alidade {

std::vector<DiffResult> diffFolders(
    const std::string& folder_a, const std::string& folder_b, const ReadOptions& options,
    const std::function<DiffResult(const std::string&, const std::string&)>& diff_files) {
  const FleetOptions of_fleet{.read = options, .jobs = 1};
  const FleetFiles a = readFleetFiles(std::span(&folder_a, 1), of_fleet);
  const FleetFiles b = readFleetFiles(std::span(&folder_b, 1), of_fleet);
  std::vector<DiffResult> results;
  std::set<std::string> rigs;  // files that were compared as a whole
  const auto compare = [&](const FleetUnit& in_a, const FleetUnit& in_b) {
    const std::string path_a = cameraFilePath(in_a.file);
    const std::string path_b = cameraFilePath(in_b.file);
    if (rigs.contains(path_a)) return;
    const bool are_rigs = in_a.file != path_a && in_b.file != path_b &&
                          isRigSource(loadCameras(path_a, options)) &&
                          isRigSource(loadCameras(path_b, options));
    if (are_rigs) rigs.insert(path_a);
    try {
      results.push_back(are_rigs ? diff_files(path_a, path_b) : diff_files(in_a.file, in_b.file));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kInput) throw;
      results.push_back({.pair = {.a = in_a.file, .b = in_b.file, .reason = oneLine(error.what())}});
    }
    std::string& name = results.back().pair.name;
    if (name.empty()) name = are_rigs ? cameraFilePath(in_a.place) : in_a.place;
  };
  // Of what only one folder has.
  const auto add = [&](bool is_in_a, const std::string& name, const std::string& file,
                       const std::string& reason) {
    results.push_back(
        {.pair = {.name = name, .a = is_in_a ? file : "", .b = is_in_a ? "" : file, .reason = reason}});
  };
  const auto nameOf = [](const FleetUnit& unit) {
    return unit.name.name.empty() ? unit.place : unit.name.name;
  };
  std::vector<bool> is_paired(b.units.size(), false);
  const auto pairs = pairedUnits(a.units, b.units);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const FleetUnit& unit = a.units[i];
    if (!pairs[i]) {
      add(true, nameOf(unit), unit.file, "no such camera in B");
      continue;
    }
    is_paired[*pairs[i]] = true;
    compare(unit, b.units[*pairs[i]]);
  }
  for (std::size_t i = 0; i < is_paired.size(); ++i) {
    if (!is_paired[i]) add(false, nameOf(b.units[i]), b.units[i].file, "no such camera in A");
  }
  for (const FleetFiles* files : {&a, &b}) {
    for (const UnreadableFile& file : files->unreadable)
      add(files == &a, file.file, file.file, oneLine(file.reason));
  }
  if (!results.empty()) return results;
  throw inputError({.where = folder_a + " and " + folder_b,
                    .found = "no camera file",
                    .expected = "at least one",
                    .next_step = "see docs/formats.md for the formats"});
}

}  // namespace alidade
