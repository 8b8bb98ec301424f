// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/rig_file.h"
#include "alidade/report/data/json_output.h"
#include "alidade/rig/rig_validation.h"
#include "command.h"
#include "commands/rig/rig_footage.h"
#include "commands/rig/rig_inputs.h"
#include "console.h"
#include "summary_lines.h"

namespace alidade {
namespace {

std::string validationText(const RigValidation& tested) {
  const Verdict verdict = tested.verdict();
  Lines lines =
      wrapped("Verdict", verdict == Verdict::kTrustworthy    ? "the images confirm the rig"
                         : verdict == Verdict::kReservations ? "the images confirm the rig with reservations"
                                                             : "the images contradict the rig");
  for (const Diagnosis& diagnosis : tested.diagnoses) {
    if (diagnosis.severity == Severity::kFailure) append(lines, diagnosisLines(diagnosis));
  }
  if (std::isfinite(tested.epipolar_px)) {
    addLines(lines, "Epipolar", "error {:.3f} px RMS, {} points seen by two or more cameras",
             tested.epipolar_px, tested.num_points - tested.num_failed);
  }
  if (tested.num_failed > 0) {
    addLines(lines, "Points", "{} of {} that two or more cameras see have no position", tested.num_failed,
             tested.num_points);
  }
  if (std::isfinite(tested.length_ratio)) {
    addLines(lines, "Lengths", "on the boards {:+.3f} %, standard deviation {:.3f} %",
             100 * (tested.length_ratio - 1), 100 * tested.length_ratio_std);
  }
  for (const TestedRigCamera& camera : tested.cameras) {
    const bool is_first = &camera == &tested.cameras.front();
    std::string text = fmt::format("{}: RMS {:.3f} px; {:.3f} px with the poses freed", camera.name,
                                   camera.rms_px, camera.freed_rms_px);
    if (!is_first) {
      constexpr double kMmPerM = 1000;
      text += fmt::format(", which moves it by {:.2f} mm and {}: {:.2f} px, {} sigma",
                          camera.freed_from_stated.translation.norm() * kMmPerM,
                          turnText(camera.freed_from_stated.rotation.inverse()), camera.effect_px,
                          std::isnan(camera.sigmas) ? "unknown" : fmt::format("{:.1f}", camera.sigmas));
    }
    append(lines, wrapped(is_first ? "Camera" : "", text));
  }
  for (const Diagnosis& diagnosis : tested.diagnoses) {
    if (diagnosis.severity < Severity::kFailure) append(lines, diagnosisLines(diagnosis));
  }
  return join(lines, "\n") + "\n";
}

std::string validationJson(const RigValidation& tested) {
  json cameras = json::array();
  for (const TestedRigCamera& camera : tested.cameras) {
    const Eigen::Vector3d w = camera.freed_from_stated.rotation.log();
    const Eigen::Vector3d& t = camera.freed_from_stated.translation;
    cameras.push_back({{"name", camera.name},
                       {"rms_px", camera.rms_px},
                       {"freed_rms_px", camera.freed_rms_px},
                       {"translation_m", {t.x(), t.y(), t.z()}},
                       {"rotation_rad", {w.x(), w.y(), w.z()}},
                       {"effect_px", camera.effect_px},
                       {"sigmas", camera.sigmas}});
  }
  return jsonText({{"verdict", verdictName(tested.verdict())},
                   {"tolerance_px", tested.tolerance_px},
                   {"rms_px", tested.rms_px},
                   {"freed_rms_px", tested.freed_rms_px},
                   {"epipolar_px", tested.epipolar_px},
                   {"num_points", tested.num_points},
                   {"num_failed", tested.num_failed},
                   {"length_ratio", tested.length_ratio},
                   {"length_ratio_std", tested.length_ratio_std},
                   {"cameras", std::move(cameras)},
                   {"diagnoses", tested.diagnoses}});
}

class RigValidateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade rig validate rig.yaml left/ right/ --board checkerboard:9x6:25mm\nExample: alidade "
        "rig validate rig.yaml left/ right/ --footage\nInputs are in the order of the rig's cameras, unless "
        "--names or their own names say otherwise.\n--footage needs no board: points that two cameras see at "
        "the same time show whether a camera was turned or its lens is\nanother one (docs/footage.md). It "
        "may be unable to tell.\nExit code 3: the images contradict the rig.");
    flags.add("rig", &rig_path_, "Rig file of any format that states where its cameras are", kFilePath);
    views_.addOptions(flags);
    flags.under(kFootageGroup);
    flags.addSwitch(
        "--footage", is_footage_,
        "The images are ordinary pictures, taken at the same time by all cameras; no board is needed");
    flags.under(nullptr);
    flags.add("--tolerance", &tolerance_,
              "Error of a projected point that you accept (95 %): 0.25px, or 1px if the rig file states no "
              "covariance. For --footage, whose default is 0.2px, a fifth of the error of rows that surely "
              "fails",
              kPixelText);
    flags.addCommon(common_, true);
  }

  int run(const Flags& /*flags*/) override {
    if (rig_path_.empty()) throw missing("no rig file", "a rig file and images");
    if (is_footage_ && !views_.mirrored_of.empty())
      throw misuse("--mirrored with --footage", "images that are not mirrored");
    const RigRecord rig = loadRig(rig_path_);
    if (views_.inputs.size() != rig.cameras.size()) {
      throw missing(fmt::format("{} inputs", views_.inputs.size()),
                    fmt::format("{}, one for each camera: {}", rig.cameras.size(),
                                join(mapped(rig.cameras, nameOf), ", ")));
    }
    tellIfRejected(rig, rig_path_, common_.quiet);
    if (views_.names.empty()) {
      views_.sortLike(mapped(rig.cameras, nameOf), common_);
    } else {
      sortByNames(rig);
    }
    common_.cancel = catchInterrupts();
    const std::string no = is_footage_ ? contradictionByFootage(rig) : contradictionByBoards(rig);
    if (no.empty()) return 0;
    printMessage("error: the images contradict the rig: " + no);
    return kUntrustworthyExit;
  }

 private:
  static std::string nameOf(const RigCameraRecord& camera) { return camera.camera.name.name; }

  // Each test prints its findings. @returns the errors of the rig; empty: none
  [[nodiscard]] std::string contradictionByBoards(const RigRecord& rig) {
    RigOptions options;
    options.camera.jobs = common_.jobs;
    options.camera.cancel = common_.cancel;
    double tolerance = rigTolerancePx(rig);
    if (!tolerance_.empty()) tolerance = options.camera.tolerance_px = *parsePixels(tolerance_);
    const std::vector<std::string> names = mapped(rig.cameras, nameOf);
    options.rate_hz = views_.rateOfVideos(common_);
    RigInputViews given = readRigViews(views_, names, common_);
    options.frames = given.frames;
    RigValidation tested = validateRig(rig, given.boards, std::move(given.cameras), tolerance, options);
    if (views_.shiftTo(tested.freed, common_)) {
      given = readRigViews(views_, names, common_);
      tested = validateRig(rig, given.boards, std::move(given.cameras), tolerance, options);
    }
    answer([&] { return validationJson(tested); }, [&] { return validationText(tested); });
    return tested.verdict() == Verdict::kNo ? tested.diagnoses.front().message() : "";
  }

  [[nodiscard]] std::string contradictionByFootage(const RigRecord& record) {
    FootageCheckOptions options{
        .tolerance_px = kRigFootageTolerancePx, .num_jobs = common_.jobs, .cancel = common_.cancel};
    if (!tolerance_.empty()) options.tolerance_px = *parsePixels(tolerance_);
    const std::vector<RigPairMatches> pairs = matchRigFootage(record, views_, common_);
    const AnyRig rig = rigOf(record);
    const RigCheck check = checkRigOnFootage(rig, pairs, options);
    answer([&] { return rigFootageJson(check, pairs.empty() ? 0 : pairs.front().instants.size(), rig); },
           [&] { return rigFootageText(check, rig); });
    return check.verdict == FootageVerdict::kInconsistent ? rigContradiction(check, rig) : "";
  }

  // Sorts the inputs, which --names assigns, in the order of the rig.
  void sortByNames(const RigRecord& rig) {
    const std::vector<std::string> cameras = mapped(rig.cameras, nameOf);
    const std::vector<std::string> names = views_.cameraNames(common_);
    const auto places = placesByName(names, cameras);
    if (!places) {
      const auto unknown = std::ranges::find_if(
          names, [&](const auto& name) { return std::ranges::count(cameras, name) == 0; });
      throw flagError("--names", "'" + *unknown + "'", "the cameras of the rig: " + join(cameras, ", "));
    }
    views_.placeAt(*places);
    views_.names = cameras;
  }

  std::string rig_path_;
  RigInputs views_;
  bool is_footage_ = false;
  std::string tolerance_;
};

}  // namespace

const CommandEntry kRigValidateCommand = {
    "rig validate", "Test a rig on images of boards, or on ordinary ones", made<RigValidateCommand>};

}  // namespace alidade
