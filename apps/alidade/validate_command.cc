// SPDX-License-Identifier: MIT
#include <algorithm>
#include <optional>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/files/atomic_file.h"
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
        "Example: alidade validate camera.yaml\nExample: alidade validate calibrations/ --strict --junit "
        "report.xml\nExample: alidade validate camera.yaml --images photos/ --board "
        "checkerboard:9x6:25mm\nPrints a line for each file and the totals; --verbose adds a line for each "
        "check, --quiet prints only files that fail.\nFolders are searched with their sub-folders for yaml, "
        "yml, json, xml, txt, cameramodel and cam. Files that do not name\na camera are only counted.\n"
        "--images tests the camera on photographs that were not used for its calibration. Use 10 or "
        "more.\nFiles may have any supported format (docs/formats.md); FILE#NAME selects one camera of a "
        "file "
        "with several.\nExit code 0: no file failed; 1: nothing to validate, or another input cannot be "
        "used; "
        "3: a file failed.");
    app.add_option("file", files_, "Camera files, folders, or patterns in quotes");
    app.add_flag("--strict", is_strict_, "Fail files with warnings");
    app.add_flag("--verbose", is_verbose_, "Print every check");
    app.add_option("--junit", junit_path_, "Write the result as JUnit XML to this file");
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
    const std::vector<ListedFile> listed = listCameraFiles(files_);
    checkJunitPath(listed);
    held_out_.prepare(common_);
    const ValidationResult result = judgeAll(listed);
    if (result.files.empty()) {
      throw inputError({.where = files_.front(),
                        .found = "no camera file among " + std::to_string(listed.size()) + " files",
                        .expected = "at least one",
                        .next_step = "see docs/formats.md for the formats"});
    }
    if (!junit_path_.empty()) writeFileAtomically(junit_path_, junitText(result));
    print(result);
    const bool is_any_failed = std::any_of(result.files.begin(), result.files.end(),
                                           [&](const auto& file) { return result.isFailed(file); });
    return is_any_failed ? static_cast<int>(ErrorCode::kVerdict) : 0;
  }

 private:
  void checkJunitPath(const std::vector<ListedFile>& listed) const {
    if (junit_path_ == "-") {
      throw usageError({.where = "--junit -",
                        .found = "standard output, which has the lines about the files",
                        .expected = "a file"});
    }
    std::vector<std::string> sources;
    for (const ListedFile& file : listed) {
      // A report of an earlier run in the same folder is replaced.
      if (!file.is_from_folder) sources.push_back(cameraFilePath(file.path));
    }
    checkOutput(junit_path_, sources, common_, "--junit");
  }

  // Files of a folder need not be those that --image-size and --read-as are for: what can be read completely
  // without them states it itself.
  [[nodiscard]] CameraSource readListed(const ListedFile& file) const {
    const ReadOptions options = camera_.readOptions();
    const bool has_options = options.image_size || !options.model.empty();
    if (!file.is_from_folder || !has_options) return readCamerasToJudge(file.path, options);
    try {
      CameraSource source = readCamerasToJudge(file.path, {.image_size = {}, .model = {}});
      const bool is_complete = std::all_of(source.cameras.begin(), source.cameras.end(),
                                           [](const StatedCamera& c) { return c.image_size.has_value(); });
      if (is_complete) return source;
    } catch (const NotACameraFile&) {
      throw;
    } catch (const Error&) {
      return readCamerasToJudge(file.path, options);
    }
    return readCamerasToJudge(file.path, options);
  }

  // Nothing: a file of a folder that is not a camera file.
  [[nodiscard]] std::optional<FileJudgement> judge(const ListedFile& file) const {
    FileJudgement judgement{.file = file.path, .format = {}, .error = {}, .cameras = {}};
    try {
      const CameraSource source = readListed(file);
      judgement.format = source.format;
      for (const StatedCamera& camera : source.cameras) {
        judgement.cameras.push_back(judgeCamera(camera, file.path));
        held_out_.addChecks(camera, file.path, judgement.cameras.back());
      }
      for (const RefusedCamera& camera : source.refused)
        judgement.cameras.push_back(judgeRefused(camera, file.path));
    } catch (const NotACameraFile& e) {
      if (file.is_from_folder) return std::nullopt;
      judgement.error = withoutPath(e.what(), cameraFilePath(file.path));
    } catch (const Error& e) {
      if (e.code() != ErrorCode::kInput) throw;
      judgement.error = withoutPath(e.what(), cameraFilePath(file.path));
    }
    return judgement;
  }

  [[nodiscard]] ValidationResult judgeAll(const std::vector<ListedFile>& listed) const {
    std::vector<std::optional<FileJudgement>> judgements(listed.size());
    // The checks with images share out their own work.
    const int num_jobs = held_out_.hasImages() ? 1 : common_.jobs;
    parallelFor(listed.size(), num_jobs, [&](std::size_t i) { judgements[i] = judge(listed[i]); });
    ValidationResult result{.files = {}, .other_files = {}, .is_strict = is_strict_};
    for (std::size_t i = 0; i < listed.size(); ++i) {
      if (judgements[i]) {
        result.files.push_back(*std::move(judgements[i]));
      } else {
        result.other_files.push_back(listed[i].path);
      }
    }
    return result;
  }

  void print(const ValidationResult& result) const {
    if (common_.json) return printResult(jsonText(judgementJson(result)));
    printResult(common_.quiet ? failuresText(result) : judgementText(result, is_verbose_));
  }

  std::vector<std::string> files_;
  std::string junit_path_;
  bool is_strict_ = false;
  bool is_verbose_ = false;
  HeldOutStage held_out_;
  CameraOptions camera_;
};

}  // namespace

std::unique_ptr<Command> makeValidateCommand() {
  return std::make_unique<ValidateCommand>();
}

}  // namespace alidade
