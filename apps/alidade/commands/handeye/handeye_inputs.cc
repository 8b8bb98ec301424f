// SPDX-License-Identifier: MIT
#include "commands/handeye/handeye_inputs.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "alidade/camera/model_traits.h"
#include "alidade/files/robot_table.h"
#include "alidade/target/board_spec.h"
#include "camera_files.h"
#include "command.h"
#include "outputs.h"
#include "summary_lines.h"

namespace alidade {

const char* const kPosesHelp =
    "poses.csv: where the robot says that its gripper is, in the frame of its base, for each image "
    "(image,x_m,y_m,z_m,qx,qy,qz,qw; docs/handeye.md).";

void HandEyeInputs::addOptions(Flags& flags) {
  views.addBoards(flags);
  views.addDetection(flags, false);
  flags.under(kBoardGroup);
  views.addMirrored(flags);
  flags.under(kFitGroup);
  flags.add("--poses", &poses, "File with the robot's poses, base_from_gripper, one per image", kFilePath);
  flags.add(
      "--pose-form", &form,
      "What the numbers of rows without a header mean: kuka, abb, ur, fanuc, staubli, franka, or a form "
      "as of alidade pose, such as quaternion_wxyz");
  flags.add("--camera-on", &camera_on,
            "hand: the robot moves the camera; base: the camera stands, and the robot moves the board. "
            "Default: found",
            oneOf({"hand", "base"}));
  flags.add("--camera", &camera,
            "Camera file of the camera, whose lens is kept. Default: calibrated in the same fit", kFilePath);
  std::vector<std::string> models = modelIds();
  models.emplace_back(kAutoModel);
  flags.add("--model", &model, "Camera model as for alidade calibrate", oneOf(models, 0, aliasedModels()));
  flags.under(kVerdictGroup);
  flags.add("--tolerance", &tolerance,
            "Error of a point at the board's distance that you accept (95 %), such as 1mm");
}

std::vector<std::string> HandEyeInputs::sources() const {
  std::vector<std::string> all =
      isCornersFile(views.inputs.front()) ? views.inputs : withImages(views.inputs);
  std::ranges::copy(views.boards, std::back_inserter(all));
  all.push_back(poses);
  all.push_back(cameraFilePath(camera));
  return all;
}

HandEyeCalibration HandEyeInputs::calibrate(const CommonOptions& common) const {
  HandEyeOptions options;
  options.tolerance_m = toleranceM();
  if (!camera_on.empty()) options.camera_on = camera_on == "hand" ? CameraOn::kHand : CameraOn::kBase;
  options.camera.jobs = common.jobs;
  options.camera.cancel = common.cancel;
  if (!model.empty()) options.camera.model = model;
  if (!camera.empty()) {
    if (!model.empty())
      throw flagError("--model", model + " beside --camera, whose lens is kept", "one of the two flags");
    keepLens(readCameraTelling(camera, {}, common.quiet), options.camera);
  }
  const RobotTable robot = readRobotTable(poses, {.form = form});
  const GivenViews given = readViews(views, common);
  options.images = given.images;
  return calibrateHandEye(given.boards, given.views, robot, options);
}

double HandEyeInputs::toleranceM() const {
  const double value_m = parseLength(tolerance, "--tolerance");
  if (value_m > 0 && tolerance.ends_with('m')) return value_m;
  throw flagError("--tolerance", tolerance, "a length above 0 with its unit, such as 1mm");
}

std::string millimetres(double value_m) {
  constexpr double kMmInMetre = 1000;
  return fmt::format("{:.{}f} mm", kMmInMetre * value_m, decimalsFor(kMmInMetre * value_m, 3));
}

}  // namespace alidade
