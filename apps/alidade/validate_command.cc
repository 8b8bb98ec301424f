// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/io/camera_file.h"
#include "alidade/validate/camera_checks.h"
#include "command.h"
#include "held_out_stage.h"

namespace alidade {
namespace {

class ValidateCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade validate camera.yaml\n"
        "Example: alidade validate camera.yaml --images photos/ --board checkerboard:9x6:25mm\n"
        "--images tests the camera on photographs that it was not calibrated from; 10 or more, as for a "
        "calibration.\n"
        "Exit code 0: no check failed; 1: a file cannot be read as a camera file; 3: a check failed.");
    app.add_option("file", files_, "Camera files (YAML)");
    held_out_.addOptions(app);
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (files_.empty())
      throw usageError({.where = "validate",
                        .found = "no file",
                        .expected = "camera files (YAML)",
                        .next_step = "alidade validate --help"});
    held_out_.prepare(common_);
    nlohmann::json documents = nlohmann::json::array();
    std::string text;
    std::size_t num_unreadable = 0;
    bool has_failed = false;
    for (const std::string& path : files_) {
      std::vector<Check> checks;
      try {
        checks = checkFile(path);
      } catch (const Error& e) {
        if (files_.size() == 1) throw;
        checks = {schemaCheck(CheckStatus::kFail, "cannot be read", e.what())};
        ++num_unreadable;
      }
      const auto num_failed = std::count_if(checks.begin(), checks.end(),
                                            [](const Check& c) { return c.status == CheckStatus::kFail; });
      has_failed = has_failed || num_failed > 0;
      text += table(path, checks, static_cast<int>(num_failed));
      documents.push_back(json(path, checks));
    }
    printResult(common_.json ? jsonText({{"files", documents}}) : text);
    if (num_unreadable > 0) {
      printMessage(fmt::format("error: {} of {} files cannot be read", num_unreadable, files_.size()));
      return static_cast<int>(ErrorCode::kInput);
    }
    return has_failed ? static_cast<int>(ErrorCode::kVerdict) : 0;
  }

 private:
  static Check schemaCheck(CheckStatus status, std::string value, std::string message) {
    return {.id = "schema",
            .status = status,
            .value = std::move(value),
            .limit = "camera file, format 1",
            .message = std::move(message)};
  }

  [[nodiscard]] std::vector<Check> checkFile(const std::string& path) const {
    const CameraFile file = readCameraFile(path);
    CameraClaims claims{.camera = &file.camera,
                        .image_size = file.image_size,
                        .domain = file.domain,
                        .self_check = file.self_check,
                        .parameter_std = {},
                        .covariance = {}};
    if (file.calibration) {
      claims.verdict = file.calibration->verdict;
      claims.parameter_std = file.calibration->parameter_std;
      claims.covariance = file.calibration->covariance;
    }
    std::vector<Check> checks = checkCamera(claims);
    checks.insert(checks.begin(), schemaCheck(CheckStatus::kPass, std::string(file.camera.modelId()),
                                              "all keys are known, all numbers are finite"));
    const std::vector<Check> held_out = held_out_.checks(file);
    checks.insert(checks.end(), held_out.begin(), held_out.end());
    return checks;
  }

  static std::string table(const std::string& path, const std::vector<Check>& checks, int num_failed) {
    std::string text = path + "\n";
    for (const Check& check : checks) {
      // A message of several lines stays in its column.
      text += fmt::format("  {}  {:<16} {}\n", checkStatusName(check.status), check.id,
                          fmt::join(split(check.message, '\n'), fmt::format("\n{:25}", "")));
      text += fmt::format("        {:<16} found {}; accepted {}\n", "", check.value, check.limit);
    }
    return text + (num_failed == 0
                       ? "  valid\n"
                       : fmt::format("  NOT valid: {} of {} checks failed\n", num_failed, checks.size()));
  }

  static nlohmann::json json(const std::string& path, const std::vector<Check>& checks) {
    nlohmann::json list = nlohmann::json::array();
    bool is_valid = true;
    for (const Check& check : checks) {
      is_valid = is_valid && check.status != CheckStatus::kFail;
      list.push_back({{"id", check.id},
                      {"status", checkStatusName(check.status)},
                      {"value", check.value},
                      {"limit", check.limit},
                      {"message", check.message}});
    }
    return {{"file", path}, {"valid", is_valid}, {"checks", list}};
  }

  std::vector<std::string> files_;
  HeldOutStage held_out_;
};

}  // namespace

std::unique_ptr<Command> makeValidateCommand() {
  return std::make_unique<ValidateCommand>();
}

}  // namespace alidade
