// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/start/held_params.h"
#include "alidade/calibrate/start/prepared_views.h"
#include "alidade/camera/model_fit.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/error.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/report/data/evidence.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/figures/next_view_svg.h"
#include "alidade/report/pages/page.h"
#include "alidade/rig/rig_frames.h"
#include "alidade/target/board_spec.h"
#include "board_views.h"
#include "camera_files.h"
#include "command.h"
#include "commands/calibrate/calibration_output.h"
#include "console.h"
#include "outputs.h"
#include "page_file.h"

namespace alidade {
namespace {

// True for folders of which most images match by their names, as those of the cameras of a rig do.
bool areOfARig(const std::vector<std::string>& inputs) {
  std::vector<RigViews> cameras;
  std::size_t num_images = 0;
  for (const std::string& input : inputs) {
    std::error_code ignored;  // of inputs that cannot be looked at, which are reported when they are read
    if (inputs.size() < 2 || !std::filesystem::is_directory(input, ignored)) return false;
    RigViews& camera = cameras.emplace_back();
    for (const std::string& image : withImages({input}))
      if (image != input) camera.images.push_back(std::filesystem::path(image).filename().string());
    num_images += camera.images.size();
  }
  try {
    return num_images > 0 && 2 * matchFrames(cameras).unmatched.size() < num_images;
  } catch (const Error&) {
    return false;  // no numbers in the names
  }
}

class CalibrateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade calibrate photos/ --board checkerboard:9x6:25mm -o camera.yaml\n"
        "Several boards, in the same images or not: repeat --board.\n"
        "Exit code 3: done, but the camera must not be used; no camera file is written.");
    flags.add("input", &given_.inputs,
              "Folders, image files, patterns (*.jpg, frame%04d.png) or videos; or corners files of one "
              "camera (.csv, or .vnl of mrcal)",
              kFilePath);
    given_.addBoards(flags);
    flags.under(kBoardGroup);
    flags.add("--image-size", &given_.image_size,
              "Image size in pixels (WIDTHxHEIGHT), for .vnl files, which do not state it", kSizeText);
    addFitOptions(flags);
    given_.addDetection(flags, true);
    flags.under(kBoardGroup);
    flags.add("--mirrored", &given_.mirrored,
              std::string("Why boards look mirrored. ") + kMirroredText +
                  "; back: they show the back of a board that is printed through",
              oneOf({"image", "back"}));
    addResultOptions(flags);
    flags.addCommon(common_, true);
  }

  int run(const Flags& flags) override {
    checkUsage();
    options_.cancel = common_.cancel = catchInterrupts();
    readOptions();
    given_.pictures = report_.empty() ? nullptr : &passing_;
    if (!given_.boards.empty() && areOfARig(given_.inputs)) {
      rig_command_ = "alidade rig calibrate " + join(given_.inputs, " ") + " --board " +
                     join(given_.boards, " --board ") + " -o rig.yaml";
      if (!common_.quiet)
        printNotes({"images match by name; if each folder is of one camera: " + rig_command_});
    }
    const GivenViews given = readViews(given_, common_);
    requireViews(given);
    Calibration result = calibrate(given.boards, given.views, options_);
    explainMirrors(given_.mirrored, "", result.diagnoses);
    for (Diagnosis& diagnosis : result.diagnoses)
      if (!rig_command_.empty() &&
          (diagnosis.id == DiagnosisId("two_cameras") || diagnosis.id == DiagnosisId("focal_changed")))
        diagnosis.next_step += (diagnosis.next_step.empty() ? "" : "; ") +
                               std::string("if each folder is of one camera: ") + rig_command_;
    const Guidance guidance = guide(result, given.views, parsePixels(target_sigma_));
    write(result, given, guidance, flags);
    print(result, given, guidance);
    return tell(result);
  }

 private:
  void addFitOptions(Flags& flags) {
    flags.under(kFitGroup);
    std::vector<std::string> models = modelIds();
    models.emplace_back(kAutoModel);
    flags.add("--model", &options_.model,
              "Camera model: " + join(modelIds(), ", ") +
                  "; or auto: the smallest model that no larger one significantly outperforms in "
                  "cross-validation (with --init, the model of that file)",
              oneOf(models, 0, aliasedModels()));
    flags.add("--init", &init_,
              "Camera file for the initial guess, with the same image size; its lens is converted to "
              "--model. Default: automatic initial guess",
              kFilePath);
    flags.add("--fix", &options_.held,
              "Fixed parameters, for example cx,cy,k3. They keep the values of --init; without it, cx "
              "and cy are the image centre and lens parameters are 0. If the model is chosen "
              "automatically, only cx and cy",
              {.separator = ','});
    flags.addSwitch("--same-focal", options_.same_focal, "Force fx = fy");
    addPupilFlag(flags, pupil_);
    flags.add(
        "--correction", &correction_,
        "Smooth displacement over the image by which the lens deviates from its model: COLUMNSxROWS of its "
        "cells, none, or auto: if cross-validation needs it and --model is auto");
    flags.add("--board-shape", &board_shape_,
              "Shape of the board. flat: assume a flat board; warp: estimate its bend; uneven: estimate "
              "the place of every point; flexible: estimate a bend for each view; auto: estimate what the "
              "views show",
              kBoardShapes);
  }

  // Flags for result files and the required accuracy.
  void addResultOptions(Flags& flags) {
    flags.under(kOutputGroup);
    flags.add("-o,--output", &output_,
              "Camera file to write (YAML); - for standard output instead of the summary", aside(kFilePath));
    addFormatFlag(flags, format_, "Format of the camera file; the lens model is one that it can represent: ");
    flags.add("--name", &name_.name, "Camera name to store in the camera file", kAside);
    flags.add("--serial", &name_.serial, "Serial number to store in the camera file", kAside);
    addDateFlag(flags, date_);
    flags.add("--evidence", &evidence_,
              "JSON file to write: everything that --json prints, the errors of all corners and the "
              "effective settings",
              aside(kFilePath));
    addReportFlag(flags, report_, "the verdict and its reasons in figures");
    flags.under(kVerdictGroup);
    flags.add("--tolerance", &tolerance_,
              "Error of a projected point that you accept (95 %). The verdict and the severity of "
              "warnings depend on it",
              kPixelText);
    flags.add("--distance", &distance_,
              "Distance of the points that the accuracy is for, for example 2m, with the camera's pose "
              "aligned. Default: distant points, with the rotation aligned");
    flags.under(kOutputGroup);
    flags.addSwitch("--verbose", is_verbose_, "Print all details after the summary", true);
    flags.under(kVerdictGroup);
    flags.add("--target-sigma", &target_sigma_,
              "Largest accepted projection uncertainty in the image, for example 0.1px. The summary "
              "states whether it is reached, and if not, about how many more views are needed",
              aside(kPixelText));
    flags.under(kOutputGroup);
    flags.add("--next-view", &next_view_,
              "SVG file to write: the suggested next view and the current projection uncertainty",
              aside(kFilePath));
    flags.addSwitch("--keep-untrustworthy", keep_untrustworthy_,
                    "Write the camera file even if the camera must not be used", true);
  }

  [[nodiscard]] bool isOfCorners() const { return isCornersFile(given_.inputs.front()); }
  [[nodiscard]] bool isKept(const Calibration& result) const {
    return result.isUsable() || keep_untrustworthy_;
  }

  void checkUsage() const {
    if (given_.inputs.empty()) throw missing("no input", "folders, images or a corners file");
    std::vector<std::string> sources = isOfCorners() ? given_.inputs : withImages(given_.inputs);
    append(sources, given_.boards);
    append(sources, {cameraFilePath(init_), common_.config});
    if (given_.image_size && !isVnlFile(given_.inputs.front())) {
      throw flagError("--image-size " + sizeText(*given_.image_size), "inputs that state their own size",
                      "this flag only with .vnl files", "remove it");
    }
    given_.checkDebugFolder(output_);
    checkOutputs(std::vector<Output>{{"--output", output_},
                                     {"--next-view", next_view_, "next.svg"},
                                     {"--evidence", evidence_, "evidence.json"},
                                     {"--report", report_, "page.html"}},
                 sources, common_);
  }

  void requireViews(const GivenViews& given) const {
    if (given.views.size() >= kMinViews) return;
    const std::size_t num_given = std::max(given.num_images, given.views.size());
    const std::string share = fmt::format("{}{} of {}", given.views.size() < num_given ? "only " : "",
                                          given.views.size(), num_given);
    throw inputError(
        {.where = given_.inputs.front() + (given_.inputs.size() > 1 ? " ..." : ""),
         .found = isOfCorners() || given.boards.size() > 1 ? share + " views are usable"
                                                           : "the board was found in " + share + " images",
         .expected = fmt::format("at least {} views", kMinViews),
         .next_step = given.reasons.empty() ? "take more photographs of the board, tilted by 20 to 50 degrees"
                                            : join(given.reasons, "\n        ")});
  }

  // Reads the flags. Wrong parameter names are refused before images are read.
  void readOptions() {
    options_.jobs = common_.jobs;
    options_.tolerance_px = *parsePixels(tolerance_);
    if (!distance_.empty()) {
      options_.distance_m = parseLength(distance_, "--distance");
      if (options_.distance_m <= 0) throw flagError("--distance", distance_, "a length above 0, such as 2m");
    }
    options_.board_shape = *boardShapeMode(board_shape_);
    options_.num_pupil = pupilNumbers(pupil_);
    options_.correction_cells = correctionCells(correction_);
    if (!init_.empty()) {
      const CameraRecord file = readCameraTelling(init_, {}, common_.quiet);
      options_.initial = {.camera = file.camera, .size = file.image_size};
    }
    restrictTo(cameraFormat(format_));
    static_cast<void>(constraintOf(options_));
  }

  // Restricts models and parameters so that the format can store the camera.
  void restrictTo(const CameraFormat& format) {
    if (format.id == cameraFormats().front()->id) return;
    if (options_.num_pupil.value_or(0) > 0)
      throw flagError("--to " + format_, "--pupil " + pupil_, "the format alidade, which states a pupil");
    options_.num_pupil = 0;
    if (options_.correction_cells && (*options_.correction_cells)[0] > 0)
      throw flagError("--to " + format_, "--correction " + correction_,
                      "the format alidade, which states a field");
    options_.correction_cells = {0, 0};
    const bool has_fixed = !options_.held.empty();
    options_.models = mapped(heldModels(format), &HeldModel::model);
    const std::string model = namedModel(options_);
    if (model != kAutoModel && std::ranges::find(options_.models, model) == options_.models.end()) {
      throw flagError("--to " + format_, "the model " + model + ", which this format cannot represent",
                      fmt::format("{}", fmt::join(options_.models, ", ")),
                      "choose one of these with --model, or another format");
    }
    for (const std::string_view held : options_.models) {
      for (const std::string_view parameter : unrepresentableParameters(format, held))
        options_.held.push_back(fmt::format("{}.{}", held, parameter));
    }
    if (!options_.initial || model == kAutoModel) return;
    const std::vector<std::string_view> zero = unrepresentableParameters(format, model);
    if (zero.empty()) return;
    const ModelFit fit = fitModel(options_.initial->camera, options_.initial->size, model, zero);
    if (!fit.is_exact && has_fixed) {
      throw flagError("--fix with --to " + format_,
                      "values of an initial camera that this format cannot represent",
                      fmt::format("an initial camera with {} = 0", fmt::join(zero, ", ")));
    }
    options_.initial->camera = fit.camera;
  }

  [[nodiscard]] CameraRecord recordOf(const Calibration& result) const {
    CameraRecord record = alidade::recordOf(result, programName(), name_);
    record.calibration->date = dateText(date_);
    return record;
  }

  // Writes all requested files.
  void write(const Calibration& result, const GivenViews& given, const Guidance& guidance,
             const Flags& flags) const {
    if (!next_view_.empty()) writeFileAtomically(next_view_, nextViewSvg(result, given.views, guidance));
    if (!evidence_.empty() || !report_.empty()) {
      RunOrigin origin = originOf(given_.inputs, date_);
      origin.camera = name_;
      const nlohmann::json evidence = evidenceDocument(
          result, given, guidance,
          {.settings = flags.settings(), .tolerance_px = options_.tolerance_px, .run = origin});
      if (!evidence_.empty()) writeFileAtomically(evidence_, jsonText(evidence));
      if (!report_.empty())
        writeFileAtomically(report_,
                            reportPage(evidence, evidence_,
                                       {.pictures = {picturesOf(given.images, given.image_set, &passing_)},
                                        .num_jobs = common_.jobs}));
    }
    if (!output_.empty() && output_ != "-" && isKept(result)) saveCamera(output_, recordOf(result), format_);
  }

  void print(const Calibration& result, const GivenViews& given, const Guidance& guidance) const {
    const auto summary = [&](bool is_terminal) {
      const bool is_coloured = is_terminal && std::getenv("NO_COLOR") == nullptr;
      return summaryText(result, given, guidance, options_.tolerance_px, is_coloured, is_verbose_) +
             (is_terminal ? coveragePicture(guidance.coverage) : "") +
             (is_verbose_ ? "\n" + detailsText(result, given, guidance) : "");
    };
    if (common_.json) {
      printResult(summaryJson(result, given, guidance));
    } else if (output_ == "-") {
      if (isKept(result)) printResult(cameraText(recordOf(result), format_));
      if (!common_.quiet) printHelp(summary(false));
    } else if (!common_.quiet) {
      printResult(summary(isatty(STDOUT_FILENO) != 0));
    }
  }

  // Prints the locations of the results, and whether the camera may be used. @returns the exit code
  [[nodiscard]] int tell(const Calibration& result) const {
    if (!report_.empty() && !common_.quiet) printMessage("report written to " + report_);
    if (!result.isUsable()) {
      const Diagnosis& why = result.diagnoses.front();
      printRefusal("the camera must not be used: " + why.cause, output_, isKept(result));
      if (!rig_command_.empty() && !why.next_step.empty())
        printMessage("  next: " + why.next_step);  // in one line, to be copied
      return kUntrustworthyExit;
    }
    if (common_.quiet || output_ == "-") return 0;
    const bool is_full = format_ == cameraFormats().front()->id;
    printMessage(output_.empty()
                     ? "no camera file written (give -o camera.yaml)"
                     : "written to " + output_ +
                           (is_full ? "" : ", without accuracy and verdict (--evidence FILE keeps them)"));
    return 0;
  }

  BoardInputs given_;
  CalibratorOptions options_;
  std::string rig_command_;  // if the inputs may be of a rig
  std::string init_;
  std::string board_shape_ = "auto";
  std::string pupil_ = "auto";
  std::string correction_ = "auto";
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
  std::string date_;
  bool keep_untrustworthy_ = false;
  PassingPictures passing_;
};

}  // namespace

const CommandEntry kCalibrateCommand = {
    "calibrate", "Calibrate a camera from images of a board or from a corners file", made<CalibrateCommand>};

}  // namespace alidade
