// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_list.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/pages/rig_validation_page.h"
#include "alidade/rig/rig_validation.h"
#include "alidade/validate/held_out/held_out_images.h"
#include "command.h"
#include "commands/rig/rig_footage.h"
#include "commands/rig/rig_inputs.h"
#include "console.h"
#include "junit.h"
#include "outputs.h"
#include "page_file.h"
#include "summary_lines.h"

namespace alidade {
namespace {

std::string validationText(const RigValidation& tested) {
  std::string headline = rigHeadline(tested.verdict());
  headline.front() = 't';
  Lines lines = wrapped("Verdict", headline);
  for (const Diagnosis& diagnosis : tested.diagnoses) {
    if (diagnosis.severity == Severity::kFailure) append(lines, diagnosisLines(diagnosis));
  }
  if (std::isfinite(tested.epipolar_px)) {
    addLines(lines, "Epipolar", "error {:.3f} px RMS, {} points seen by two or more cameras",
             tested.epipolar_px, tested.num_points);
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

json validationJson(const RigValidation& tested) {
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
  return {{"verdict", verdictName(tested.verdict())},
          {"created_by", programName()},
          {"tolerance_px", tested.tolerance_px},
          {"rms_px", tested.rms_px},
          {"freed_rms_px", tested.freed_rms_px},
          {"epipolar_px", tested.epipolar_px},
          {"num_points", tested.num_points},
          {"num_failed", tested.num_failed},
          {"length_ratio", tested.length_ratio},
          {"length_ratio_std", tested.length_ratio_std},
          {"cameras", std::move(cameras)},
          {"diagnoses", tested.diagnoses}};
}

class RigValidateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(
        "Example: alidade rig validate rig.yaml left/ right/ --board checkerboard:9x6:25mm --junit "
        "report.xml\nExample: alidade rig validate rig.yaml left/ right/ --footage\nInputs are in the order of the rig's cameras, unless "
        "--names or their own names say otherwise.\n--footage needs no board: points that two cameras see at "
        "the same time show whether a camera was turned or its lens is\nanother one (docs/footage.md). It "
        "may be unable to tell.\nThe files of a pair that state where the cameras are (ROS) may stand in the place of a rig file: "
        "left.yaml right.yaml.\nExit code 3: the images contradict the rig; with --strict also: they confirm it with "
        "reservations, or cannot tell.");
    flags.add("rig", &rig_path_, "Rig file of any format that states where its cameras are", kFilePath);
    flags.addSwitch("--strict", is_strict_, "Treat reservations as failures");
    addJunitFlag(flags, common_);
    addReportFlag(flags, report_, "what was found, for boards");
    addDateFlag(flags, date_);
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
    if (is_footage_ && !report_.empty())
      throw misuse("--report with --footage", "one of them", "write the result with --junit or --json");
    const RigRecord rig = takeRig();
    checkOutputs(
        std::vector<Output>{{"--report", report_, "page.html"}, {"--junit", common_.junit, "report.xml"}},
        sources(), common_);
    checkJunitPath(common_.junit);
    if (views_.inputs.size() != rig.cameras.size()) {
      throw missing(counted(views_.inputs.size(), "input"),
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
    TestCase test = is_footage_ ? testOnFootage(rig) : testOnBoards(rig);
    if (!common_.junit.empty())
      writeFileAtomically(common_.junit, junitText("alidade rig validate", std::span(&test, 1)));
    if (!test.failure) return 0;
    printMessage("error: " + *test.failure);
    return kUntrustworthyExit;
  }

 private:
  static std::string nameOf(const RigCameraRecord& camera) { return camera.camera.name.name; }

  // The rig: of its file, or of the camera files of all cameras, which come first.
  [[nodiscard]] RigRecord takeRig() {
    rig_files_ = {rig_path_};
    const auto first_image = std::ranges::find_if_not(views_.inputs, isNamedAsCameraFile);
    rig_files_.insert(rig_files_.end(), views_.inputs.begin(), first_image);
    if (rig_files_.size() == 1) return loadRig(rig_path_);
    views_.inputs.erase(views_.inputs.begin(), first_image);
    rig_path_ = join(rig_files_, " ");
    const GatheredCameras gathered = gatherCameras(rig_files_, {});
    return rigOf(gathered.source);
  }

  [[nodiscard]] std::vector<std::string> sources() const {
    std::vector<std::string> all = views_.sources();
    append(all, mapped(rig_files_, cameraFilePath));
    all.push_back(common_.config);
    return all;
  }

  // Each test prints its findings.
  [[nodiscard]] TestCase testOnBoards(const RigRecord& rig) {
    RigOptions options;
    options.camera.jobs = common_.jobs;
    options.camera.cancel = common_.cancel;
    double tolerance = rigTolerancePx(rig);
    if (!tolerance_.empty()) tolerance = options.camera.tolerance_px = *parsePixels(tolerance_);
    const std::vector<std::string> names = mapped(rig.cameras, nameOf);
    options.rate_hz = views_.rateOfVideos(common_);
    RigInputViews given = readRigViews(views_, names, common_);
    options.frames = given.frames;
    std::vector<Diagnosis> own = ownImages(rig, given.cameras);
    RigValidation tested = validateRig(rig, given.boards, std::move(given.cameras), tolerance, options);
    if (views_.shiftTo(tested.freed, common_)) {
      given = readRigViews(views_, names, common_);
      own = ownImages(rig, given.cameras);
      tested = validateRig(rig, given.boards, std::move(given.cameras), tolerance, options);
    }
    tested.diagnoses.insert(tested.diagnoses.end(), own.begin(), own.end());
    sortDiagnoses(tested.diagnoses);
    const json document = validationJson(tested);
    if (!report_.empty())
      writeFileAtomically(
          report_, rigValidationPage(rig_path_, tested,
                                     originOf(views_.inputs, date_, {{"rig", {rig_path_}}}), document));
    TestCase test{.kind = "rig", .name = rig_path_, .text = validationText(tested)};
    answer([&] { return jsonText(document); }, [&] { return test.text; });
    if (!report_.empty() && !common_.quiet) printMessage("report written to " + report_);
    const Verdict verdict = tested.verdict();
    if (verdict == Verdict::kNo)
      test.failure = "the images contradict the rig: " + tested.diagnoses.front().message();
    if (verdict == Verdict::kReservations && is_strict_)
      test.failure = "the images confirm the rig only with reservations (--strict): " +
                     tested.diagnoses.front().message();
    return test;
  }

  // What the images of its own calibration cannot show about a rig.
  static std::vector<Diagnosis> ownImages(const RigRecord& rig, const std::vector<RigViews>& cameras) {
    std::vector<Diagnosis> found;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      const auto& stated = rig.cameras[c].camera.calibration;
      if (!stated || stated->view_centers.empty() || cameras[c].views.empty()) continue;
      Diagnosis own = ownImagesCheck(stated->view_centers, cameras[c].views);
      if (own.severity < Severity::kWarning) continue;
      own.cause = nameOf(rig.cameras[c]) + ": " + own.cause;
      found.push_back(std::move(own));
    }
    return found;
  }

  [[nodiscard]] TestCase testOnFootage(const RigRecord& record) {
    FootageCheckOptions options{
        .tolerance_px = kRigFootageTolerancePx, .num_jobs = common_.jobs, .cancel = common_.cancel};
    if (!tolerance_.empty()) options.tolerance_px = *parsePixels(tolerance_);
    const std::vector<RigPairMatches> pairs = matchRigFootage(record, views_, common_);
    const AnyRig rig = rigOf(record);
    const RigCheck check = checkRigOnFootage(rig, pairs, options);
    TestCase test{.kind = "footage", .name = rig_path_, .text = rigFootageText(check, rig)};
    answer([&] { return rigFootageJson(check, pairs.empty() ? 0 : pairs.front().instants.size(), rig); },
           [&] { return test.text; });
    if (check.verdict == FootageVerdict::kInconsistent)
      test.failure = "the images contradict the rig: " + rigContradiction(check, rig);
    if (check.verdict == FootageVerdict::kCannotTell)
      (is_strict_ ? test.failure : test.skipped) = "the images cannot tell whether the rig is right";
    return test;
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

  std::string rig_path_;  ///< all files of the rig, for messages
  std::vector<std::string> rig_files_;
  RigInputs views_;
  bool is_footage_ = false;
  std::string tolerance_;
  bool is_strict_ = false;
  std::string report_;
  std::string date_;
};

}  // namespace

const CommandEntry kRigValidateCommand = {
    "rig validate", "Test a rig on images of boards, or on ordinary ones", made<RigValidateCommand>};

}  // namespace alidade
