// SPDX-License-Identifier: MIT
#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/parallel.h"
#include "alidade/files/camera_list.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/footage/follow/footage_frames.h"
#include "alidade/report/pages/validation_page.h"
#include "alidade/validate/camera_checks.h"
#include "alidade/validate/file_tests.h"
#include "board_views.h"
#include "camera_files.h"
#include "command.h"
#include "commands/validate/validation_output.h"
#include "console.h"
#include "junit.h"
#include "outputs.h"
#include "page_file.h"

namespace alidade {
namespace {

class ValidateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade validate camera.yaml\nExample: alidade validate calibrations/ --strict --junit "
        "report.xml\nExample: alidade validate camera.yaml --images photos/ --board "
        "checkerboard:9x6:25mm\nExample: alidade validate camera.yaml --footage walk.mp4\nPrints a line for "
        "each file and the totals; --verbose adds a line for each check, --quiet prints only files that "
        "fail.\nFolders are searched with their sub-folders for yaml, yml, json, xml, txt, cameramodel and "
        "cam, and for\ntoml, conf, mat and bin files with a camera. Files without a camera are only counted "
        "(--verbose names them), also\nthose of other programs (ini, npz) that may hold one.\nOf a rig, the poses are checked too.\n--images tests the camera on photographs that were not used for its calibration. Use 10 or "
        "more.\n--footage tests it on ordinary pictures of a scene in which nothing moves, without a board "
        "(docs/footage.md): whether\nanother focal length, centre or distortion explains them better. It may "
        "be unable to tell; that is a warning.\nFiles may have any supported format (docs/formats.md); "
        "FILE#NAME selects one camera of a file with several.\nExit code 0: no file failed; 1: no camera "
        "file, or --images, --footage or --against cannot be used; 3: a file failed.");
    flags.add("file", &files_, "Camera files, folders, or patterns in quotes", kFilePath);
    flags.addSwitch("--strict", is_strict_, "Treat warnings as failures");
    flags.addSwitch("--verbose", is_verbose_, "Print every check");
    addJunitFlag(flags, common_);
    addReportFlag(flags, report_, "what was found, with figures");
    addDateFlag(flags, date_);
    flags.redirect({"--model"}, "--read-as MODEL, for files that do not state it (alidade validate --help)");
    addReadOptions(flags, camera_);
    flags.add("--images", &images_.inputs,
              "Images of a board that were not used for the calibration: folders, files or patterns, or "
              "corners files (.csv or .vnl)",
              kFilePath);
    images_.addBoards(flags);
    images_.addDetection(flags, false);
    images_.addMirrored(flags);
    flags.under(kFootageGroup);
    flags.add("--footage", &footage_,
              "Pictures of a scene in which nothing moves: a video, a numbered sequence (img%04d.png), or "
              "photographs (folders, files or patterns)",
              kFilePath);
    flags.add("--front-end", &front_end_,
              "How points are followed from picture to picture. flow: small motions, as in a video; "
              "keypoints: by what they look like, as in photographs. Not given: flow for a video or "
              "sequence, else keypoints",
              oneOf({"flow", "keypoints"}));
    flags.under(nullptr);
    flags.add("--against", &against_, "Camera file (any format) to compare with", kFilePath);
    flags.add("--tolerance", &tests_.tolerance_px,
              "Largest accepted error in pixels (95th percentile; --images: where boards were "
              "seen), for --images and --against. For --footage, whose default is 1, a fifth of the "
              "error that surely fails",
              {.complaint = pixelComplaint, .number = pixelsOrNan});
    flags.addCommon(common_, true);
  }

  int run(const Flags& flags) override {
    if (files_.empty()) throw missing("no file", "camera files, or folders with camera files");
    const std::vector<ListedFile> listed = listCameraFiles(files_);
    checkUsage(listed);
    const std::vector<std::optional<CameraSource>> known = readForFootage(listed);
    prepareComparisons();
    followFootage(flags.isGiven("--tolerance"));
    const ValidationResult result = judgeAll(listed, known);
    write(result);
    print(result);
    const bool is_any_failed =
        std::ranges::any_of(result.files, [&](const auto& file) { return result.isFailed(file); });
    return is_any_failed ? kUntrustworthyExit : 0;
  }

 private:
  void checkUsage(const std::vector<ListedFile>& listed) const {
    std::vector<std::string> sources;
    for (const ListedFile& file : listed) {
      // A report of an earlier run in the same folder may be replaced.
      if (!file.is_from_folder) sources.push_back(cameraFilePath(file.path));
    }
    append(sources, footage_);
    const std::vector<Output> outputs = {{"--junit", common_.junit}, {"--report", report_, "page.html"}};
    checkOutputs(std::span(outputs).first(1), sources, common_);
    checkJunitPath(common_.junit);
    if (!report_.empty()) checkOutputs(outputs, allSources(listed), common_, 1);
    if (images_.inputs.empty() && !images_.mirrored.empty())
      throw misuse("--mirrored without --images", "--images with photographs of a board");
    if (footage_.empty() && !front_end_.empty())
      throw misuse("--front-end without --footage", "--footage with a video or photographs");
  }

  [[nodiscard]] std::vector<std::string> allSources(const std::vector<ListedFile>& listed) const {
    std::vector<std::string> sources = images_.inputs;
    if (!sources.empty() && !isCornersFile(sources.front())) sources = withImages(sources);
    if (!footage_.empty()) append(sources, withImages(footage_));
    for (const ListedFile& file : listed) sources.push_back(cameraFilePath(file.path));
    append(sources, images_.boards);
    append(sources, {cameraFilePath(against_), common_.config});
    return sources;
  }

  // Finds the boards and reads the other camera, once for all tested files.
  void prepareComparisons() {
    if (images_.inputs.empty() && !images_.boards.empty())
      throw misuse("--board without --images", "--images FOLDER with images of the board");
    tests_.jobs = common_.jobs;
    if (!against_.empty()) tests_.other = readCameraTelling(against_, {}, common_.quiet);
    if (images_.inputs.empty()) return;
    tests_.cancel = common_.cancel = catchInterrupts();
    images_.image_size = camera_.image_size;
    images_.pictures = report_.empty() ? nullptr : &passing_;
    given_ = readViews(images_, common_);
    tests_.boards = given_.boards;
    tests_.views = given_.views;
    if (common_.quiet) return;
    for (const std::string& reason : given_.reasons) printMessage("  " + reason);
    printNotes(given_.notes);
  }

  // The content of named files if they are tested on footage, which belongs to one camera; other files are
  // read when they are judged. @throws Error (kUsage) for a file with several cameras
  [[nodiscard]] std::vector<std::optional<CameraSource>> readForFootage(
      const std::vector<ListedFile>& listed) const {
    std::vector<std::optional<CameraSource>> sources(listed.size());
    for (std::size_t i = 0; i < listed.size(); ++i) {
      if (footage_.empty() || listed[i].is_from_folder) continue;
      try {
        sources[i] = readCamerasToJudge(listed[i].path, camera_);
      } catch (const Error&) {
        continue;  // its judgement states the reason
      }
      std::vector<std::string> names = mapped(sources[i]->cameras, cameraLabel<StatedCamera>);
      append(names, mapped(sources[i]->refused, cameraLabel<RefusedCamera>));
      if (names.size() <= 1) continue;
      const std::string& path = listed[i].path;
      throw flagError("--footage: " + path, fmt::format("a file with {} cameras", names.size()),
                      "the one camera that took the footage",
                      fmt::format("test each camera alone: {}#{}", path, names.front()));
    }
    return sources;
  }

  // Tracks points through the footage, once for all tested files.
  void followFootage(bool has_tolerance) {
    if (footage_.empty()) return;
    tests_.cancel = common_.cancel = catchInterrupts();
    if (has_tolerance) tests_.footage_tolerance_px = tests_.tolerance_px;
    const bool is_flow = front_end_.empty() ? isVideoFootage(footage_) : front_end_ == "flow";
    FootagePass pass;
    ProgressBar bar("following points", common_.quiet);
    FootagePassOptions options;
    options.progress = bar.reporter();
    options.cancel = tests_.cancel;
    tests_.footage =
        trackFootage(footage_, is_flow ? FrontEndKind::kFlow : FrontEndKind::kKeyPoints, pass, options);
    tests_.num_footage_frames = pass.num_frames - pass.num_damaged;
    if (!common_.quiet) printNotes(pass.notes);
  }

  [[nodiscard]] ValidationResult judgeAll(const std::vector<ListedFile>& listed,
                                          const std::vector<std::optional<CameraSource>>& known) const {
    std::vector<std::optional<FileJudgement>> judgements(listed.size());
    // The checks with images and footage are parallel themselves.
    const int num_jobs = tests_.views.empty() && !tests_.footage ? common_.jobs : 1;
    parallelFor(listed.size(), num_jobs, [&](std::size_t i) {
      judgements[i] = judgeFile(listed[i], camera_, tests_, known[i] ? &*known[i] : nullptr);
    });
    ValidationResult result{
        .is_strict = is_strict_,
        .tolerance_px = tests_.tolerance_px,
        .boards = tests_.boards,
        .origin =
            originOf(files_, date_,
                     {{"--images", images_.inputs}, {"--footage", footage_}, {"--against", {against_}}})};
    if (const auto& other = tests_.other)
      result.rival = {.name = printable(against_),
                      .camera = other->camera,
                      .size = other->image_size,
                      .covariance = statedCovariance(*other)};
    for (std::size_t i = 0; i < listed.size(); ++i) {
      if (judgements[i]) {
        result.files.push_back(*std::move(judgements[i]));
      } else if (listed[i].path != common_.junit) {  // an earlier report
        result.other_files.push_back(listed[i].path);
      }
    }
    if (result.files.size() == 2) addPairChecks(result);
    if (!result.files.empty()) return result;
    throw inputError({.where = files_.front(),
                      .found = "no camera file among " + counted(listed.size(), "file"),
                      .expected = "at least one",
                      .next_step = "see docs/formats.md for the formats"});
  }

  // Two files of one pair, as of ROS, state together where the cameras are. Others were judged by themselves.
  void addPairChecks(ValidationResult& result) const {
    const std::vector<std::string> paths = mapped(result.files, &FileJudgement::file);
    std::vector<FileCheck>& checks = result.files.back().rig_checks;
    const bool are_whole = std::ranges::all_of(result.files, [](const FileJudgement& file) {
      return file.error.empty() && file.rig_checks.empty();
    });
    if (!are_whole) return;
    try {
      checks = checkRig(gatherCameras(paths, camera_).source);
    } catch (const Error&) {
      // They are no pair: without poses, or at one place, as cameras by themselves are.
    }
  }

  void write(const ValidationResult& result) const {
    if (!common_.junit.empty()) writeFileAtomically(common_.junit, junitText(result));
    if (report_.empty()) return;
    writeFileAtomically(report_,
                        validationPage(result, validationEvidence(result),
                                       picturesOf(given_.images, given_.image_set, &passing_), common_.jobs));
  }

  void print(const ValidationResult& result) {
    if (common_.quiet && !common_.json) printResult(filesText(result, true));
    answer(
        [&] { return judgementJson(result); },
        [&] { return (is_verbose_ ? checksText(result) : filesText(result, false)) + totalsText(result); });
    if (!report_.empty() && !common_.quiet) printMessage("report written to " + report_);
  }

  std::vector<std::string> files_;
  std::string report_;
  std::string date_;
  bool is_strict_ = false;
  bool is_verbose_ = false;
  ReadOptions camera_;
  BoardInputs images_;
  std::vector<std::string> footage_;
  std::string front_end_;
  std::string against_;
  FileTests tests_;
  GivenViews given_;
  PassingPictures passing_;
};

}  // namespace

const CommandEntry kValidateCommand = {"validate", "Check camera files", made<ValidateCommand>};

}  // namespace alidade
