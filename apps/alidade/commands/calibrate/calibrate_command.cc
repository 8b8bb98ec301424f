// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/camera/model_fit.h"
#include "alidade/core/error.h"
#include "alidade/files/camera_save.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/vnl_file.h"
#include "alidade/report/data/evidence.h"
#include "alidade/report/figures/next_view_svg.h"
#include "alidade/target/board_spec.h"
#include "board_views.h"
#include "commands/calibrate/calibration_output.h"
#include "commands/calibrate/coverage_picture.h"
#include "console.h"
#include "options.h"
#include "report_output.h"

namespace alidade {
namespace {

GivenImages imagesOf(const GivenViews& given) {
  return {.num_images = given.num_images,
          .num_found = given.num_found,
          .reasons = given.reasons,
          .notes = given.notes};
}

class CalibrateCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade calibrate photos/ --board checkerboard:9x6:25mm -o camera.yaml\n"
        "Several boards, in the same images or not: repeat --board.\n"
        "Exit code 3: done, but the camera must not be used; no camera file is written.");
    app.add_option("input", inputs_,
                   "Folders, image files, patterns (*.jpg, frame%04d.png) or videos; or corners files of one "
                   "camera (.csv, or .vnl of mrcal)")
        ->type_name(kFileValue);
    addBoardOption(app, boards_);
    app.add_option("--image-size", size_,
                   "Image size in pixels (WIDTHxHEIGHT), for .vnl files, which do not state it")
        ->group(kBoardGroup)
        ->check(sizeComplaint, "");
    std::vector<std::string> models(modelIds().begin(), modelIds().end());
    app.add_option(
           "--model", model_,
           fmt::format("Camera model: {}; or auto: the smallest model that no larger one significantly "
                       "outperforms in cross-validation (with --init, the model of that file)",
                       fmt::join(models, ", ")))
        ->group(kFitGroup);
    models.emplace_back(kAutoModel);
    app.get_option("--model")->check(CLI::IsMember(models))->capture_default_str();
    app.add_option("--init", init_,
                   "Camera file for the initial guess, with the same image size; its lens is converted to "
                   "--model. Default: automatic initial guess")
        ->group(kFitGroup)
        ->type_name(kFileValue);
    app.add_option("--fix", fixed_,
                   "Fixed parameters, for example cx,cy,k3. They keep the values of --init; without it, cx "
                   "and cy are the image centre and lens parameters are 0. If the model is chosen "
                   "automatically, only cx and cy")
        ->group(kFitGroup)
        ->delimiter(',');
    app.add_flag("--same-focal", same_focal_, "Force fx = fy")->group(kFitGroup);
    app.add_option("--board-shape", board_shape_,
                   "Shape of the board. flat: assume a flat board; warp: estimate its bend; uneven: estimate "
                   "the place of every point; auto: estimate the bend if it is significant, and the points "
                   "if they explain other views")
        ->group(kFitGroup)
        ->check(CLI::IsMember({"flat", "warp", "uneven", "auto"}))
        ->capture_default_str();
    addDetectionOptions(app, detection_);
    addDebugOption(app, debug_);
    addResultOptions(app);
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App& app) override {
    if (inputs_.empty()) throw missingError("calibrate", "no input", "folders, images or a corners file");
    std::vector<std::string> sources = isCornersFile(inputs_.front()) ? inputs_ : withImages(inputs_);
    sources.insert(sources.end(), boards_.begin(), boards_.end());
    sources.insert(sources.end(), {cameraFilePath(init_), common_.config});
    if (!size_.empty() && !isVnlFile(inputs_.front())) {
      throw usageError({.where = "--image-size " + size_,
                        .found = "inputs that state their own size",
                        .expected = "this flag only with .vnl files",
                        .next_step = "remove it"});
    }
    checkDebugFolder(debug_, output_);
    checkOutput(output_, sources, common_);
    checkFurtherOutput("--next-view", next_view_, "next.svg", sources);
    checkFurtherOutput("--evidence", evidence_, "evidence.json", sources);
    checkFurtherOutput("--report", report_, "page.html", sources);
    CalibratorOptions options = calibratorOptions();
    options.cancel = catchInterrupts();
    PassingPictures passing;
    const GivenViews given = readViews({.command = "calibrate",
                                        .inputs = inputs_,
                                        .boards = boards_,
                                        .debug_folder = debug_,
                                        .detection = detection_,
                                        .pictures = report_.empty() ? nullptr : &passing,
                                        .image_size = parseSize(size_)},
                                       common_, options.cancel);
    if (given.views.size() < kMinViews) {
      const std::size_t num_given = std::max(given.num_images, given.views.size());
      const std::string share = fmt::format("{}{} of {}", given.views.size() < num_given ? "only " : "",
                                            given.views.size(), num_given);
      throw inputError({.where = inputs_.front() + (inputs_.size() > 1 ? " ..." : ""),
                        .found = isCornersFile(inputs_.front()) || given.boards.size() > 1
                                     ? share + " views are usable"
                                     : "the board was found in " + share + " images",
                        .expected = fmt::format("at least {} views", kMinViews),
                        .next_step = given.reasons.empty()
                                         ? "take more photographs of the board, tilted by 20 to 50 degrees"
                                         : fmt::format("{}", fmt::join(given.reasons, "\n        "))});
    }
    const Calibration result = calibrate(given.boards, given.views, options);
    const Advice advice = adviceOn(result, given.views, parsePixels(target_sigma_));
    if (!next_view_.empty())
      writeFileAtomically(next_view_, nextViewSvg(result, given.views, advice.guidance));

    const bool is_good = result.isUsable();
    const bool is_kept = is_good || keep_untrustworthy_;
    const CameraRecord file = recordOf(result, {.created_by = programName(), .name = name_});
    const bool to_stdout = output_ == "-";
    writeEvidence(result, given, passing, advice, app);
    if (!output_.empty() && !to_stdout && is_kept) saveCamera(output_, file, format_);

    const auto summary = [&](bool is_terminal) {
      const SummaryStyle style{.tolerance_px = options.tolerance_px,
                               .is_coloured = is_terminal && std::getenv("NO_COLOR") == nullptr};
      return summaryText(result, given, advice, style) +
             (is_terminal ? coveragePicture(advice.coverage) : "") +
             (is_verbose_ ? "\n" + detailsText(result, given, advice) : "");
    };
    if (common_.json) {
      printResult(summaryJson(result, imagesOf(given), given.views, advice));
    } else if (to_stdout) {
      if (is_kept) printResult(cameraText(file, format_));
      if (!common_.quiet) printHelp(summary(false));
    } else if (!common_.quiet) {
      printResult(summary(isatty(STDOUT_FILENO) != 0));
    }
    if (!report_.empty() && !common_.quiet) printMessage("report written to " + report_);
    if (!is_good) {
      printRefusal("the camera must not be used: " + result.diagnoses.front().cause, output_, is_kept);
      return kUntrustworthyExit;
    }
    if (!common_.quiet && !to_stdout)
      printMessage(output_.empty()
                       ? "no camera file written (give -o camera.yaml)"
                       : "written to " + output_ +
                             (format_ == "alidade"
                                  ? ""
                                  : ", without accuracy and verdict (--evidence FILE keeps them)"));
    return 0;
  }

 private:
  // Where the results go, and what is expected of them.
  void addResultOptions(CLI::App& app) {
    app.add_option("-o,--output", output_,
                   "Camera file to write (YAML); - for standard output instead of the summary")
        ->group(kOutputGroup)
        ->type_name(kFileValue);
    app.add_option("--to", format_,
                   fmt::format("Format of the camera file: {}. The lens model is one that the format can "
                               "represent",
                               fmt::join(formatIds(), ", ")))
        ->group(kOutputGroup)
        ->check(CLI::IsMember(formatIds()))
        ->capture_default_str();
    app.add_option("--name", name_.name, "Camera name to store in the camera file")->group(kOutputGroup);
    app.add_option("--serial", name_.serial, "Serial number to store in the camera file")
        ->group(kOutputGroup);
    app.add_option("--evidence", evidence_,
                   "JSON file to write: everything that --json prints, the errors of all corners and the "
                   "effective settings")
        ->group(kOutputGroup)
        ->type_name(kFileValue);
    app.add_option("--report", report_,
                   "HTML page to write: the verdict and its reasons in figures, in one file that needs no "
                   "network")
        ->group(kOutputGroup)
        ->type_name(kFileValue);
    app.add_option("--tolerance", tolerance_,
                   "Error of a projected point that you accept (95 %). The verdict and the severity of "
                   "warnings depend on it")
        ->group(kVerdictGroup)
        ->check(pixelComplaint, "")
        ->capture_default_str();
    app.add_option("--distance", distance_,
                   "Distance of the points that the accuracy is for, for example 2m, with the camera's pose "
                   "aligned. Default: distant points, with the rotation aligned")
        ->group(kVerdictGroup);
    app.add_flag("--verbose", is_verbose_, "Print all details after the summary")->group(kOutputGroup);
    app.add_option("--target-sigma", target_sigma_,
                   "Largest accepted projection uncertainty in the image, for example 0.1px. The summary "
                   "states whether it is reached, and if not, about how many more views are needed")
        ->group(kVerdictGroup)
        ->check(pixelComplaint, "");
    app.add_option("--next-view", next_view_,
                   "SVG file to write: the suggested next view and the current projection uncertainty")
        ->group(kOutputGroup)
        ->type_name(kFileValue);
    app.add_flag("--keep-untrustworthy", keep_untrustworthy_,
                 "Write the camera file even if the camera must not be used")
        ->group(kOutputGroup);
  }

  [[nodiscard]] CalibratorOptions calibratorOptions() const {
    CalibratorOptions options{.model = model_, .held = fixed_, .same_focal = same_focal_};
    options.jobs = common_.jobs;
    options.tolerance_px = *parsePixels(tolerance_);
    if (!distance_.empty()) {
      options.distance_m = parseLength(distance_, "--distance");
      if (options.distance_m <= 0)
        throw usageError(
            {.where = "--distance", .found = distance_, .expected = "a length above 0, such as 2m"});
    }
    options.board_shape = shapeMode(board_shape_);
    if (!init_.empty()) {
      const CameraRecord file = readCameraTelling(init_, {}, common_.quiet);
      options.initial = {.camera = file.camera, .size = file.image_size};
    }
    restrictTo(cameraFormat(format_), options);
    static_cast<void>(constraintOf(options));  // wrong names are told before the images are read
    return options;
  }

  // The evidence file and the report, as far as they are asked for.
  void writeEvidence(const Calibration& result, const GivenViews& given, const PassingPictures& passing,
                     const Advice& advice, const CLI::App& app) const {
    if (evidence_.empty() && report_.empty()) return;
    const std::string evidence = evidenceJson(result, imagesOf(given), given.views, advice,
                                              {.settings = effectiveSettings(app),
                                               .tolerance_px = *parsePixels(tolerance_),
                                               .created_by = programName()});
    if (!evidence_.empty()) writeFileAtomically(evidence_, evidence);
    if (!report_.empty())
      writeReport(report_, evidence, evidence_,
                  {.pictures = picturesOf(given, passing), .num_jobs = common_.jobs});
  }

  // So that the format can hold the camera that is found.
  void restrictTo(const CameraFormat& format, CalibratorOptions& options) const {
    if (format.id == cameraFormats().front()->id) return;
    const RepresentableModels held = representableModels(format);
    options.models = held.models;
    const std::string model = namedModel(options);
    if (model != kAutoModel && std::ranges::find(held.models, model) == held.models.end()) {
      throw usageError({.where = "--to " + format_,
                        .found = "the model " + model + ", which this format cannot represent",
                        .expected = fmt::format("{}", fmt::join(held.models, ", ")),
                        .next_step = "choose one of these with --model, or another format"});
    }
    std::vector<std::string_view> zero;
    for (const AbsentParameter& absent : held.absent) {
      options.held.push_back(fmt::format("{}.{}", absent.model, absent.parameter));
      if (absent.model == model) zero.push_back(absent.parameter);
    }
    if (!options.initial || zero.empty()) return;
    const ModelFit fit = fitModel(options.initial->camera, options.initial->size, model, zero);
    if (!fit.is_exact && !fixed_.empty()) {
      throw usageError({.where = "--fix with --to " + format_,
                        .found = "values of an initial camera that this format cannot represent",
                        .expected = fmt::format("an initial camera with {} = 0", fmt::join(zero, ", "))});
    }
    options.initial->camera = fit.camera;
  }

  void checkFurtherOutput(const std::string& flag, const std::string& path, const char* example,
                          const std::vector<std::string>& sources) const {
    if (path.empty()) return;
    // Those that were checked before this one.
    const std::array<std::pair<const char*, const std::string*>, 3> others = {
        {{"--output", &output_}, {"--next-view", &next_view_}, {"--evidence", &evidence_}}};
    std::string found = path == "-" ? "standard output, which is used for the results" : "";
    for (const auto& [name, other] : others) {
      if (other == &path) break;
      if (found.empty() && !other->empty() && writtenPath(path) == writtenPath(*other))
        found = "the same file as " + std::string(name);
    }
    if (!found.empty()) {
      throw usageError({.where = flag + " " + path,
                        .found = found,
                        .expected = "a different file, for example " + std::string(example)});
    }
    checkOutput(path, sources, common_, flag);
  }

  std::vector<std::string> inputs_;
  std::vector<std::string> boards_;
  std::string size_;
  std::string model_ = kAutoModel;
  std::string init_;
  std::vector<std::string> fixed_;
  bool same_focal_ = false;
  std::string board_shape_ = "auto";
  DetectionOptions detection_;
  std::string debug_;
  std::string output_;
  std::string format_ = "alidade";
  std::string tolerance_ = "1px";
  std::string distance_;
  bool is_verbose_ = false;
  std::string target_sigma_;
  std::string next_view_;
  std::string evidence_;
  std::string report_;
  CameraName name_;
  bool keep_untrustworthy_ = false;
};

}  // namespace

std::unique_ptr<Command> makeCalibrateCommand() {
  return std::make_unique<CalibrateCommand>();
}

}  // namespace alidade
