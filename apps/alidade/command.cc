// SPDX-License-Identifier: MIT
#include "command.h"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/board_file.h"
#include "alidade/imagery/image_list.h"
#include "number_check.h"
#include "one_line.h"

namespace alidade {

std::vector<CommandEntry> makeCommands() {
  std::vector<CommandEntry> commands;
  const auto add = [&](const char* name, const char* summary, std::unique_ptr<Command> command) {
    commands.push_back({name, summary, std::move(command)});
  };
  add("calibrate", "Calibrate a camera from images of a board or from a corners file",
      makeCalibrateCommand());
  add("detect", "Detect the corners of a board in images", makeDetectCommand());
  add("project", "Project 3D points to pixels", makeProjectCommand());
  add("unproject", "Convert pixels to rays", makeUnprojectCommand());
  add("undistort", "Remove lens distortion from images", makeUndistortCommand());
  add("validate", "Check a camera file", makeValidateCommand());
  add("diff", "Compare two cameras by their projection difference", makeDiffCommand());
  add("convert", "Change the format, image size, orientation or lens model of a camera file",
      makeConvertCommand());
  add("simulate", "Render images of a board with known ground truth", makeSimulateCommand());
  return commands;
}

void addCommonOptions(CLI::App& app, CommonOptions& options, bool has_jobs) {
  app.add_flag("--json", options.json, "Print only one JSON document to standard output");
  app.add_flag("--quiet", options.quiet, "Print no progress and no messages except errors");
  if (has_jobs) {
    app.add_option("--jobs", options.jobs,
                   "Number of threads; 0 means one per processor. It does not affect the result")
        ->check(wholeNumber(0, 1024), "0 to 1024")
        ->capture_default_str();
  }
  app.add_option("--config", options.config,
                 "YAML file with flags as keys; flags on the command line take precedence");
}

void addBoardOption(CLI::App& app, std::string& board) {
  const auto complaint = [](const std::string& source) -> std::string {
    try {
      (void)readBoard(source);
    } catch (const Error& e) {
      if (e.code() == ErrorCode::kUsage) return e.what();  // what is wrong in a board file is no wrong usage
    }
    return {};
  };
  app.add_option("--board", board,
                 "Board SPEC (checkerboard:COLUMNSxROWS:SQUARE, where COLUMNS and ROWS count inner corners) "
                 "or YAML file")
      ->check(complaint, "");
}

std::string programName() {
  return "alidade " ALIDADE_VERSION;
}

std::string jsonText(const nlohmann::json& document) {
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

nlohmann::json orNull(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

std::vector<std::string> withImages(std::vector<std::string> inputs) {
  try {
    const std::vector<std::string> images = listImages(inputs);
    inputs.insert(inputs.end(), images.begin(), images.end());
  } catch (const Error&) {
    // A complaint about the output comes first; this one comes again when the images are read.
  }
  return inputs;
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

void printResult(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return;
  throw inputError({.where = "standard output",
                    .found = std::strerror(errno),
                    .next_step = "free some space, or redirect the output"});
}

void printMessage(const std::string& text) {
  std::string message;
  for (const std::string_view line : split(text, '\n')) message += printable(line) + "\n";
  std::fputs(message.c_str(), stderr);
}

}  // namespace alidade
