// SPDX-License-Identifier: MIT
#include "settings.h"

#include <algorithm>
#include <set>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/settings_file.h"

namespace alidade {
namespace {

// Flags that say how a result is shown or where it goes, not what it is.
const std::set<std::string> kOutsideTheResult = {"help",      "config",      "json",  "quiet",
                                                 "jobs",      "output",      "input", "keep-untrustworthy",
                                                 "next-view", "target-sigma"};

std::string longName(const CLI::Option& option) {
  return option.get_lnames().empty() ? std::string() : option.get_lnames().front();
}

}  // namespace

void applySettingsFile(CLI::App& app, const std::string& path) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = longName(*option);
    if (!name.empty() && name != "help" && name != "config") names.push_back(name);
  }
  for (const SettingEntry& entry : readSettingsFile(path)) {
    if (std::find(names.begin(), names.end(), entry.key) == names.end()) {
      throw inputError({.where = entry.where,
                        .found = "'" + entry.key + "' is not a flag of " + app.get_name(),
                        .expected = "one of " + join(names, ", "),
                        .next_step = didYouMean(entry.key, names)});
    }
    CLI::Option* option = app.get_option("--" + entry.key);
    if (option->count() > 0) continue;  // given by hand
    try {
      for (const std::string& value : entry.values) option->add_result(value);
      option->run_callback();
    } catch (const CLI::Error& e) {
      throw inputError({.where = entry.where, .found = e.what()});
    }
  }
}

std::vector<Setting> effectiveSettings(const CLI::App& app) {
  std::vector<Setting> settings;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = longName(*option);
    if (name.empty() || kOutsideTheResult.contains(name)) continue;
    if (option->count() > 0) {
      settings.emplace_back(name, option->results());
    } else if (!option->get_default_str().empty()) {
      settings.emplace_back(name, std::vector<std::string>{option->get_default_str()});
    }
  }
  std::sort(settings.begin(), settings.end());
  return settings;
}

}  // namespace alidade
