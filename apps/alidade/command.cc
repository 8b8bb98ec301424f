// SPDX-License-Identifier: MIT
#include "command.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"

namespace alidade {

std::vector<CommandEntry> makeCommands() {
  std::vector<CommandEntry> commands;
  const auto add = [&](const char* name, const char* summary, std::unique_ptr<Command> command) {
    commands.push_back({name, summary, std::move(command)});
  };
  add("calibrate", "Calibrate a camera from images of a board, or from a corners file",
      makeCalibrateCommand());
  add("detect", "Find a board's corners in images", makeDetectCommand());
  add("project", "Project 3D points to pixels", makeProjectCommand());
  add("unproject", "Turn pixels into rays", makeUnprojectCommand());
  add("validate", "Check a camera file", makeValidateCommand());
  add("simulate", "Render images of a board with known truth", makeSimulateCommand());
  return commands;
}

void addCommonOptions(CLI::App& app, CommonOptions& options, bool has_jobs) {
  app.add_flag("--json", options.json, "One JSON document on standard output, nothing else there");
  app.add_flag("--quiet", options.quiet, "No progress and no messages but errors");
  if (has_jobs) {
    app.add_option("--jobs", options.jobs, "Threads; 0 = one per processor. The result does not depend on it")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
  }
  app.add_option("--config", options.config, "YAML file with these flags as keys; flags given here go first");
}

std::string programName() {
  return "alidade " ALIDADE_VERSION;
}

void printResult(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return;
  throw inputError({.where = "standard output",
                    .found = std::strerror(errno),
                    .next_step = "make room, or send the output elsewhere"});
}

void printMessage(const std::string& text) {
  std::fprintf(stderr, "%s\n", text.c_str());
}

}  // namespace alidade
