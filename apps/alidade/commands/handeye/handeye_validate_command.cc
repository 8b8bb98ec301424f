// SPDX-License-Identifier: MIT
#include <cmath>

#include <fmt/format.h>

#include "alidade/core/degrees.h"
#include "alidade/core/statistics.h"
#include "alidade/core/text.h"
#include "alidade/files/hand_eye_file.h"
#include "alidade/handeye/hand_eye_difference.h"
#include "alidade/report/data/json_output.h"
#include "command.h"
#include "commands/handeye/handeye_inputs.h"
#include "console.h"
#include "outputs.h"
#include "summary_lines.h"

namespace alidade {
namespace {

// The answer about a transform and another one.
struct Compared {
  HandEyeDifference difference;
  double distance_m;
  double tolerance_m;
  bool is_test;  // of one by images, and not of two files

  [[nodiscard]] double limit95() const { return kNormal95 * std::sqrt(3.0) * difference.point_std_m; }
  // False if the difference can be chance, or does not matter.
  [[nodiscard]] bool isChanged() const {
    return difference.point_m > tolerance_m && (difference.sigmas == 0 || difference.isSignificant());
  }
  // True if neither equal nor different can be said within the tolerance.
  [[nodiscard]] bool isOpen() const {
    return !isChanged() && (difference.point_m > tolerance_m || (is_test && limit95() > tolerance_m));
  }

  [[nodiscard]] std::string verdict() const { return isChanged() ? "FAILED" : isOpen() ? "unknown" : "PASS"; }
  [[nodiscard]] std::string reason() const {
    const std::string by =
        fmt::format("a point at {:.2g} m is {} elsewhere", distance_m, millimetres(difference.point_m));
    if (isChanged())
      return by + ", more than " + millimetres(tolerance_m) +
             (difference.sigmas > 0 ? " and than chance explains" : "");
    if (isOpen()) return by + ", and differences of up to " + millimetres(limit95()) + " could be chance";
    return by + "; limit " + millimetres(tolerance_m);
  }
  [[nodiscard]] std::string text() const {
    Lines lines = wrapped(verdict(), reason());
    addLines(lines, "Transform", "differs by {} and {:.3g} degrees{}", millimetres(difference.translation_m),
             kDegPerRad * difference.rotation_rad,
             difference.sigmas > 0 ? fmt::format(", {:.1f} standard deviations", difference.sigmas) : "");
    return join(lines, "\n") + "\n";
  }
  [[nodiscard]] json document() const {
    return {{"verdict", verdict()},
            {"reason", reason()},
            {"distance_m", distance_m},
            {"tolerance_m", tolerance_m},
            {"point_difference_m", difference.point_m},
            {"translation_difference_m", difference.translation_m},
            {"rotation_difference_rad", difference.rotation_rad},
            {"sigmas", difference.sigmas}};
  }
};

class HandEyeValidateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(std::string("Example: alidade handeye validate handeye.yaml new/ --poses poses.csv --board "
                              "checkerboard:9x6:25mm\n") +
                  kPosesHelp +
                  "\nInstead of images, a second hand-eye file may be given: the two are compared.\n"
                  "Exit code 3: the camera sits elsewhere now, or this cannot be told within the tolerance.");
    flags.add("handeye", &file_, "Hand-eye file of alidade handeye calibrate", kFilePath);
    flags.add(
        "input", &inputs_.views.inputs,
        "Images that it was not made of: folders, files, patterns, videos or corners files; or a second hand-eye file",
        kFilePath);
    inputs_.addOptions(flags);
    flags.under(kVerdictGroup);
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    if (file_.empty() || inputs_.views.inputs.empty())
      throw missing("no input", "a hand-eye file, then new images or a second hand-eye file");
    common_.cancel = catchInterrupts();
    const HandEyeRecord stated = readHandEye(file_);
    return inputs_.poses.empty() ? compareFiles(stated) : compareImages(stated);
  }

 private:
  int compareFiles(const HandEyeRecord& stated) {
    const std::string& other = inputs_.views.inputs.front();
    if (inputs_.views.inputs.size() > 1 || !isYaml(other))
      throw missing("images without --poses", "the robot's pose for each image: --poses poses.csv");
    constexpr double kUsualDistance = 0.5;  // m
    return tell({differenceOf(stated, readHandEye(other), kUsualDistance), kUsualDistance,
                 inputs_.toleranceM(), false});
  }

  int compareImages(const HandEyeRecord& stated) {
    HandEyeInputs inputs = inputs_;
    if (inputs.camera_on.empty()) inputs.camera_on = cameraOnName(stated.camera_on);
    const HandEyeCalibration now = inputs.calibrate(common_);
    for (const Diagnosis& diagnosis : now.diagnoses) {
      // Accuracy alone is part of the comparison.
      if (diagnosis.id == DiagnosisId("hand_eye_inaccurate") || diagnosis.severity < Severity::kWarning)
        continue;
      if (diagnosis.severity == Severity::kFailure) {
        throw Error(ErrorCode::kVerdict,
                    {.where = file_,
                     .found = "images and poses that cannot test it: " + diagnosis.message(),
                     .next_step = diagnosis.next_step});
      }
      if (!common_.quiet) printMessage("warning: " + diagnosis.message());
    }
    return tell({differenceOf(stated, recordOf(now, programName()), now.board_distance_m),
                 now.board_distance_m, inputs_.toleranceM(), true});
  }

  static bool isYaml(const std::string& path) { return path.ends_with(".yaml") || path.ends_with(".yml"); }

  int tell(const Compared& compared) {
    answer([&] { return jsonText(compared.document()); }, [&] { return compared.text(); });
    if (!compared.isChanged() && !compared.isOpen()) return 0;
    printMessage("error: " + compared.reason());
    return kUntrustworthyExit;
  }

  std::string file_;
  HandEyeInputs inputs_;
};

}  // namespace

const CommandEntry kHandEyeValidateCommand = {"handeye validate",
                                              "Test a hand-eye file on new images, or against another one",
                                              made<HandEyeValidateCommand>};

}  // namespace alidade
