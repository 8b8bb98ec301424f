// SPDX-License-Identifier: MIT
#include "options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error_text.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/board_file.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/settings_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/target/board_spec.h"
#include "console.h"

namespace alidade {
namespace {

// What is wrong with the text of a flag's number; empty if it is good.
std::string numberComplaint(const std::string& text, bool is_good, const char* expected) {
  return is_good ? std::string() : fmt::format("found '{}', expected {}", text, expected);
}

// NaN for anything that is not a finite number.
double finiteOrNaN(std::string_view text) {
  const double value = parseDouble(text).value_or(NAN);
  return std::isfinite(value) ? value : NAN;
}

// Flags that say how a result is shown or where it goes, not what it is.
const std::set<std::string> kOutsideTheResult = {"help",      "config",       "json",
                                                 "quiet",     "jobs",         "cache",
                                                 "output",    "input",        "keep-untrustworthy",
                                                 "next-view", "target-sigma", "evidence",
                                                 "name",      "serial",       "verbose"};

std::string longName(const CLI::Option& option) {
  return option.get_lnames().empty() ? std::string() : option.get_lnames().front();
}

}  // namespace

void addCommonOptions(CLI::App& app, CommonOptions& options, bool has_jobs) {
  app.add_flag("--json", options.json, "Print only one JSON document to standard output")
      ->group(kCommonGroup);
  app.add_flag("--quiet", options.quiet, "Print no progress and no messages except errors")
      ->group(kCommonGroup);
  if (has_jobs) {
    const auto complaint = [](const std::string& text) {
      const int jobs = parseInt(text).value_or(-1);
      return numberComplaint(text, jobs >= 0 && jobs <= 1024, "a whole number from 0 to 1024");
    };
    app.add_option("--jobs", options.jobs,
                   "Number of threads; 0 means one per processor. It does not affect the result")
        ->group(kCommonGroup)
        ->check(complaint, "0 to 1024")
        ->capture_default_str();
  }
  app.add_option("--config", options.config,
                 "YAML file with flags as keys; flags on the command line take precedence")
      ->group(kCommonGroup)
      ->type_name(kFileValue);
}

void addBoardOption(CLI::App& app, std::vector<std::string>& boards) {
  const auto complaint = [](const std::string& source) -> std::string {
    try {
      (void)readBoard(source);
    } catch (const Error& e) {
      if (e.code() == ErrorCode::kUsage) return e.what();  // what is wrong in a board file is no wrong usage
    }
    return {};
  };
  app.add_option("--board", boards,
                 "Board SPEC (" + join(mapped(boardKinds(), &BoardKindName::example), "; ") +
                     ") or YAML file; repeat it for several boards")
      ->group(kBoardGroup)
      ->type_name(kSpecValue)
      ->check(complaint, "")
      ->allow_extra_args(false);  // what follows a SPEC is an input
}

void addDetectionOptions(CLI::App& app, DetectionOptions& options) {
  constexpr int kMostFrames = 10000;
  const auto complaint = [](const std::string& text) {
    const int count = parseInt(text).value_or(0);
    return numberComplaint(text, count >= 1 && count <= kMostFrames, "a whole number from 1 to 10000");
  };
  // The default is not among the effective settings, as it means nothing for photographs.
  app.add_option(
         "--frames", options.num_frames,
         fmt::format("How many frames of each video or image sequence to search for boards: sharp ones that "
                     "differ from each other (default: {})",
                     options.num_frames))
      ->group(kBoardGroup)
      ->check(complaint, "");
  app.add_option("--cache", options.cache,
                 "Folder for the results of detection. Images that it knows are not searched again")
      ->group(kBoardGroup)
      ->type_name(kFolderValue);
}

void addDebugOption(CLI::App& app, std::string& folder) {
  app.add_option("--debug", folder,
                 "Folder for copies of the images with the corners, their ids and the board's axes drawn in")
      ->group(kBoardGroup)
      ->type_name(kFolderValue);
}

ReadOptions CameraOptions::readOptions() const {
  return {.image_size = parseSize(size), .model = read_as};
}

void addCameraOptions(CLI::App& app, CameraOptions& options) {
  app.add_option("--image-size", options.size,
                 "Image size in pixels (WIDTHxHEIGHT), for camera files that do not state it")
      ->group(kCameraFileGroup)
      ->check(sizeComplaint, "");
  app.add_option(
         "--read-as", options.read_as,
         "Model of four distortion coefficients, for files that do not state it: radtan or kannala_brandt")
      ->group(kCameraFileGroup)
      ->check(CLI::IsMember({"radtan", "kannala_brandt"}));
}

CameraRecord readCameraTelling(const std::string& path, const ReadOptions& options, bool quiet) {
  return onlyCameraTelling(loadCameras(path, options), quiet);
}

CameraRecord onlyCameraTelling(const CameraSource& source, bool quiet) {
  CameraRecord file = onlyCamera(source);
  if (quiet) return file;
  for (const Remark& remark : source.cameras.front().remarks) printMessage("note: " + remark.message);
  return file;
}

std::string finiteNumber(const std::string& text) {
  return numberComplaint(text, !std::isnan(finiteOrNaN(text)), "a finite number");
}

std::string positiveNumber(const std::string& text) {
  return numberComplaint(text, finiteOrNaN(text) > 0, "a finite number above 0");
}

std::string nonNegativeNumber(const std::string& text) {
  return numberComplaint(text, finiteOrNaN(text) >= 0, "a finite number, 0 or more");
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

std::string sizeComplaint(const std::string& text) {
  return numberComplaint(text, parseSize(text).has_value(), "WIDTHxHEIGHT in pixels, such as 640x480");
}

namespace {

double pixelsOrNan(std::string_view text) {
  text = trim(text);
  if (text.ends_with("px")) text = trim(text.substr(0, text.size() - 2));
  return finiteOrNaN(text);
}

// A flag's text without its unit; what is no number stays for the check that follows to complain about.
void takeUnit(CLI::Option& option, double (*parsed)(const std::string&)) {
  option.transform(CLI::Validator(
      [parsed](std::string& text) {
        if (const double value = parsed(text); !std::isnan(value)) text = exactText(value);
        return std::string();
      },
      ""));
}

}  // namespace

std::optional<double> parsePixels(std::string_view text) {
  const double value = pixelsOrNan(text);
  return value > 0 ? std::optional(value) : std::nullopt;
}

BoardShapeMode shapeMode(std::string_view name) {
  if (name == "flat") return BoardShapeMode::kFlat;
  if (name == "warp") return BoardShapeMode::kWarp;
  return name == "uneven" ? BoardShapeMode::kUneven : BoardShapeMode::kAuto;
}

std::string pixelComplaint(const std::string& text) {
  return numberComplaint(text, parsePixels(text).has_value(),
                         "a positive number of pixels\n  next: give a value such as 0.1px");
}

void takePixels(CLI::Option& option) {
  takeUnit(option, [](const std::string& text) { return pixelsOrNan(text); });
}

void takeLength(CLI::Option& option) {
  takeUnit(option, [](const std::string& text) {
    try {
      return parseLength(text, "");
    } catch (const Error&) {
      return std::numeric_limits<double>::quiet_NaN();
    }
  });
}

std::string callOf(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : callOf(*parent) + " " + app.get_name();
}

std::string commandName(const CLI::App& command) {
  const std::string call = callOf(command);
  return call.substr(call.find(' ') + 1);
}

Error missingError(const std::string& command, const std::string& found, const std::string& expected) {
  // A flag's value is all that is missing; an input needs the help.
  return usageError({.where = command,
                     .found = found,
                     .expected = expected,
                     .next_step = found.starts_with("no --") ? "" : "alidade " + command + " --help"});
}

Error noneUsableError(std::size_t num_images, const std::string& complaint, const std::string& first_error) {
  constexpr std::string_view kNextLine = "\n  next: ";
  const std::size_t end = first_error.find(kNextLine);
  const bool has_next = end != std::string::npos;
  return inputError({.where = fmt::format("{} images", num_images),
                     .found = complaint + "; the first error: " + oneLine(first_error.substr(0, end)),
                     .next_step = has_next ? oneLine(first_error.substr(end + kNextLine.size())) : ""});
}

std::vector<std::string> withImages(std::vector<std::string> inputs) {
  try {
    const std::vector<std::string> files = listInputs(inputs).all();
    inputs.insert(inputs.end(), files.begin(), files.end());
  } catch (const Error&) {
    // A complaint about the output comes first; this one comes again when the images are read.
  }
  return inputs;
}

std::string notWritten(const std::string& output) {
  std::error_code ignored;
  const bool is_older = output != "-" && std::filesystem::exists(output, ignored);
  return output + " was not written" + (is_older ? "; the file of that name is an older one" : "");
}

std::vector<std::string> formatIds() {
  return mapped(cameraFormats(), [](const CameraFormat* format) { return std::string(format->id); });
}

void printRefusal(const std::string& claim, const std::string& output, bool is_kept) {
  printMessage("error: " + claim +
               (is_kept || output.empty()
                    ? ""
                    : "; " + notWritten(output) + " (use --keep-untrustworthy to write it anyway)"));
}

void checkOutput(const std::string& output, const std::vector<std::string>& sources,
                 const CommonOptions& options, const std::string& flag) {
  if (output.empty()) return;
  for (const std::string& source : sources) {
    std::error_code ignored;  // of paths that do not exist, which are not the same then
    if (!std::filesystem::equivalent(output, source, ignored)) continue;
    throw usageError({.where = flag + " " + output,
                      .found = "this is also an input",
                      .expected = "a different file",
                      .next_step = "choose another name, otherwise the input would be overwritten"});
  }
  if (output != "-") return checkWritable(output);
  if (options.json) {
    throw usageError({.where = "--json with " + flag + " -",
                      .found = "both write to standard output",
                      .expected = "only one of them",
                      .next_step = "give " + flag + " a file name, or remove one of the two flags"});
  }
}

void applySettingsFile(CLI::App& app, const std::string& path) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    const std::string name = longName(*option);
    if (!name.empty() && name != "help" && name != "config") names.push_back(name);
  }
  for (const SettingEntry& entry : readSettingsFile(path)) {
    if (std::find(names.begin(), names.end(), entry.key) == names.end()) {
      throw inputError({.where = entry.where,
                        .found = "'" + entry.key + "' is not a flag of " + commandName(app),
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
