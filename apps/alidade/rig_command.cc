// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/adjust/errors.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/corners_file.h"
#include "alidade/files/rig_file.h"
#include "alidade/rig/rig_calibrator.h"
#include "board_views.h"
#include "console.h"
#include "json_output.h"
#include "options.h"

namespace alidade {
namespace {

// "left" for photos/left/, photos/left*.png and left.csv.
std::string nameOf(const std::string& input) {
  std::filesystem::path path(input);
  if (!path.has_filename()) path = path.parent_path();
  std::string name = path.filename().string();
  name = name.substr(0, name.find_first_of("*?[%"));
  if (isCornersFile(input) || std::filesystem::path(name).has_extension())
    name = std::filesystem::path(name).stem().string();
  while (!name.empty() && (name.back() == '_' || name.back() == '-' || name.back() == '.')) name.pop_back();
  return name;
}

std::string poseLine(const RigCamera& camera, const SE3& camera_from_rig) {
  constexpr double kMillimetres = 1000;
  constexpr double kDegrees = 180 / std::numbers::pi;
  const Eigen::Vector3d origin = camera_from_rig.inverse().translation * kMillimetres;
  return fmt::format(
      "at ({:.1f}, {:.1f}, {:.1f}) mm, {:.2f} mm from the first camera, turned by {:.3f} degrees; "
      "standard deviation {:.2f} mm, {:.3f} degrees",
      origin.x(), origin.y(), origin.z(), origin.norm(), camera_from_rig.rotation.log().norm() * kDegrees,
      camera.position_std_m.norm() * kMillimetres, camera.rotation_std_rad.norm() * kDegrees);
}

std::string summaryOf(const RigCalibration& rig) {
  constexpr std::size_t kMostDiagnoses = 8;
  const Verdict verdict = rig.verdict();
  std::string text =
      fmt::format("Verdict   {}\n", verdict == Verdict::kTrustworthy    ? "trustworthy"
                                    : verdict == Verdict::kReservations ? "usable with reservations"
                                                                        : "rejected: do not use this rig");
  text +=
      fmt::format("Rig       {} cameras, {} frames; {} boards seen by two or more cameras; RMS {:.3f} px\n",
                  rig.cameras.size(), rig.frames.size(), rig.num_linked, rms(rig.fit));
  if (rig.num_renumbered > 0)
    text +=
        fmt::format("          {} views of an ambiguous board were numbered like the others of their frame\n",
                    rig.num_renumbered);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    const FitCamera& fitted = rig.fit.cameras[c];
    text += fmt::format(
        "{}\n          {}, {}x{} px; RMS {:.3f} px (alone {:.3f}); from its neighbour within {:.2g} px (95 "
        "%)\n",
        camera.name, fitted.model, fitted.size.width, fitted.size.height, camera.rms_px, camera.alone_rms_px,
        camera.transfer_px);
    if (c > 0) text += "          " + poseLine(camera, fitted.camera_from_rig) + "\n";
  }
  std::size_t num_told = 0;
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    if (diagnosis.severity < Severity::kWarning) continue;
    if (++num_told > kMostDiagnoses) continue;
    text += fmt::format("{:<9} {}{}\n", diagnosis.severity == Severity::kFailure ? "FAILED" : "Warning",
                        diagnosis.message(), diagnosis.next_step.empty() ? "" : "; " + diagnosis.next_step);
  }
  if (num_told > kMostDiagnoses) text += fmt::format("          and {} more\n", num_told - kMostDiagnoses);
  return text;
}

json poseJson(const SE3& pose) {
  const Eigen::Vector4d q = pose.rotation.quaternion().coeffs();
  const Eigen::Vector3d& t = pose.translation;
  return {{"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}, {"translation_m", {t.x(), t.y(), t.z()}}};
}

std::string jsonOf(const RigCalibration& rig) {
  json cameras = json::array();
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    const FitCamera& fitted = rig.fit.cameras[c];
    const auto names = parameterNames(fitted.model);
    json parameters;
    for (std::size_t i = 0; i < names.size(); ++i) parameters[std::string(names[i])] = fitted.params[i];
    cameras.push_back(
        {{"name", camera.name},
         {"model", fitted.model},
         {"image_size", {{"width", fitted.size.width}, {"height", fitted.size.height}}},
         {"parameters", parameters},
         {"camera_from_rig", poseJson(fitted.camera_from_rig)},
         {"translation_std_m",
          {camera.position_std_m.x(), camera.position_std_m.y(), camera.position_std_m.z()}},
         {"rotation_std_rad",
          {camera.rotation_std_rad.x(), camera.rotation_std_rad.y(), camera.rotation_std_rad.z()}},
         {"rms_px", camera.rms_px},
         {"alone_rms_px", camera.alone_rms_px},
         {"transfer_px", camera.transfer_px}});
  }
  json diagnoses = json::array();
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    diagnoses.push_back({{"severity", severityName(diagnosis.severity)},
                         {"id", diagnosis.id},
                         {"message", diagnosis.message()},
                         {"next_step", diagnosis.next_step}});
  }
  json unlinked = json::array();
  for (const UnlinkedView& view : rig.unlinked)
    unlinked.push_back(
        {{"camera", rig.cameras[view.camera].name}, {"image", view.image}, {"frame", view.frame}});
  return jsonText({{"verdict", verdictName(rig.verdict())},
                   {"rms_px", rms(rig.fit)},
                   {"num_frames", rig.frames.size()},
                   {"num_linked", rig.num_linked},
                   {"num_renumbered", rig.num_renumbered},
                   {"unlinked", std::move(unlinked)},
                   {"cameras", std::move(cameras)},
                   {"diagnoses", std::move(diagnoses)}});
}

class RigCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade rig calibrate left/ right/ --board checkerboard:9x6:25mm -o rig.yaml\n"
        "Images with the same name, or else with the same last number in it, were taken at the same time.\n"
        "Exit code 3: done, but the rig must not be used; no rig file is written.");
    app.add_option("action", action_, "What to do: calibrate")->check(CLI::IsMember({"calibrate"}));
    app.add_option("input", inputs_,
                   "One for each camera: a folder of images, a pattern in quotes, or a corners file (.csv)");
    addBoardOption(app, boards_);
    std::vector<std::string> models(modelIds().begin(), modelIds().end());
    models.emplace_back(kAutoModel);
    app.add_option(
           "--model", models_,
           "Camera model as for alidade calibrate, for all cameras; or one for each, separated by commas")
        ->delimiter(',')
        ->check(CLI::IsMember(models));
    app.add_option("--names", names_, "Names of the cameras, separated by commas. Default: from the inputs")
        ->delimiter(',');
    addDetectionOptions(app, detection_);
    app.add_option("-o,--output", output_, "Rig file to write (YAML)");
    app.add_option("--tolerance", tolerance_, "Error of a projected point that you accept (95 %)")
        ->check(pixelComplaint, "")
        ->capture_default_str();
    app.add_flag("--keep-untrustworthy", keep_, "Write the rig file even if the rig must not be used");
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (action_.empty()) throw missingError("rig", "no action", "calibrate");
    if (inputs_.size() < 2) {
      throw missingError("rig", fmt::format("{} inputs", inputs_.size()),
                         "two or more, one for each camera, for example left/ right/");
    }
    std::vector<std::string> sources;
    for (const std::string& input : inputs_) {
      const std::vector<std::string> files = isCornersFile(input) ? std::vector{input} : withImages({input});
      sources.insert(sources.end(), files.begin(), files.end());
    }
    checkOutput(output_, sources, common_);
    RigOptions options{.camera = {.tolerance_px = *parsePixels(tolerance_), .jobs = common_.jobs},
                       .models = {}};
    options.camera.cancel = catchInterrupts();
    if (models_.size() == 1) options.camera.model = models_.front();
    if (models_.size() > 1) options.models = models_;
    if (models_.size() > 1 && models_.size() != inputs_.size()) {
      throw usageError({.where = "--model",
                        .found = fmt::format("{} models for {} cameras", models_.size(), inputs_.size()),
                        .expected = "one model, or one for each camera"});
    }
    std::vector<Board> boards;
    std::vector<RigViews> cameras = readCameras(options.camera.cancel, boards);
    const RigCalibration rig = calibrateRig(boards, std::move(cameras), options);
    const bool is_kept = rig.isUsable() || keep_;
    if (!output_.empty() && is_kept) writeFileAtomically(output_, rigFileText(recordOf(rig, programName())));
    if (common_.json) {
      printResult(jsonOf(rig));
    } else if (!common_.quiet) {
      printResult(summaryOf(rig));
    }
    if (!rig.isUsable()) {
      printRefusal("the rig must not be used: " + rig.diagnoses.front().message(), output_, is_kept);
      return kUntrustworthyExit;
    }
    if (!common_.quiet)
      printMessage(output_.empty() ? "no rig file written (give -o rig.yaml)" : "written to " + output_);
    return 0;
  }

 private:
  std::vector<std::string> cameraNames() const {
    std::vector<std::string> names = names_;
    if (names.empty()) {
      for (const std::string& input : inputs_) names.push_back(nameOf(input));
    }
    const std::set<std::string> unique(names.begin(), names.end());
    if (names.size() != inputs_.size() || unique.size() != names.size() || unique.contains("")) {
      throw usageError(
          {.where = names_.empty() ? "rig" : "--names",
           .found = "the names " + join(names, ", ") + fmt::format(" for {} cameras", inputs_.size()),
           .expected = "a different name for each camera",
           .next_step = "give --names, for example --names left,right"});
    }
    return names;
  }

  std::vector<RigViews> readCameras(const CancelFlag* cancel, std::vector<Board>& boards) const {
    const std::vector<std::string> names = cameraNames();
    std::vector<RigViews> cameras;
    for (std::size_t c = 0; c < inputs_.size(); ++c) {
      GivenViews given =
          readViews({.command = "rig", .inputs = {inputs_[c]}, .boards = boards_, .detection = detection_},
                    common_, cancel);
      if (c == 0) boards = given.boards;
      if (given.boards != boards) {
        throw inputError({.where = inputs_[c],
                          .found = fmt::format("other boards than in {}: {}", inputs_.front(),
                                               join(mapped(given.boards, &Board::spec), " and ")),
                          .expected = fmt::format("{} for all cameras, in this order",
                                                  join(mapped(boards, &Board::spec), " and "))});
      }
      if (!common_.quiet && !common_.json) {
        printMessage(
            fmt::format("{}: a board in {} of {} images", names[c], given.num_found, given.num_images));
        if (!given.reasons.empty()) {
          const std::string lines = listed(given.reasons);
          printMessage(lines.substr(0, lines.size() - 1));
        }
      }
      cameras.push_back({.name = names[c], .views = std::move(given.views)});
    }
    return cameras;
  }

  std::string action_;
  std::vector<std::string> inputs_;
  std::vector<std::string> boards_;
  std::vector<std::string> models_;
  std::vector<std::string> names_;
  DetectionOptions detection_;
  std::string output_;
  std::string tolerance_ = "1px";
  bool keep_ = false;
};

}  // namespace

std::unique_ptr<Command> makeRigCommand() {
  return std::make_unique<RigCommand>();
}

}  // namespace alidade
