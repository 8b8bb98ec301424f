// SPDX-License-Identifier: MIT
#include "flags.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/settings_file.h"
#include "alidade/target/board_spec.h"

namespace alidade {
namespace {

std::string numberComplaint(const std::string& text, bool is_good, const std::string& expected) {
  return is_good ? std::string() : fmt::format("found '{}', expected {}", text, expected);
}

// Returns NaN for anything but a finite number.
double finiteOrNaN(std::string_view text) {
  const double value = parseDouble(text).value_or(NAN);
  return std::isfinite(value) ? value : NAN;
}

bool hasDefault(const Flags::Variable& variable) {
  if (auto* const* text = std::get_if<std::string*>(&variable)) return !(*text)->empty();
  if (auto* const* number = std::get_if<double*>(&variable)) return **number != 0;
  return std::holds_alternative<int*>(variable);  // 0 is an ordinary value for these
}

// Replaces a word by the choice that it stands for.
CLI::Validator choiceCheck(const Values& values) {
  std::vector<AliasedName> names;
  for (const std::string& choice : values.choices) {
    const auto known = std::ranges::find(values.aliases, choice, &AliasedName::name);
    names.push_back({choice, known == values.aliases.end() ? "" : known->aliases});
  }
  const auto choose = [names, choices = values.choices](std::string& given) {
    const auto meant = meantName(given, names);
    if (!meant)
      return fmt::format("found '{}', expected one of {}\n  next: {}", given, join(choices, ", "),
                         didYouMeanOne(given, names, "give one of these"));
    given = *meant;
    return std::string();
  };
  return {choose, "{" + join(values.choices, ",") + "}"};
}

std::string longName(const CLI::Option& option) {
  return option.get_lnames().empty() ? std::string() : option.get_lnames().front();
}

}  // namespace

std::string finiteNumber(const std::string& text) {
  return numberComplaint(text, !std::isnan(finiteOrNaN(text)), "a finite number");
}

std::string positiveNumber(const std::string& text) {
  return numberComplaint(text, finiteOrNaN(text) > 0, "a finite number above 0");
}

std::string nonNegativeNumber(const std::string& text) {
  return numberComplaint(text, finiteOrNaN(text) >= 0, "a finite number, 0 or more");
}

std::string pixelComplaint(const std::string& text) {
  return numberComplaint(text, parsePixels(text).has_value(),
                         "a positive number of pixels\n  next: give a value such as 0.1px");
}

std::string sizeComplaint(const std::string& text) {
  return numberComplaint(text, parseSize(text).has_value(), "WIDTHxHEIGHT in pixels, such as 640x480");
}

std::string wholeComplaint(const std::string& text, int least, int most) {
  const auto number = parseInt(text);
  return numberComplaint(text, number && *number >= least && *number <= most,
                         fmt::format("a whole number from {} to {}", least, most));
}

std::optional<std::vector<int>> wholeNumbers(std::string_view text, char separator, std::size_t count) {
  std::vector<int> numbers;
  for (const std::string_view part : split(text, separator)) {
    const auto number = parseInt(trim(part));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers.size() == count ? std::optional(numbers) : std::nullopt;
}

std::optional<ImageSize> parseSize(std::string_view text) {
  constexpr int kMaxSide = 1'000'000;
  const auto sides = wholeNumbers(text, 'x', 2);
  if (!sides || std::ranges::min(*sides) < 1 || std::ranges::max(*sides) > kMaxSide) return std::nullopt;
  return ImageSize{.width = sides->front(), .height = sides->back()};
}

std::optional<double> parsePixels(std::string_view text) {
  const double value = pixelsOrNan(std::string(text));
  return value > 0 ? std::optional(value) : std::nullopt;
}

double pixelsOrNan(const std::string& text) {
  std::string_view number = trim(text);
  if (number.ends_with("px")) number = trim(number.substr(0, number.size() - 2));
  return finiteOrNaN(number);
}

double metresOrNan(const std::string& text) {
  try {
    return parseLength(text, "");
  } catch (const Error&) {
    return NAN;
  }
}

Values aside(Values values) {
  values.is_aside = true;
  return values;
}

Values oneOf(std::vector<std::string> choices, char separator, std::vector<AliasedName> aliases) {
  return {.choices = std::move(choices), .aliases = std::move(aliases), .separator = separator};
}

void Flags::explain(const std::string& text) {
  parser_->footer(text);
}

void Flags::place(CLI::Option* option, bool is_aside) {
  if (heading_ != nullptr) option->group(heading_);
  if (is_aside) aside_.insert(option);
}

void Flags::add(const std::string& names, Variable variable, const std::string& text, const Values& values) {
  CLI::Option* const option = std::visit(
      [&](auto* to) {
        if constexpr (std::is_same_v<decltype(to), std::optional<ImageSize>*>) {
          return parser_->add_option_function<std::string>(
              names, [to](const std::string& given) { *to = parseSize(given); }, text);
        } else {
          return parser_->add_option(names, *to, text);
        }
      },
      variable);
  place(option, values.is_aside);
  if (values.word != nullptr) option->type_name(values.word);
  if (values.complaint != nullptr) option->check(values.complaint, values.limits);
  if (!values.choices.empty()) option->transform(choiceCheck(values));
  if (values.separator != 0) option->delimiter(values.separator);
  if (values.is_single) option->allow_extra_args(false);
  if (values.number != nullptr) {
    // Text that is not a number is left to the following check.
    option->transform(CLI::Validator(
        [number = values.number](std::string& given) {
          if (const double value = number(given); !std::isnan(value)) given = exactText(value);
          return std::string();
        },
        ""));
  }
  if (hasDefault(variable)) option->capture_default_str();
}

void Flags::addSwitch(const std::string& names, bool& variable, const std::string& text, bool is_aside) {
  place(parser_->add_flag(names, variable, text), is_aside);
}

void Flags::redirect(const std::vector<std::string>& names, const std::string& next_step) {
  for (const std::string& name : names) redirects_.emplace_back(name, next_step);
}

std::string Flags::redirection(std::span<const char* const> words) const {
  for (const std::string_view word : words) {
    for (const auto& [name, next_step] : redirects_) {
      if (word.substr(0, word.find('=')) != name) continue;
      return command() + ": " + name + ": no flag of this command\n  next: " + next_step;
    }
  }
  return "";
}

void Flags::addCommon(CommonOptions& options, bool has_jobs) {
  options.command = command();
  under(kCommonGroup);
  addSwitch("--json", options.json, "Print only one JSON document to standard output", true);
  addSwitch("--quiet", options.quiet, "Print no progress and no messages except errors", true);
  if (has_jobs) {
    add("--jobs", &options.jobs,
        "Number of threads; 0 means one per processor. It does not affect the result",
        {.complaint = [](const std::string& text) { return wholeComplaint(text, 0, 1024); },
         .limits = "0 to 1024",
         .is_aside = true});
  }
  add("--config", &options.config, "YAML file with flags as keys; flags on the command line take precedence",
      aside(kFilePath));
}

bool Flags::isGiven(const std::string& name) const {
  return parser_->count(name) > 0;
}

std::string Flags::command() const {
  return commandName(*parser_);
}

void Flags::applySettingsFile(const std::string& path) {
  std::vector<std::string> names;
  for (const CLI::Option* option : parser_->get_options()) {
    const std::string name = longName(*option);
    const bool is_key = name != "help" && name != "config";
    if (is_key && !name.empty()) names.push_back(name);
  }
  for (const SettingEntry& entry : readSettingsFile(path)) {
    if (std::find(names.begin(), names.end(), entry.key) == names.end()) {
      throw inputError({.where = entry.where,
                        .found = "'" + entry.key + "' is not a flag of " + command(),
                        .expected = "one of " + join(names, ", "),
                        .next_step = didYouMean(entry.key, names)});
    }
    CLI::Option* option = parser_->get_option("--" + entry.key);
    if (option->count() > 0) continue;  // given on the command line
    try {
      for (const std::string& value : entry.values) option->add_result(value);
      option->run_callback();
    } catch (const CLI::Error& e) {
      throw inputError({.where = entry.where, .found = e.what()});
    }
  }
}

std::vector<Flags::Setting> Flags::settings() const {
  std::vector<Setting> settings;
  for (const CLI::Option* option : parser_->get_options()) {
    const std::string name = longName(*option);
    if (name.empty() || name == "help" || aside_.contains(option)) continue;
    if (option->count() > 0) {
      settings.emplace_back(name, option->results());
    } else if (!option->get_default_str().empty()) {
      settings.emplace_back(name, std::vector<std::string>{option->get_default_str()});
    }
  }
  std::sort(settings.begin(), settings.end());
  return settings;
}

std::string callOf(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : callOf(*parent) + " " + app.get_name();
}

std::string commandName(const CLI::App& command) {
  const std::string call = callOf(command);
  return call.substr(call.find(' ') + 1);
}

}  // namespace alidade
