// SPDX-License-Identifier: MIT
#include "alidade/fleet/drift.h"

#include <array>
#include <filesystem>
#include <map>
#include <string>

namespace alidade {
namespace {

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
