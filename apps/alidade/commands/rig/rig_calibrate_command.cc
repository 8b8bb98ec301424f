// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/camera/model_traits.h"
#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/report/data/evidence.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/pages/page.h"
#include "alidade/rig/rig_calibrator.h"
#include "camera_files.h"
#include "command.h"
#include "commands/rig/rig_inputs.h"
#include "console.h"
#include "outputs.h"
#include "page_file.h"
#include "summary_lines.h"

namespace alidade {
namespace {

constexpr double kMmPerMetre = 1000;

std::string transferText(const RigCalibration& rig) {
  const RigCamera* worst = nullptr;
  for (const RigCamera& camera : rig.cameras) {
    if (!std::isfinite(camera.link.transfer_px)) continue;
    if (worst == nullptr || camera.link.transfer_px > worst->link.transfer_px) worst = &camera;
  }
  if (worst == nullptr) return "unknown: the frames do not determine the poses of the cameras";
  return fmt::format("within {} (95 %) from one camera to another at the boards' distance; worst {}",
                     pixels(worst->link.transfer_px), worst->name);
}

std::string countText(std::size_t n, const std::string& one, const std::string& many) {
  return n == 0 ? "" : fmt::format("; {} {}", n, n == 1 ? one : many);
}

std::string fitTextOfRig(const RigCalibration& rig, int num_frames) {
  std::size_t num_outliers = 0;
  std::size_t num_left_out = 0;
  std::size_t num_repeated = 0;
  for (const RigCamera& camera : rig.cameras) {
    num_outliers += camera.alone.dropped.outliers.size();
    num_left_out += camera.alone.dropped.views.size();
    num_repeated += camera.alone.dropped.repeated.size();
  }
  return fmt::format(
             "{} cameras; {} in {}; RMS {:.3f} px, cross-validation {}", rig.cameras.size(),
             rig.links.common_part_of.empty()
                 ? counted(rig.links.num_linked, "board") + " seen by two or more,"
                 : "linked by boards that do not move relative to each other,",
             counted(num_frames, "frame"), rms(rig.fit),
             rig.holdout.num_corners > 0 ? fmt::format("{:.3f} px", rig.holdout.rms_px) : "impossible") +
         (rig.frames.time_spread > 0 ? "; matched by nearest times" : "") +
         countText(rig.frames.unmatched.size(), "image without a partner", "images without a partner") +
         countText(rig.links.unlinked.size(), "view contradicts its frame", "views contradict their frames") +
         countText(num_left_out, "view left out", "views left out") +
         countText(num_repeated, "repeated view averaged", "repeated views averaged") +
         countText(num_outliers, "outlier", "outliers") +
         countText(rig.links.num_renumbered, "view of an ambiguous board renumbered",
                   "views of an ambiguous board renumbered");
}

std::string cameraText(const RigCalibration& rig, std::size_t index, const GivenViews& given) {
  const RigCamera& camera = rig.cameras[index];
  const FitCamera& fitted = rig.fit.cameras[index];
  std::string text =
      fmt::format("{}: {}{}, {} px; corners in {} of {} images; RMS {:.3f} px (alone {:.3f})", camera.name,
                  fitted.model, camera.given ? " (fixed)" : "", sizeText(fitted.size),
                  numImagesUsed(camera.calibration), given.num_images, camera.rms_px, camera.alone_rms_px);
  if (std::isfinite(camera.link.transfer_px))
    text += "; from its neighbour within " + pixels(camera.link.transfer_px);
  if (index == 0) return text;
  const double std_mm = camera.link.distance_std_m * kMmPerMetre;
  const int decimals = decimalsFor(std_mm, 3);
  return text +
         fmt::format("; {:.{}f} mm from {}", fitted.camera_from_rig.translation.norm() * kMmPerMetre,
                     decimals, rig.cameras.front().name) +
         (std_mm > 0 ? fmt::format(" (standard deviation {:.{}f} mm)", std_mm, decimals) : "");
}

// True if the diagnosis is about the given images and not about the rig.
bool isOfInput(const Diagnosis& diagnosis) {
  return diagnosis.severity == Severity::kNote && diagnosis.id.kind().subject == Subject::kMatching;
}

std::string poseText(const RigCamera& camera, const SE3& camera_from_rig) {
  const Eigen::Vector3d origin = camera_from_rig.inverse().translation * kMmPerMetre;
  return fmt::format(
      "at ({:.1f}, {:.1f}, {:.1f}) mm, {:.2f} mm from the first camera, turned by {}; standard "
      "deviation {:.2f} mm, {:.3f} degrees",
      origin.x(), origin.y(), origin.z(), origin.norm(), turnText(camera_from_rig.rotation.inverse()),
      camera.link.position_std_m.norm() * kMmPerMetre, camera.link.rotation_std_rad.norm() * kDegPerRad);
}

std::string imageList(const RigCalibration& rig, const std::string& title,
                      const std::vector<RigImage>& images) {
  if (images.empty()) return "";
  return title + "\n" + listed(mapped(images, [&](const RigImage& image) {
           return printable(
               fmt::format("{}/{} (frame {})", rig.cameras[image.camera].name, image.image, image.frame));
         }));
}

// The summary of a rig's calibration for people, in the layout used for a single camera: at most 100
// columns; the verdict, the worst transfer between cameras and all failures first; at most 16 lines unless
// cameras and failures need more.
// @param given  of each camera; the views are not used
// @param num_frames  with a board that two or more cameras saw
std::string rigSummaryText(const RigCalibration& rig, const std::vector<GivenViews>& given, int num_frames,
                           bool is_coloured) {
  Lines lines = wrapped("Verdict", verdictText(rig.verdict(), "rig", is_coloured));
  append(lines, wrapped("Accuracy", transferText(rig)));
  Lines rest = wrapped("Rig", fitTextOfRig(rig, num_frames));
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    append(rest, wrapped(c == 0 ? "Camera" : "", cameraText(rig, c, given[c])));
  append(rest, boardLines(rig.fit, rig.fit.boards.size() > 1 ? 2 : 1));
  append(
      rest,
      wrapped("Next",
              rig.isUsable()
                  ? "test the rig on other frames: alidade rig validate"
                  : "correct the failures above and calibrate again; --report page.html shows each frame"));
  std::vector<Diagnosis> others;
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    if (diagnosis.severity == Severity::kFailure)
      append(lines, diagnosisLines(diagnosis));
    else
      others.push_back(diagnosis);
  }
  // Warnings, and notes on the inputs, get the remaining lines; those that do not fit are counted. The first
  // warning is always shown, however many cameras there are.
  constexpr std::size_t kLinesOfAWarning = 3;
  const std::size_t num_reserved = lines.size() + rest.size() + 1;
  const std::size_t room = std::max(kLinesOfAWarning, kMaxLines - std::min(num_reserved, kMaxLines));
  const Lines more = addDiagnoses(lines, others, room, [](const Diagnosis& diagnosis, std::size_t) {
    return diagnosis.severity == Severity::kWarning || isOfInput(diagnosis) ? diagnosisLines(diagnosis)
                                                                            : Lines();
  });
  append(lines, rest);
  append(lines, more);
  return join(lines, "\n") + "\n";
}

// The details that --verbose adds to the summary.
std::string rigDetailsText(const RigCalibration& rig, const std::vector<GivenViews>& given) {
  std::string text;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    text += fmt::format("{}\n", printable(camera.name));
    Lines lines = wrapped("Images", fmt::format("{} given, {} with a board, {} used", given[c].num_images,
                                                given[c].num_found, numImagesUsed(camera.calibration)));
    append(lines, parameterLines(camera.calibration));
    if (c > 0) append(lines, wrapped("Pose", poseText(camera, rig.fit.cameras[c].camera_from_rig)));
    for (const std::string& note : given[c].notes) append(lines, wrapped("Note", note));
    text += join(lines, "\n") + "\n" + listed(given[c].reasons) + outliersText(camera.calibration);
  }
  text += imageList(rig, "Images without one of another camera", rig.frames.unmatched);
  text += imageList(rig, "Views that contradict their frames", rig.links.unlinked);
  return text + diagnosesText(rig.diagnoses);
}

class RigCalibrateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade rig calibrate left/ right/ --board checkerboard:9x6:25mm -o rig.yaml\n"
        "Images with the same name, or else with the same last number in it, were taken at the same time.\n"
        "Frames of videos are matched by their numbers. The videos need not start together.\n"
        "Exit code 3: done, but the rig must not be used; no rig file is written.");
    views_.addOptions(flags);
    std::vector<std::string> models = modelIds();
    models.emplace_back(kAutoModel);
    flags.under(kFitGroup);
    flags.add("--model", &models_,
              "Camera model as for alidade calibrate, for all cameras; or one for each, separated by commas",
              oneOf(models, ',', aliasedModels()));
    flags.add("--fixed", &fixed_,
              "Camera files of cameras calibrated before, one for each camera, separated by commas ('-': "
              "calibrate this one); their lenses are kept",
              {.word = kFilePath.word, .separator = ','});
    flags.add(
        "--offsets", &offsets_,
        "Times at which the cameras take the images of one frame. auto: estimated if the images tell that they "
        "differ; none: the cameras are triggered together",
        oneOf({"auto", "none"}));
    addPupilFlag(flags, pupil_);
    flags.add("--board-shape", &shape_,
              "Shape of the boards. flat: boards are flat; warp: their bend is estimated; uneven: the "
              "place of every point; flexible: a bend in each frame; auto: what is seen",
              kBoardShapes);
    flags.under(kOutputGroup);
    flags.add("-o,--output", &output_, "Rig file to write (YAML)", kFilePath);
    flags.redirect({"--to"}, "alidade convert rig.yaml -o camchain.yaml --to kalibr, afterwards");
    flags.add("--evidence", &evidence_, "JSON file to write: all results with the errors of all corners",
              kFilePath);
    addReportFlag(flags, report_, "the rig, its errors and each camera in figures");
    addDateFlag(flags, date_);
    flags.under(kVerdictGroup);
    flags.add("--tolerance", &tolerance_, "Error of a projected point that you accept (95 %)", kPixelText);
    flags.under(kOutputGroup);
    flags.addSwitch("--verbose", is_verbose_, "Print all details after the summary");
    flags.addSwitch("--keep-untrustworthy", keep_, "Write the rig file even if the rig must not be used");
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    checkUsage();
    common_.cancel = catchInterrupts();
    RigOptions options = rigOptions();
    const std::vector<std::string> names = views_.cameraNames(common_);
    options.given = givenCameras(names);
    options.rate_hz = views_.rateOfVideos(common_);
    RigInputViews given = readRigViews(views_, names, common_);
    options.frames = given.frames;
    options.are_simultaneous = offsets_ == "none";
    RigCalibration rig = calibrate(given.boards, std::move(given.cameras), options);
    if (views_.shiftTo(rig, common_)) {
      given = readRigViews(views_, names, common_);
      rig = calibrate(given.boards, std::move(given.cameras), options);
    }
    for (std::size_t c = 0; c < names.size(); ++c) {
      explainMirrors(views_.mirroredOf(c), names[c] + ": ", rig.diagnoses);
      explainMirrors(views_.mirroredOf(c), "", rig.cameras[c].calibration.diagnoses);
    }
    RigRecord record = recordOf(rig, programName());
    for (std::size_t c = 0; c < names.size(); ++c)
      if (!rig.cameras[c].given) record.cameras[c].camera.calibration->date = dateText(date_);
    write(rig, record, given.given, options.camera.tolerance_px);
    print(rig, given.given, record.num_frames);
    return tell(rig);
  }

 private:
  void checkUsage() const {
    if (views_.inputs.size() < 2) {
      throw missing(counted(views_.inputs.size(), "input"),
                    "two or more, one for each camera, for example left/ right/");
    }
    std::vector<std::string> sources = views_.sources();
    sources.push_back(common_.config);
    append(sources, mapped(fixed_, cameraFilePath));
    checkOutputs(std::vector<Output>{{"--output", output_}, {"--evidence", evidence_}, {"--report", report_}},
                 sources, common_);
    if (models_.size() > 1 && models_.size() != views_.inputs.size()) {
      throw flagError("--model",
                      fmt::format("{} models for {} cameras", models_.size(), views_.inputs.size()),
                      "one model, or one for each camera");
    }
  }

  [[nodiscard]] RigOptions rigOptions() const {
    RigOptions options{.camera = {.tolerance_px = *parsePixels(tolerance_), .jobs = common_.jobs},
                       .models = {}};
    options.camera.cancel = common_.cancel;
    options.camera.board_shape = *boardShapeMode(shape_);
    options.camera.num_pupil = pupilNumbers(pupil_);
    if (models_.size() == 1) options.camera.model = models_.front();
    if (models_.size() > 1) options.models = models_;
    return options;
  }

  [[nodiscard]] bool isKept(const RigCalibration& rig) const { return rig.isUsable() || keep_; }

  // Writes all requested files.
  void write(const RigCalibration& rig, const RigRecord& record, const std::vector<GivenViews>& given,
             double tolerance_px) const {
    if (!output_.empty() && isKept(rig)) saveRig(output_, record);
    if (evidence_.empty() && report_.empty()) return;
    const nlohmann::json evidence =
        rigEvidenceDocument(rig, tolerance_px, originOf(views_.inputs, date_, {{"--fixed", fixed_}}));
    if (!evidence_.empty()) writeFileAtomically(evidence_, jsonText(evidence));
    if (report_.empty()) return;
    const std::vector<PictureSource> pictures =
        mapped(given, [&](const GivenViews& of) { return picturesOf(of.images, of.image_set, nullptr); });
    writeFileAtomically(report_,
                        reportPage(evidence, evidence_, {.pictures = pictures, .num_jobs = common_.jobs}));
    if (!common_.quiet) printMessage("report written to " + report_);
  }

  void print(const RigCalibration& rig, const std::vector<GivenViews>& given, int num_frames) {
    const bool is_coloured = isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr;
    answer([&] { return rigSummaryJson(rig); },
           [&] {
             return rigSummaryText(rig, given, num_frames, is_coloured) +
                    (is_verbose_ ? "\n" + rigDetailsText(rig, given) : "");
           });
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
      throw flagError("--fixed", fmt::format("{} files for {} cameras", fixed_.size(), views_.inputs.size()),
                      "one for each camera, or '-'");
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
      throw flagError(
          "--model", fmt::format("{} for {}, whose lens --fixed keeps", model, names[c]),
          fmt::format("{}, the model of its file, or auto", std::string(given[c]->camera.modelId())),
          "leave out one of the two flags for this camera");
    }
  }

  RigInputs views_;
  std::vector<std::string> models_;
  std::string shape_ = "auto";
  std::string pupil_ = "auto";
  std::string offsets_ = "auto";
  std::vector<std::string> fixed_;
  std::string output_;
  std::string evidence_;
  std::string report_;
  std::string date_;
  std::string tolerance_ = "1px";
  bool keep_ = false;
  bool is_verbose_ = false;
};

}  // namespace

const CommandEntry kRigCalibrateCommand = {"rig calibrate", "Calibrate the cameras of a rig in one joint fit",
                                           made<RigCalibrateCommand>};

}  // namespace alidade
