// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "alidade/adjust/errors.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "alidade/report/rig_evidence.h"
#include "alidade/rig/rig_calibrator.h"
#include "console.h"
#include "options.h"
#include "report_output.h"
#include "rig/rig_inputs.h"

namespace alidade {
namespace {

std::string poseLine(const RigCamera& camera, const SE3& camera_from_rig) {
  constexpr double kMillimetres = 1000;
  const Eigen::Vector3d origin = camera_from_rig.inverse().translation * kMillimetres;
  return fmt::format(
      "at ({:.1f}, {:.1f}, {:.1f}) mm, {:.2f} mm from the first camera, turned by {:.3f} degrees; "
      "standard deviation {:.2f} mm, {:.3f} degrees",
      origin.x(), origin.y(), origin.z(), origin.norm(), camera_from_rig.rotation.log().norm() * kDegPerRad,
      camera.position_std_m.norm() * kMillimetres, camera.rotation_std_rad.norm() * kDegPerRad);
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
  if (rig.holdout.num_corners > 0)
    text += fmt::format("          cross-validation {:.3f} px\n", rig.holdout.rms_px);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    const FitCamera& fitted = rig.fit.cameras[c];
    text += fmt::format(
        "{}\n          {}, {}x{} px; RMS {:.3f} px (alone {:.3f}); from its neighbour {}\n", camera.name,
        fitted.model, fitted.size.width, fitted.size.height, camera.rms_px, camera.alone_rms_px,
        std::isfinite(camera.transfer_px) ? fmt::format("within {:.2f} px (95 %)", camera.transfer_px)
                                          : "unknown");
    if (c > 0) text += "          " + poseLine(camera, fitted.camera_from_rig) + "\n";
  }
  std::size_t num_told = 0;
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    const bool is_of_input = diagnosis.id == "unmatched_images" || diagnosis.id == "times_differ";
    if (is_of_input) text += "Note      " + diagnosis.message() + "\n";
    if (diagnosis.severity < Severity::kWarning) continue;
    if (++num_told > kMostDiagnoses) continue;
    text += fmt::format("{:<9} {}{}\n", diagnosis.severity == Severity::kFailure ? "FAILED" : "Warning",
                        diagnosis.message(), diagnosis.next_step.empty() ? "" : "; " + diagnosis.next_step);
  }
  if (num_told > kMostDiagnoses) text += fmt::format("          and {} more\n", num_told - kMostDiagnoses);
  return text;
}

class RigCalibrateCommand final : public Command {
 public:
  void setUp(CLI::App& app) override {
    app.footer(
        "Example: alidade rig calibrate left/ right/ --board checkerboard:9x6:25mm -o rig.yaml\n"
        "Images with the same name, or else with the same last number in it, were taken at the same time.\n"
        "Exit code 3: done, but the rig must not be used; no rig file is written.");
    app.add_option("input", views_.inputs,
                   "One for each camera: a folder of images, a pattern in quotes, or a corners file (.csv)");
    views_.addOptions(app);
    std::vector<std::string> models(modelIds().begin(), modelIds().end());
    models.emplace_back(kAutoModel);
    app.add_option(
           "--model", models_,
           "Camera model as for alidade calibrate, for all cameras; or one for each, separated by commas")
        ->delimiter(',')
        ->check(CLI::IsMember(models));
    app.add_option(
           "--fixed", fixed_,
           "Camera files of cameras calibrated before, one for each camera, separated by commas ('-': "
           "calibrate this one); their lenses are kept")
        ->delimiter(',');
    app.add_option("--board-shape", shape_,
                   "flat: boards are flat; warp: their bend is estimated; uneven: the place of every point; "
                   "auto: what is seen")
        ->check(CLI::IsMember({"flat", "warp", "uneven", "auto"}))
        ->capture_default_str();
    app.add_option("-o,--output", output_, "Rig file to write (YAML)");
    app.add_option("--evidence", evidence_, "JSON file to write: all results with the errors of all corners");
    app.add_option("--report", report_, "HTML page to write: the rig and its errors in figures, in one file");
    app.add_option("--tolerance", tolerance_, "Error of a projected point that you accept (95 %)")
        ->check(pixelComplaint, "")
        ->capture_default_str();
    app.add_flag("--keep-untrustworthy", keep_, "Write the rig file even if the rig must not be used");
    addCommonOptions(app, common_, true);
  }

  int run(const CLI::App&) override {
    if (views_.inputs.size() < 2) {
      throw missingError("rig calibrate", fmt::format("{} inputs", views_.inputs.size()),
                         "two or more, one for each camera, for example left/ right/");
    }
    std::vector<std::string> sources = views_.sources();
    sources.push_back(common_.config);
    for (const std::string& file : fixed_) sources.push_back(cameraFilePath(file));
    checkOutput(output_, sources, common_);
    checkFurtherOutputs(sources);
    RigOptions options{.camera = {.tolerance_px = *parsePixels(tolerance_), .jobs = common_.jobs},
                       .models = {}};
    options.camera.cancel = catchInterrupts();
    if (models_.size() == 1) options.camera.model = models_.front();
    if (models_.size() > 1) options.models = models_;
    if (models_.size() > 1 && models_.size() != views_.inputs.size()) {
      throw usageError(
          {.where = "--model",
           .found = fmt::format("{} models for {} cameras", models_.size(), views_.inputs.size()),
           .expected = "one model, or one for each camera"});
    }
    options.given = givenCameras();
    options.frames = views_.frames();
    options.camera.board_shape = shapeMode(shape_);
    RigInputViews given = readRigViews("rig calibrate", views_, views_.cameraNames("rig calibrate"), common_,
                                       options.camera.cancel);
    const RigCalibration rig = calibrateRig(given.boards, std::move(given.cameras), options);
    const bool is_kept = rig.isUsable() || keep_;
    if (!output_.empty() && is_kept) writeFileAtomically(output_, rigFileText(recordOf(rig, programName())));
    writeEvidence(rig, options.camera.tolerance_px);
    if (common_.json) {
      printResult(rigSummaryJson(rig));
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
  void checkFurtherOutputs(const std::vector<std::string>& sources) const {
    std::vector<std::string> taken = {output_};
    for (const auto& [flag, path] : {std::pair("--evidence", evidence_), std::pair("--report", report_)}) {
      if (path.empty()) continue;
      const bool is_taken = std::ranges::any_of(taken, [&](const std::string& other) {
        return !other.empty() && writtenPath(other) == writtenPath(path);
      });
      if (path == "-" || is_taken) {
        throw usageError({.where = fmt::format("{} {}", flag, path),
                          .found = path == "-" ? "standard output, which is used for the results"
                                               : "the same file as another output",
                          .expected = "a different file"});
      }
      checkOutput(path, sources, common_, flag);
      taken.push_back(path);
    }
  }

  // The evidence file and the report, as far as they are asked for.
  void writeEvidence(const RigCalibration& rig, double tolerance_px) const {
    if (evidence_.empty() && report_.empty()) return;
    const std::string evidence = rigEvidenceJson(rig, tolerance_px, programName());
    if (!evidence_.empty()) writeFileAtomically(evidence_, evidence);
    if (report_.empty()) return;
    writeReport(report_, evidence, evidence_, {});
    if (!common_.quiet) printMessage("report written to " + report_);
  }

  std::vector<std::optional<CameraRecord>> givenCameras() const {
    if (!fixed_.empty() && fixed_.size() != views_.inputs.size()) {
      throw usageError({.where = "--fixed",
                        .found = fmt::format("{} files for {} cameras", fixed_.size(), views_.inputs.size()),
                        .expected = "one for each camera, or '-'"});
    }
    return mapped(fixed_, [&](const std::string& file) {
      return file == "-" ? std::nullopt : std::optional(readCameraTelling(file, {}, common_.quiet));
    });
  }

  RigInputs views_;
  std::vector<std::string> models_;
  std::string shape_ = "auto";
  std::vector<std::string> fixed_;
  std::string output_;
  std::string evidence_;
  std::string report_;
  std::string tolerance_ = "1px";
  bool keep_ = false;
};

}  // namespace

std::unique_ptr<Command> makeRigCalibrateCommand() {
  return std::make_unique<RigCalibrateCommand>();
}

}  // namespace alidade
