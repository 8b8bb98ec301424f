// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/files/camera_list.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/footage/follow/footage_frames.h"
#include "alidade/validate/camera_checks.h"
#include "alidade/validate/file_tests.h"
#include "board_views.h"
#include "commands/validate/validation_output.h"
#include "console.h"
#include "options.h"
#include "report_output.h"

namespace alidade {
namespace {

bool isJunitReport(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  for (int i = 0; i < 2 && std::getline(file, line); ++i) {
    if (line.starts_with("<testsuites")) return true;
  }
  return false;
}

class ValidateCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade validate camera.yaml\nExample: alidade validate calibrations/ --strict --junit "
        "report.xml\nExample: alidade validate camera.yaml --images photos/ --board "
        "checkerboard:9x6:25mm\nExample: alidade validate "
        "camera.yaml --footage walk.mp4\nPrints a line for each file and the totals; --verbose adds a line "
        "for each "
        "check, --quiet prints only files that fail.\nFolders are searched with their sub-folders for yaml, "
        "yml, json, xml, txt, cameramodel and cam. Files that do not name\na camera are only counted. Of a "
        "rig, "
        "the poses are checked too.\n"
        "--images tests the camera on photographs that were not used for its calibration. Use 10 or "
        "more.\n--footage tests it on ordinary pictures of a scene in which nothing moves, without a board "
        "(docs/footage.md): whether\nanother focal length, centre or distortion explains them better. It may "
        "be unable to "
        "tell; that is a warning.\nFiles may have any supported format (docs/formats.md); FILE#NAME selects "
        "one camera of a "
        "file with several.\nExit code 0: no file failed; 1: no camera file, or --images, --footage or "
        "--against "
        "cannot be used; 3: a file failed.");
    app.add_option("file", files_, "Camera files, folders, or patterns in quotes")->type_name(kFileValue);
    app.add_flag("--strict", is_strict_, "Treat warnings as failures");
    app.add_flag("--verbose", is_verbose_, "Print every check");
    app.add_option("--junit", junit_path_, "Write the result as JUnit XML to this file")
        ->type_name(kFileValue);
    app.add_option("--report", report_,
                   "HTML page to write: what was found, with figures, in one file that needs no network")
        ->type_name(kFileValue);
    addCameraOptions(app, camera_);
    app.add_option("--images", images_,
                   "Images of a board that were not used for the calibration: folders, files or patterns, or "
                   "corners files (.csv or .vnl)")
        ->type_name(kFileValue);
    addBoardOption(app, boards_);
    addDetectionOptions(app, detection_);
    app.add_option(
           "--footage", footage_,
           "Pictures of a scene in which nothing moves: a video, a numbered sequence (img%04d.png), or "
           "photographs (folders, files or patterns)")
        ->group(kFootageGroup)
        ->type_name(kFileValue);
    app.add_option(
           "--front-end", front_end_,
           "How points are followed from picture to picture. flow: small motions, as in a video; keypoints: "
           "by what they look like, as in photographs. Not given: flow for a video or sequence, else "
           "keypoints")
        ->group(kFootageGroup)
        ->check(CLI::IsMember({"flow", "keypoints"}));
    app.add_option("--against", against_, "Camera file (any format) to compare with")->type_name(kFileValue);
    tolerance_flag_ =
        app.add_option("--tolerance", tolerance_px_,
                       "Largest accepted error in pixels (95th percentile; --images: where boards were "
                       "seen), for --images and --against. For --footage, whose default is 1, a fifth of the "
                       "error that surely fails")
            ->check(positiveNumber, "above 0")
            ->capture_default_str();
    takePixels(*tolerance_flag_);
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (files_.empty())
      throw missingError("validate", "no file", "camera files, or folders with camera files");
    const std::vector<ListedFile> listed = listCameraFiles(files_);
    checkJunitPath(listed);
    checkReportPath(listed);
    checkFootageFlags(listed);
    prepareComparisons();
    followFootage();
    ValidationResult result = judgeAll(listed);
    result.tolerance_px = tests_.tolerance_px;
    result.boards = tests_.boards;
    if (result.files.empty()) {
      throw inputError({.where = files_.front(),
                        .found = fmt::format("no camera file among {} file{}", listed.size(),
                                             listed.size() == 1 ? "" : "s"),
                        .expected = "at least one",
                        .next_step = "see docs/formats.md for the formats"});
    }
    if (!junit_path_.empty()) writeFileAtomically(junit_path_, junitText(result));
    if (!report_.empty()) {
      PageOptions page{.num_jobs = common_.jobs};
      if (given_) page.pictures = picturesOf(*given_, passing_);
      writeValidationReport(report_, validationEvidenceJson(result, printable(against_), tests_.other), page);
    }
    print(result);
    if (!report_.empty() && !common_.quiet) printMessage("report written to " + report_);
    const bool is_any_failed = std::any_of(result.files.begin(), result.files.end(),
                                           [&](const auto& file) { return result.isFailed(file); });
    return is_any_failed ? kUntrustworthyExit : 0;
  }

 private:
  void checkJunitPath(const std::vector<ListedFile>& listed) const {
    if (junit_path_ == "-") {
      throw usageError({.where = "--junit -",
                        .found = "standard output, which is used for the results",
                        .expected = "a file"});
    }
    std::vector<std::string> sources;
    for (const ListedFile& file : listed) {
      // A report of an earlier run in the same folder is replaced.
      if (!file.is_from_folder) sources.push_back(cameraFilePath(file.path));
    }
    sources.insert(sources.end(), footage_.begin(), footage_.end());
    checkOutput(junit_path_, sources, common_, "--junit");
    namespace fs = std::filesystem;
    std::error_code error;
    if (!junit_path_.empty() && fs::is_regular_file(junit_path_, error) && !isJunitReport(junit_path_)) {
      throw usageError({.where = "--junit " + junit_path_,
                        .found = "an existing file that is no JUnit report",
                        .expected = "a new file, or an earlier report",
                        .next_step = "choose another name, otherwise the file would be overwritten"});
    }
  }

  void checkReportPath(const std::vector<ListedFile>& listed) const {
    if (report_.empty()) return;
    const bool is_junit = !junit_path_.empty() && writtenPath(report_) == writtenPath(junit_path_);
    if (report_ == "-" || is_junit) {
      throw usageError(
          {.where = "--report " + report_,
           .found = is_junit ? "the same file as --junit" : "standard output, which is used for the results",
           .expected = "a different file, for example page.html"});
    }
    std::vector<std::string> sources =
        images_.empty() || isCornersFile(images_.front()) ? images_ : withImages(images_);
    if (!footage_.empty()) {
      const std::vector<std::string> pictures = withImages(footage_);
      sources.insert(sources.end(), pictures.begin(), pictures.end());
    }
    for (const ListedFile& file : listed) sources.push_back(cameraFilePath(file.path));
    sources.insert(sources.end(), boards_.begin(), boards_.end());
    sources.insert(sources.end(), {cameraFilePath(against_), common_.config});
    checkOutput(report_, sources, common_, "--report");
  }

  // Finds the boards and reads the other camera, once for all files that are tested.
  void prepareComparisons() {
    if (images_.empty() && !boards_.empty()) {
      throw usageError({.where = "validate",
                        .found = "--board without --images",
                        .expected = "--images FOLDER with images of the board"});
    }
    tests_.tolerance_px = tolerance_px_;
    tests_.jobs = common_.jobs;
    if (!against_.empty()) tests_.other = readCameraTelling(against_, {}, common_.quiet);
    if (images_.empty()) return;
    tests_.cancel = catchInterrupts();
    given_ = readViews({.command = "validate",
                        .inputs = images_,
                        .boards = boards_,
                        .detection = detection_,
                        .pictures = report_.empty() ? nullptr : &passing_,
                        .image_size = camera_.readOptions().image_size},
                       common_, tests_.cancel);
    tests_.boards = given_->boards;
    tests_.views = given_->views;
    if (common_.quiet) return;
    for (const std::string& reason : given_->reasons) printMessage("  " + reason);
    for (const std::string& note : given_->notes) printMessage("note: " + note);
  }

  // Footage is of one camera: a file that was named must not have several.
  void checkFootageFlags(const std::vector<ListedFile>& listed) const {
    if (footage_.empty()) {
      if (front_end_.empty()) return;
      throw usageError({.where = "validate",
                        .found = "--front-end without --footage",
                        .expected = "--footage with a video or photographs"});
    }
    for (const ListedFile& file : listed) {
      if (file.is_from_folder) continue;
      std::vector<std::string> names;
      try {
        const CameraSource source = readCamerasToJudge(file.path, camera_.readOptions());
        for (const StatedCamera& camera : source.cameras) names.push_back(cameraLabel(camera));
        for (const RefusedCamera& camera : source.refused) names.push_back(cameraLabel(camera));
      } catch (const Error&) {
        continue;  // its judgement says why
      }
      if (names.size() <= 1) continue;
      throw usageError({.where = "--footage: " + file.path,
                        .found = fmt::format("a file with {} cameras", names.size()),
                        .expected = "the one camera that took the footage",
                        .next_step = fmt::format("test each camera alone: {}#{}", file.path, names.front())});
    }
  }

  // Follows points through the footage, once for all files that are tested.
  void followFootage() {
    if (footage_.empty()) return;
    tests_.cancel = catchInterrupts();
    if (tolerance_flag_->count() > 0) tests_.footage_tolerance_px = tolerance_px_;
    const bool is_flow = front_end_.empty() ? isVideoFootage(footage_) : front_end_ == "flow";
    FootagePass pass;
    ProgressBar bar("following points", common_.quiet);
    FootagePassOptions options;
    options.progress = [&](std::size_t done, std::size_t total) { bar.update(done, total); };
    options.cancel = tests_.cancel;
    tests_.footage =
        trackFootage(footage_, is_flow ? FrontEndKind::kFlow : FrontEndKind::kKeyPoints, pass, options);
    tests_.num_footage_frames = pass.num_frames - pass.num_damaged;
    if (common_.quiet) return;
    for (const std::string& note : pass.notes) printMessage("note: " + note);
  }

  [[nodiscard]] ValidationResult judgeAll(const std::vector<ListedFile>& listed) const {
    std::vector<std::optional<FileJudgement>> judgements(listed.size());
    // The checks with images and footage share out their own work.
    const int num_jobs = tests_.views.empty() && !tests_.footage ? common_.jobs : 1;
    parallelFor(listed.size(), num_jobs,
                [&](std::size_t i) { judgements[i] = judgeFile(listed[i], camera_.readOptions(), tests_); });
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
    if (common_.json) return printResult(judgementJson(result));
    if (common_.quiet) return printResult(filesText(result, true));
    printResult((is_verbose_ ? checksText(result) : filesText(result, false)) + totalsText(totalsOf(result)));
  }

  std::vector<std::string> files_;
  std::string junit_path_;
  std::string report_;
  bool is_strict_ = false;
  bool is_verbose_ = false;
  CameraOptions camera_;
  std::vector<std::string> images_;
  std::vector<std::string> boards_;
  DetectionOptions detection_;
  std::vector<std::string> footage_;
  std::string front_end_;
  std::string against_;
  double tolerance_px_ = kDefaultTolerancePx;
  CLI::Option* tolerance_flag_ = nullptr;
  FileTests tests_;
  std::optional<GivenViews> given_;
  PassingPictures passing_;
};

}  // namespace

std::unique_ptr<Command> makeValidateCommand() {
  return std::make_unique<ValidateCommand>();
}

}  // namespace alidade
