// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_list.h"
#include "alidade/files/camera_source.h"
#include "alidade/validate/file_judgement.h"
#include "camera_options.h"
#include "command.h"
#include "held_out_stage.h"
#include "judgement_output.h"

namespace alidade {
namespace {

class ValidateCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade validate camera.yaml\nExample: alidade validate calibrations/ --strict\nExample: "
        "alidade validate camera.yaml --images photos/ --board checkerboard:9x6:25mm\n--images tests the "
        "camera on photographs that were not used for its calibration. Use 10 or more.\nFiles may have any "
        "supported format (docs/formats.md); FILE#NAME selects one camera of a file with several.\nExit code "
        "0: no check failed; 1: a file cannot be read as a camera file; 3: a check failed.");
    app.add_option("file", files_, "Camera files, or folders with camera files");
    app.add_flag("--strict", is_strict_, "Treat warnings as failures");
    addCameraOptions(app, camera_);
    held_out_.addOptions(app);
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (files_.empty())
      throw usageError({.where = "validate",
                        .found = "no file",
                        .expected = "camera files, or folders with camera files",
                        .next_step = "alidade validate --help"});
    const CameraList list = listCameraFiles(files_);
    held_out_.prepare(common_);
    std::vector<FileJudgement> judgements;
    for (const ListedFile& file : list.files) judgeFile(file, list.files.size() == 1, judgements);
    const auto num_unreadable =
        std::count_if(judgements.begin(), judgements.end(), [](const auto& j) { return !j.isReadable(); });
    const bool is_valid =
        std::all_of(judgements.begin(), judgements.end(), [](const auto& j) { return j.isValid(); });
    print(judgements, list);
    if (!list.folders.empty() && !common_.quiet) {
      printMessage(
          fmt::format("note: {} sub-folders were skipped; list them explicitly to check their files: {}",
                      list.folders.size(), join(list.folders, ", ")));
    }
    if (!list.skipped.empty() && !common_.quiet) {
      printMessage(fmt::format("note: {} files were skipped because their format is unknown: {}",
                               list.skipped.size(), join(list.skipped, ", ")));
    }
    if (num_unreadable > 0) {
      printMessage(fmt::format("error: {} of {} files cannot be read", num_unreadable, list.files.size()));
      return static_cast<int>(ErrorCode::kInput);
    }
    return is_valid ? 0 : static_cast<int>(ErrorCode::kVerdict);
  }

 private:
  // Who names a folder names files for which --read-as is not meant: what can be read without it says itself
  // which model it has. The rest is read with it, and complaints are those of this reading.
  [[nodiscard]] CameraSource readListed(const ListedFile& file) const {
    const ReadOptions options = camera_.readOptions();
    if (file.is_from_folder && !options.model.empty()) {
      try {
        return readCamerasToJudge(file.path, {.image_size = options.image_size, .model = {}});
      } catch (const Error& e) {
        if (e.code() != ErrorCode::kInput) throw;
      }
    }
    return readCamerasToJudge(file.path, options);
  }

  void judgeFile(const ListedFile& file, bool is_only_file, std::vector<FileJudgement>& judgements) const {
    try {
      const CameraSource source = readListed(file);
      for (std::size_t i = 0; i < source.cameras.size(); ++i) {
        judgements.push_back(judgeCamera(source, i));
        held_out_.addChecks(source.cameras[i], judgements.back());
        if (is_strict_) failWarnings(judgements.back());
      }
      for (const RefusedCamera& camera : source.refused) judgements.push_back(judgeRefused(source, camera));
    } catch (const Error& e) {
      if ((is_only_file && !common_.json) || e.code() != ErrorCode::kInput) throw;
      judgements.push_back(judgeUnreadable(file.path, e.what()));
    }
  }

  static void failWarnings(FileJudgement& judgement) {
    for (Diagnosis& check : judgement.checks) {
      if (check.severity == Severity::kWarning) check.severity = Severity::kFailure;
    }
  }

  void print(const std::vector<FileJudgement>& judgements, const CameraList& list) const {
    if (common_.json) {
      nlohmann::json documents = nlohmann::json::array();
      for (const FileJudgement& judgement : judgements) documents.push_back(judgementJson(judgement));
      printResult(
          jsonText({{"files", std::move(documents)}, {"skipped", list.skipped}, {"folders", list.folders}}));
      return;
    }
    printResult(judgements.size() == 1 ? judgementText(judgements.front()) : judgementTable(judgements));
  }

  std::vector<std::string> files_;
  bool is_strict_ = false;
  HeldOutStage held_out_;
  CameraOptions camera_;
};

}  // namespace

std::unique_ptr<Command> makeValidateCommand() {
  return std::make_unique<ValidateCommand>();
}

}  // namespace alidade
