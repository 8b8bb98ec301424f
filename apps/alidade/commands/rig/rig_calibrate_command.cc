// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/data/rig_evidence.h"
#include "alidade/report/pages/page.h"
#include "alidade/rig/rig_calibrator.h"
#include "camera_files.h"
#include "command.h"
#include "commands/rig/rig_inputs.h"
#include "commands/rig/rig_text.h"
#include "console.h"
#include "outputs.h"

namespace alidade {
namespace {

class RigCalibrateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade rig calibrate left/ right/ --board checkerboard:9x6:25mm -o rig.yaml\n"
        "Images with the same name, or else with the same last number in it, were taken at the same time.\n"
        "Exit code 3: done, but the rig must not be used; no rig file is written.");
    flags.add("input", &views_.inputs,
              "One for each camera: a folder of images, a pattern in quotes, or a corners file (.csv)",
              kFile);
    views_.addOptions(flags);
    std::vector<std::string> models = modelIds();
    models.emplace_back(kAutoModel);
    flags.under(kFitGroup);
    flags.add("--model", &models_,
              "Camera model as for alidade calibrate, for all cameras; or one for each, separated by commas",
              oneOf(models, ','));
    flags.add("--fixed", &fixed_,
              "Camera files of cameras calibrated before, one for each camera, separated by commas ('-': "
              "calibrate this one); their lenses are kept",
              {.word = kFile.word, .separator = ','});
    flags.add("--board-shape", &shape_,
              "Shape of the boards. flat: boards are flat; warp: their bend is estimated; uneven: the "
              "place of every point; auto: what is seen",
              kBoardShapes);
    flags.under(kOutputGroup);
    flags.add("-o,--output", &output_, "Rig file to write (YAML)", kFile);
    flags.add("--evidence", &evidence_, "JSON file to write: all results with the errors of all corners",
              kFile);
    flags.add("--report", &report_, "HTML page to write: the rig and its errors in figures, in one file",
              kFile);
    flags.under(kVerdictGroup);
    flags.add("--tolerance", &tolerance_, "Error of a projected point that you accept (95 %)", kPixelText);
    flags.under(kOutputGroup);
    flags.addSwitch("--verbose", is_verbose_, "Print all details after the summary");
    flags.addSwitch("--keep-untrustworthy", keep_, "Write the rig file even if the rig must not be used");
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    checkUsage();
    RigOptions options = rigOptions();
    const std::vector<std::string> names = views_.cameraNames();
    options.given = givenCameras(names);
    RigInputViews given = readRigViews(views_, names, common_, options.camera.cancel);
    options.frames = given.frames;
    const RigCalibration rig = calibrate(given.boards, std::move(given.cameras), options);
    const RigRecord record = recordOf(rig, programName());
    write(rig, record, options.camera.tolerance_px);
    print(rig, given.given, record.num_frames);
    return tell(rig);
  }

 private:
  void checkUsage() const {
    if (views_.inputs.size() < 2) {
      throw missingError("rig calibrate", fmt::format("{} inputs", views_.inputs.size()),
                         "two or more, one for each camera, for example left/ right/");
    }
    std::vector<std::string> sources = views_.sources();
    sources.push_back(common_.config);
    append(sources, mapped(fixed_, cameraFilePath));
    checkOutputs(std::vector<Output>{{"--output", output_}, {"--evidence", evidence_}, {"--report", report_}},
                 sources, common_);
    if (models_.size() > 1 && models_.size() != views_.inputs.size()) {
      throw usageError(
          {.where = "--model",
           .found = fmt::format("{} models for {} cameras", models_.size(), views_.inputs.size()),
           .expected = "one model, or one for each camera"});
    }
  }

  [[nodiscard]] RigOptions rigOptions() const {
    RigOptions options{.camera = {.tolerance_px = *parsePixels(tolerance_), .jobs = common_.jobs},
                       .models = {}};
    options.camera.cancel = catchInterrupts();
    options.camera.board_shape = shapeMode(shape_);
    if (models_.size() == 1) options.camera.model = models_.front();
    if (models_.size() > 1) options.models = models_;
    return options;
  }

  [[nodiscard]] bool isKept(const RigCalibration& rig) const { return rig.isUsable() || keep_; }

  // Writes all requested files.
  void write(const RigCalibration& rig, const RigRecord& record, double tolerance_px) const {
    if (!output_.empty() && isKept(rig)) saveRig(output_, record);
    if (evidence_.empty() && report_.empty()) return;
    const nlohmann::json evidence = rigEvidenceDocument(rig, tolerance_px, programName());
    if (!evidence_.empty()) writeFileAtomically(evidence_, jsonText(evidence));
    if (report_.empty()) return;
    writeFileAtomically(report_, reportPage(evidence, evidence_));
    if (!common_.quiet) printMessage("report written to " + report_);
  }

  void print(const RigCalibration& rig, const std::vector<GivenViews>& given, int num_frames) const {
    if (common_.json) return printResult(rigSummaryJson(rig));
    if (common_.quiet) return;
    const bool is_coloured = isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr;
    printResult(rigSummaryText(rig, given, num_frames, is_coloured) +
                (is_verbose_ ? "\n" + rigDetailsText(rig, given) : ""));
  }

  // Prints the locations of the results, and whether the rig may be used. @returns the exit code
  [[nodiscard]] int tell(const RigCalibration& rig) const {
    if (!rig.isUsable()) {
      printRefusal("the rig must not be used: " + rig.diagnoses.front().message(), output_, isKept(rig));
      return kUntrustworthyExit;
    }
    if (!common_.quiet)
      printMessage(output_.empty() ? "no rig file written (give -o rig.yaml)" : "written to " + output_);
    return 0;
  }

  // The cameras of --fixed, in the order of `names`: matched by their own names if these are names in the
  // rig.
  std::vector<std::optional<CameraRecord>> givenCameras(const std::vector<std::string>& names) const {
    if (!fixed_.empty() && fixed_.size() != views_.inputs.size()) {
      throw usageError({.where = "--fixed",
                        .found = fmt::format("{} files for {} cameras", fixed_.size(), views_.inputs.size()),
                        .expected = "one for each camera, or '-'"});
    }
    std::vector<std::optional<CameraRecord>> given(fixed_.size());
    std::vector<std::size_t> places;  // indices of the files, in the order given
    std::vector<std::string> stated;
    for (std::size_t c = 0; c < fixed_.size(); ++c) {
      if (fixed_[c] == "-") continue;
      given[c] = readCameraTelling(fixed_[c], {}, common_.quiet);
      places.push_back(c);
      const std::string& name = given[c]->name.name;
      stated.push_back(name.empty() ? std::filesystem::path(cameraFilePath(fixed_[c])).stem().string()
                                    : name);
    }
    const auto by_name = placesByName(stated, names);
    if (by_name && *by_name != places) {
      std::vector<std::optional<CameraRecord>> sorted(fixed_.size());
      std::vector<std::string> assigned;
      for (std::size_t i = 0; i < places.size(); ++i) {
        sorted[(*by_name)[i]] = std::move(given[places[i]]);
        assigned.push_back(fixed_[places[i]] + " to " + stated[i]);
      }
      given = std::move(sorted);
      if (!common_.quiet)
        printMessage("note: the files of --fixed were assigned to the cameras by their names: " +
                     join(assigned, ", "));
    }
    refuseModelsOfFixed(names, given);
    return given;
  }

  // A kept lens already has its model.
  void refuseModelsOfFixed(const std::vector<std::string>& names,
                           const std::vector<std::optional<CameraRecord>>& given) const {
    const auto isFixed = [](const std::optional<CameraRecord>& camera) { return camera.has_value(); };
    if (models_.empty() || std::ranges::none_of(given, isFixed)) return;
    const bool is_for_others = models_.size() == 1 && !std::ranges::all_of(given, isFixed);
    for (std::size_t c = 0; c < given.size() && !is_for_others; ++c) {
      const std::string& model = models_.size() == 1 ? models_.front() : models_[c];
      if (!given[c] || model == kAutoModel || model == given[c]->camera.modelId()) continue;
      throw usageError({.where = "--model",
                        .found = fmt::format("{} for {}, whose lens --fixed keeps", model, names[c]),
                        .expected = fmt::format("{}, the model of its file, or auto",
                                                std::string(given[c]->camera.modelId())),
                        .next_step = "leave out one of the two flags for this camera"});
    }
  }

  RigInputs views_{{.command = "rig calibrate"}};
  std::vector<std::string> models_;
  std::string shape_ = "auto";
  std::vector<std::string> fixed_;
  std::string output_;
  std::string evidence_;
  std::string report_;
  std::string tolerance_ = "1px";
  bool keep_ = false;
  bool is_verbose_ = false;
};

}  // namespace

std::unique_ptr<Command> makeRigCalibrateCommand() {
  return std::make_unique<RigCalibrateCommand>();
}

}  // namespace alidade
