// SPDX-License-Identifier: MIT
#include "alidade/fleet/fleet_unit.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "alidade/camera/model_fit.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/record/correlations.h"

namespace alidade {
namespace {

// The path below the named folder; for a file named directly, its own name.
std::string placeOf(const std::string& path, const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!folder.empty() && fs::is_directory(folder, error))
    return fs::path(path).lexically_relative(fs::path(folder)).string();
  return fs::path(path).filename().string();
}

// An invalid covariance would corrupt the statistics of the whole fleet.
void requireCovariance(const CameraRecord& record, const std::string& where) {
  if (!record.calibration || record.calibration->covariance.empty()) return;
  const auto n = static_cast<Eigen::Index>(record.camera.parameters().size());
  if (Correlations(record.calibration->covariance, n).isSemidefinite()) return;
  throw inputError({.where = where,
                    .found = "an invalid covariance: it has negative variances",
                    .expected = "the numbers that the calibration wrote",
                    .next_step = "run alidade validate " + where});
}

FleetFiles readFile(const ListedFile& file, const std::string& place, const ReadOptions& options) {
  FleetFiles result{.num_files = 1};
  try {
    const CameraSource source = loadCameras(file.path, options);
    requireAll(source);
    const bool is_one = source.cameras.size() == 1;
    for (const StatedCamera& camera : source.cameras) {
      const std::string label = is_one ? "" : "#" + cameraLabel(camera);
      CameraRecord record = recordOf(camera, source.path + label);
      requireCovariance(record, source.path + label);
      if (record.name.name.empty()) record.name.name = camera.name;
      result.units.push_back(unitOf(record, file.path + label, place + label));
    }
  } catch (const NotACameraFile& reason) {
    // A folder may hold other files, but a file named directly must be a camera file.
    if (file.is_from_folder) return {.other_files = {file.path}};
    result.unreadable.push_back({file.path, reason.what()});
  } catch (const Error& reason) {
    result.units.clear();
    result.unreadable.push_back({file.path, reason.what()});
  }
  return result;
}

using UnitKey = std::string (*)(const FleetUnit&);

// The unit with each key; nothing if several share it.
std::map<std::string, std::optional<std::size_t>> byKey(std::span<const FleetUnit> units, UnitKey keyOf) {
  std::map<std::string, std::optional<std::size_t>> index;
  for (std::size_t i = 0; i < units.size(); ++i) {
    const std::string key = keyOf(units[i]);
    if (key.empty()) continue;
    const auto [at, is_new] = index.emplace(key, i);
    if (!is_new) at->second.reset();
  }
  return index;
}

// True if one camera replaced another.
bool haveOtherSerials(const FleetUnit& a, const FleetUnit& b) {
  return !a.name.serial.empty() && !b.name.serial.empty() && a.name.serial != b.name.serial;
}

}  // namespace

ComparedCamera FleetUnit::compared() const {
  ComparedCamera result{.camera = &camera, .size = size};
  if (!covariance.empty())
    result.covariance = fullMatrix(covariance, static_cast<Eigen::Index>(camera.parameters().size()));
  return result;
}

namespace {

// Units are compared by their parameters, so a correction field is left to the closest camera without one.
AnyCamera plainOf(const CameraRecord& record) {
  if (record.camera.correction() == nullptr) return record.camera;
  return fitModel(record.camera, record.image_size, record.camera.modelId()).camera;
}

}  // namespace

FleetUnit unitOf(const CameraRecord& record, std::string file, std::string place) {
  FleetUnit unit{.file = std::move(file),
                 .place = std::move(place),
                 .name = record.name,
                 .camera = plainOf(record),
                 .size = record.image_size};
  if (!record.calibration) return unit;
  const CalibrationRecord& stated = *record.calibration;
  unit.verdict = stated.verdict;
  unit.accuracy_px = stated.accuracy_px;
  if (statedCovariance(record)) unit.covariance = stated.covariance;
  return unit;
}

FleetFiles readFleetFiles(std::span<const std::string> inputs, const FleetOptions& options) {
  std::vector<ListedFile> listed;
  std::vector<std::string> places;
  std::set<std::string> known;
  for (const std::string& input : inputs) {
    for (ListedFile& file : listCameraFiles(std::span(&input, 1))) {
      if (!known.insert(file.path).second) continue;
      places.push_back(placeOf(file.path, input));
      listed.push_back(std::move(file));
    }
  }
  std::vector<FleetFiles> read(listed.size());
  std::mutex mutex;
  std::size_t num_done = 0;
  parallelFor(
      listed.size(), options.jobs,
      [&](std::size_t i) {
        read[i] = readFile(listed[i], places[i], options.read);
        if (!options.progress) return;
        const std::lock_guard lock(mutex);
        options.progress(++num_done, listed.size());
      },
      options.cancel);
  FleetFiles files;
  for (FleetFiles& of_file : read) {
    files.num_files += of_file.num_files;
    std::ranges::move(of_file.units, std::back_inserter(files.units));
    std::ranges::move(of_file.unreadable, std::back_inserter(files.unreadable));
    std::ranges::move(of_file.other_files, std::back_inserter(files.other_files));
  }
  return files;
}

std::vector<std::optional<std::size_t>> pairedUnits(std::span<const FleetUnit> units,
                                                    std::span<const FleetUnit> previous) {
  constexpr std::array<UnitKey, 4> kKeys = {
      [](const FleetUnit& unit) { return unit.name.serial; },
      [](const FleetUnit& unit) { return unit.name.name; }, [](const FleetUnit& unit) { return unit.place; },
      [](const FleetUnit& unit) { return std::filesystem::path(unit.place).filename().string(); }};
  std::vector<std::optional<std::size_t>> pairs(units.size());
  std::vector<bool> is_paired(units.size(), false);
  std::vector<bool> is_taken(previous.size(), false);
  for (const UnitKey keyOf : kKeys) {
    const auto ours = byKey(units, keyOf);
    const auto theirs = byKey(previous, keyOf);
    for (const auto& [key, unit] : ours) {
      const auto found = theirs.find(key);
      if (!unit || is_paired[*unit] || found == theirs.end() || !found->second) continue;
      if (is_taken[*found->second] || haveOtherSerials(units[*unit], previous[*found->second])) continue;
      pairs[*unit] = *found->second;
      is_paired[*unit] = true;
      is_taken[*found->second] = true;
    }
  }
  return pairs;
}

}  // namespace alidade
