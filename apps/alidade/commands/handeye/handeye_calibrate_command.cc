// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/degrees.h"
#include "alidade/core/mapped.h"
#include "alidade/core/statistics.h"
#include "alidade/core/text.h"
#include "alidade/files/hand_eye_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/report/data/json_output.h"
#include "command.h"
#include "commands/handeye/handeye_inputs.h"
#include "console.h"
#include "outputs.h"
#include "page_file.h"
#include "summary_lines.h"

namespace alidade {
namespace {

constexpr double kMmInMetre = 1000;

std::size_t numUsed(const HandEyeCalibration& result) {
  return static_cast<std::size_t>(std::ranges::count(result.frames, "", &HandEyeFrame::reason));
}

std::string transformText(const HandEyeCalibration& result) {
  const SE3& pose = result.mount_from_camera;
  std::string text = "at (";
  for (Eigen::Index i = 0; i < 3; ++i) {
    // Of the translation in the mount's axes.
    const Eigen::Matrix3d R = pose.rotation.matrix();
    const double variance = R.row(i) * result.covariance.topLeftCorner<3, 3>() * R.row(i).transpose();
    text += (i == 0 ? "" : ", ") + millimetresText(pose.translation(i), std::sqrt(variance));
  }
  const double turn = result.covariance.block<3, 3>(3, 3).diagonal().cwiseSqrt().maxCoeff();
  return text + fmt::format(") mm in the frame of the {}, turned by {}, within {:.2g} degrees",
                            mountName(result.camera_on), turnText(pose.rotation),
                            kDegPerRad * kNormal95 * turn);
}

// As in a table of robot poses.
std::string poseRow(const SE3& pose) {
  const Eigen::Quaterniond& q = pose.rotation.quaternion();
  const Eigen::Vector3d& t = pose.translation;
  return fmt::format("{:.4f},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{:.5f}", t.x(), t.y(), t.z(), q.x(), q.y(),
                     q.z(), q.w());
}

std::string summaryText(const HandEyeCalibration& result, bool is_coloured) {
  Lines lines = wrapped("Verdict", verdictText(result.verdict(), "transform", is_coloured));
  if (!result.isSolved()) {
    for (const Diagnosis& diagnosis : result.diagnoses)
      for (const std::string& line : diagnosisLines(diagnosis)) lines.push_back(line);
    return join(lines, "\n") + "\n";
  }
  addLines(lines, "Accuracy",
           "a point {:.2f} m before the camera is known within {} (95 %), one at the {}'s "
           "origin within {}",
           result.board_distance_m, millimetres(result.error_m), mountName(result.camera_on),
           millimetres(result.tool_error_m));
  Lines rest =
      wrapped("Camera", fmt::format("on the {}, {}", cameraOnName(result.camera_on), transformText(result)));
  addLines(rest, "Robot", "off by {} and {:.2g} degrees in each axis (standard deviations)",
           millimetres(result.robot_noise.translation_m), kDegPerRad * result.robot_noise.rotation_rad);
  addLines(rest, "Fit", "{}, RMS {:.3f} px; {} of {} images with a robot pose used",
           onlyCamera(result.fit).model, rms(result.fit), numUsed(result), result.frames.size());
  for (std::size_t b = 0; b < result.world_from_boards.size(); ++b) {
    const Eigen::Vector3d at = kMmInMetre * result.world_from_boards[b].translation;
    addLines(rest, b == 0 ? "Board" : "", "{} at ({:.1f}, {:.1f}, {:.1f}) mm in the frame of the {}",
             result.fit.boards[b].target.spec(), at.x(), at.y(), at.z(), worldName(result.camera_on));
  }
  if (result.next_pose) {
    addLines(rest, "Next",
             "drive the gripper to {} (x, y, z in m, qx, qy, qz, qw) and take an image: within {} then",
             poseRow(result.next_pose->base_from_gripper), millimetres(result.next_pose->error_m));
  }
  const std::size_t room = kMaxLines - std::min(kMaxLines, lines.size() + rest.size() + 1);
  const Lines more =
      addDiagnoses(lines, result.diagnoses, std::max<std::size_t>(room, 6),
                   [](const Diagnosis& diagnosis, std::size_t) { return diagnosisLines(diagnosis); });
  lines.insert(lines.end(), rest.begin(), rest.end());
  lines.insert(lines.end(), more.begin(), more.end());
  return join(lines, "\n") + "\n";
}

std::string detailsText(const HandEyeCalibration& result) {
  std::string text =
      "\nImages: robot's deviation in mm and degrees, in its standard deviations; RMS of the corners in px\n";
  for (const HandEyeFrame& frame : result.frames) {
    text += "  " + printable(frame.image) + ": ";
    text += frame.reason.empty()
                ? fmt::format("{:.3f} mm, {:.3f} degrees, {:.1f}; {:.3f} px\n",
                              kMmInMetre * frame.deviation.head<3>().norm(),
                              kDegPerRad * frame.deviation.tail<3>().norm(), frame.sigmas, frame.rms_px)
                : frame.reason + "\n";
  }
  return text + diagnosesText(result.diagnoses);
}

std::string documentOf(const HandEyeCalibration& result) {
  if (!result.isSolved())
    return jsonText({{"verdict", verdictName(result.verdict())}, {"diagnoses", result.diagnoses}});
  json frames = json::array();
  for (const HandEyeFrame& frame : result.frames) {
    frames.push_back({{"image", frame.image},
                      {"used", frame.reason.empty()},
                      {"reason", frame.reason},
                      {"base_from_gripper", frame.base_from_gripper},
                      {"deviation_m", frame.deviation.head<3>().norm()},
                      {"deviation_rad", frame.deviation.tail<3>().norm()},
                      {"sigmas", frame.sigmas},
                      {"rms_px", frame.rms_px}});
  }
  json boards = json::array();
  for (std::size_t b = 0; b < result.world_from_boards.size(); ++b) {
    boards.emplace_back(result.world_from_boards[b]);
    boards.back()["board"] = result.fit.boards[b].target.spec();
  }
  json next = nullptr;
  if (result.next_pose)
    next = {{"base_from_gripper", result.next_pose->base_from_gripper},
            {"error_m", result.next_pose->error_m}};
  return jsonText({{"verdict", verdictName(result.verdict())},
                   {"next_pose", next},
                   {"camera_on", cameraOnName(result.camera_on)},
                   {std::string(mountName(result.camera_on)) + "_from_camera", result.mount_from_camera},
                   {std::string(worldName(result.camera_on)) + "_from_board", boards},
                   {"error_m", result.error_m},
                   {"tool_error_m", result.tool_error_m},
                   {"board_distance_m", result.board_distance_m},
                   {"robot_noise",
                    {{"rotation_rad", result.robot_noise.rotation_rad},
                     {"translation_m", result.robot_noise.translation_m}}},
                   {"rms_px", rms(result.fit)},
                   {"num_poses", numUsed(result)},
                   {"frames", frames},
                   {"diagnoses", result.diagnoses}});
}

class HandEyeCalibrateCommand final : public Command {
 public:
  void setUp(Flags& flags) override {
    flags.explain(std::string("Example: alidade handeye calibrate photos/ --poses poses.csv --board "
                              "checkerboard:9x6:25mm -o handeye.yaml\n") +
                  kPosesHelp +
                  "\nExit code 3: done, but the transform must not be used; no file is written.");
    flags.add(
        "input", &inputs_.views.inputs,
        "Folders, image files, patterns (*.jpg, frame%04d.png) or videos; or corners files of one camera",
        kFilePath);
    inputs_.addOptions(flags);
    flags.under(kOutputGroup);
    flags.add("-o,--output", &output_,
              "Hand-eye file to write (YAML); - for standard output instead of the summary", kFilePath);
    flags.add(
        "--to", &format_, "Format of the file: alidade, ros (static transform), urdf (fixed joint) or opencv",
        oneOf(mapped(handEyeFormats(), [](const HandEyeFormat& format) { return std::string(format.id); })));
    addDateFlag(flags, date_);
    flags.addSwitch("--verbose", is_verbose_, "Print each image and all details after the summary");
    flags.addSwitch("--keep-untrustworthy", keep_, "Write the file even if the transform must not be used");
    flags.addCommon(common_, true);
  }

  int run(const Flags&) override {
    checkUsage();
    common_.cancel = catchInterrupts();
    const HandEyeCalibration result = inputs_.calibrate(common_);
    const bool is_kept = result.isUsable() || (keep_ && result.isSolved());
    HandEyeRecord record = recordOf(result, programName());
    record.date = dateText(date_);
    record.camera_name = inputs_.camera;
    const bool is_on_stdout = output_ == "-" && !common_.json;
    if (is_kept && is_on_stdout) printResult(handEyeText(record, format_));
    if (is_kept && !output_.empty() && output_ != "-")
      writeFileAtomically(output_, handEyeText(record, format_));
    const bool is_coloured = isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr;
    const auto summary = [&] {
      return summaryText(result, is_coloured) + (is_verbose_ && result.isSolved() ? detailsText(result) : "");
    };
    if (!is_on_stdout)
      answer([&] { return documentOf(result); }, summary);
    else if (!common_.quiet)
      printHelp(summary());
    if (!result.isUsable()) {
      printRefusal("the transform must not be used: " + result.diagnoses.front().message(),
                   result.isSolved() ? output_ : "", is_kept);
      return kUntrustworthyExit;
    }
    if (!common_.quiet && output_ != "-")
      printMessage(output_.empty() ? "no file written (give -o handeye.yaml)" : "written to " + output_);
    return 0;
  }

 private:
  void checkUsage() const {
    if (inputs_.views.inputs.empty()) throw missing("no input", "folders, images or a corners file");
    if (inputs_.poses.empty())
      throw missing("no --poses", "a file with the robot's pose for each image: --poses poses.csv");
    std::vector<std::string> sources = inputs_.sources();
    sources.push_back(common_.config);
    checkOutputs(std::vector<Output>{{"--output", output_}}, sources, common_);
  }

  HandEyeInputs inputs_;
  std::string output_;
  std::string format_ = "alidade";
  std::string date_;
  bool is_verbose_ = false;
  bool keep_ = false;
};

}  // namespace

const CommandEntry kHandEyeCalibrateCommand = {"handeye calibrate",
                                               "Find where a camera is on a robot's hand, or beside a robot",
                                               made<HandEyeCalibrateCommand>};

}  // namespace alidade
