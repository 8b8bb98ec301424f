// SPDX-License-Identifier: MIT
#include "alidade/handeye/hand_eye.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/files/hand_eye_file.h"
#include "alidade/files/robot_table.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/target/board_spec.h"
#include "bindings.h"
#include "calibration.h"
#include "camera.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

struct HandEyeValue {
  HandEyeRecord record = {};
};
struct HandEyeResult : HandEyeValue {
  HandEyeCalibration calibration = {};
};

RobotPose robotPoseOf(const py::handle& name, const py::handle& matrix) {
  const std::string image = pathOf(py::isinstance<py::int_>(name) ? py::handle(py::str(name)) : name);
  constexpr double kMaxError = 0.01;  // as of tables: pendants show few digits
  if (const auto pose = poseOf(matrix, "pose of " + image, kMaxError)) return {image, *pose};
  throw usageError({.where = "pose of " + image, .found = "None", .expected = "a 4x4 matrix"});
}

// A table's path, a dict, or a sequence of (name, matrix).
RobotTable robotTableOf(const py::object& poses, const std::string& form) {
  if (py::isinstance<py::str>(poses) || py::isinstance<py::bytes>(poses) || py::hasattr(poses, "__fspath__"))
    return readRobotTable(pathOf(poses), {.form = form});
  if (!form.empty())
    throw usageError(
        {.where = "pose_form", .found = "'" + form + "'", .expected = "nothing beside matrices"});
  const py::object items = py::hasattr(poses, "items") ? poses.attr("items")() : poses;
  RobotTable table;
  try {
    if (!py::isinstance<py::iterable>(items)) throw py::cast_error();
    for (const py::handle item : items) {
      const auto [name, matrix] = item.cast<std::pair<py::object, py::object>>();
      table.poses.push_back(robotPoseOf(name, matrix));
    }
  } catch (const py::cast_error&) {
    throw usageError({.where = "poses",
                      .found = "other items",
                      .expected = "a file's path, {name: matrix}, or a list of (name, matrix)"});
  }
  return table;
}

HandEyeOptions handEyeOptions(Keywords& keywords, std::string& camera_name) {
  HandEyeOptions options{.tolerance_m =
                             parseLength(keywords.take<std::string>("tolerance", "1mm"), "tolerance")};
  if (!(options.tolerance_m > 0))
    throw usageError({.where = "tolerance",
                      .found = numberText("%g", options.tolerance_m) + " m",
                      .expected = "a length above 0, such as '1mm'"});
  if (const auto on = keywords.take<std::optional<std::string>>("camera_on", std::nullopt)) {
    if (*on != "hand" && *on != "base")
      throw usageError(
          {.where = "camera_on", .found = "'" + *on + "'", .expected = "'hand', 'base' or None"});
    options.camera_on = *on == "hand" ? CameraOn::kHand : CameraOn::kBase;
  }
  const auto model = keywords.take<std::optional<std::string>>("model", std::nullopt);
  if (model) options.camera.model = *model;
  const auto camera = keywords.take<py::object>("camera", py::none());
  if (camera.is_none()) return options;
  if (model)
    throw usageError(
        {.where = "model", .found = "a model beside camera, whose lens is kept", .expected = "one of them"});
  if (!py::isinstance<CameraValue>(camera))
    throw usageError({.where = "camera",
                      .found = py::repr(camera).cast<std::string>(),
                      .expected = "a Camera, see load_camera()"});
  const CameraRecord& record = camera.cast<const CameraValue&>().record;
  keepLens(record, options.camera);
  camera_name = record.name.name;
  return options;
}

HandEyeResult calibratedHandEye(const py::object& views, const py::object& poses, const py::object& board,
                                const py::kwargs& given) {
  Keywords keywords("calibrate_hand_eye", given);
  HandEyeResult value;
  std::string camera_name;
  HandEyeOptions options = handEyeOptions(keywords, camera_name);
  const auto form = keywords.take<std::string>("pose_form", "");
  const auto progress = keywords.take<py::object>("progress", py::none());
  const ViewsArguments arguments = viewsArguments(keywords);
  keywords.finish();
  options.camera.jobs = arguments.search.jobs;
  const RobotTable robot = robotTableOf(poses, form);
  ViewsValue from = gatheredViews(views, board, arguments, progress);
  runInterruptibly(progress, [&](const CancelFlag* cancel, const ReportProgress& report) {
    report("calibrating", 0, 1);
    options.camera.cancel = cancel;
    value.calibration = calibrateHandEye(from.boards, std::move(from.views), robot, options);
    value.record = recordOf(value.calibration, creatorName());
    value.record.camera_name = camera_name;
    report("calibrating", 1, 1);
  });
  return value;
}

HandEyeValue loadHandEye(const py::object& path) {
  const std::string file = pathOf(path);
  const py::gil_scoped_release without_lock;
  return {readHandEye(file)};
}

void saveHandEye(const HandEyeValue& self, const py::object& path, const std::string& format) {
  const std::string file = pathOf(path);
  const py::gil_scoped_release without_lock;
  writeFileAtomically(file, handEyeText(self.record, format));
}

std::string titleOf(const HandEyeRecord& record) {
  return "camera on the " + std::string(cameraOnName(record.camera_on)) + ", " +
         std::string(verdictName(record.verdict)) + ", within " + numberText("%.3g", 1000 * record.error_m) +
         " mm, " + std::to_string(record.num_poses) + " poses";
}

void bindRecord(py::module_& module) {
  py::class_<HandEyeValue, std::shared_ptr<HandEyeValue>>(module, "HandEye", doc("HandEye"))
      .def_property_readonly(
          "camera_on", [](const HandEyeValue& self) { return cameraOnName(self.record.camera_on); },
          doc("HandEye.camera_on"))
      .def_property_readonly(
          "mount_from_camera",
          [](const HandEyeValue& self) { return poseArray(self.record.mount_from_camera); },
          doc("HandEye.mount_from_camera"))
      .def_property_readonly(
          "covariance",
          [](const HandEyeValue& self) -> py::object {
            if (self.record.covariance.isZero(0)) return py::none();
            return matrixArray(self.record.covariance);
          },
          doc("HandEye.covariance"))
      .def_property_readonly(
          "world_from_boards",
          [](const HandEyeValue& self) { return mapped(self.record.world_from_boards, poseArray); },
          doc("HandEye.world_from_boards"))
      .def_property_readonly(
          "boards", [](const HandEyeValue& self) { return self.record.boards; }, doc("HandEye.boards"))
      .def_property_readonly(
          "robot_noise",
          [](const HandEyeValue& self) {
            const RobotNoise& noise = self.record.robot_noise;
            return py::dict("rotation_rad"_a = noise.rotation_rad, "translation_m"_a = noise.translation_m);
          },
          doc("HandEye.robot_noise"))
      .def_property_readonly(
          "num_poses", [](const HandEyeValue& self) { return self.record.num_poses; },
          doc("HandEye.num_poses"))
      .def_property_readonly(
          "error_m", [](const HandEyeValue& self) { return self.record.error_m; }, doc("HandEye.error_m"))
      .def_property_readonly(
          "rms_px", [](const HandEyeValue& self) { return self.record.rms_px; }, doc("HandEye.rms_px"))
      .def_property_readonly(
          "verdict", [](const HandEyeValue& self) { return std::string(verdictName(self.record.verdict)); },
          doc("HandEye.verdict"))
      .def_property_readonly(
          "finding_ids", [](const HandEyeValue& self) { return self.record.findings; },
          doc("HandEye.finding_ids"))
      .def("save", &saveHandEye, "path"_a, "format"_a = "alidade", doc("HandEye.save"))
      .def("__repr__",
           [](const HandEyeValue& self) { return "<alidade.HandEye: " + titleOf(self.record) + ">"; });
}

void bindFrame(py::module_& module) {
  py::class_<HandEyeFrame>(module, "HandEyeFrame", doc("HandEyeFrame"))
      .def_property_readonly(
          "image", [](const HandEyeFrame& self) { return nameText(self.image); }, doc("HandEyeFrame.image"))
      .def_property_readonly(
          "base_from_gripper", [](const HandEyeFrame& self) { return poseArray(self.base_from_gripper); },
          doc("HandEyeFrame.base_from_gripper"))
      .def_property_readonly(
          "deviation",
          [](const HandEyeFrame& self) {
            return vectorArray({self.deviation.data(), self.deviation.data() + self.deviation.size()});
          },
          doc("HandEyeFrame.deviation"))
      .def_readonly("sigmas", &HandEyeFrame::sigmas, doc("HandEyeFrame.sigmas"))
      .def_readonly("rms_px", &HandEyeFrame::rms_px, doc("HandEyeFrame.rms_px"))
      .def_property_readonly(
          "reason", [](const HandEyeFrame& self) { return nameText(self.reason); },
          doc("HandEyeFrame.reason"))
      .def("__repr__", [](const HandEyeFrame& self) {
        const std::string state = self.reason.empty() ? numberText("%.2g sigmas", self.sigmas) : self.reason;
        return nameText("<alidade.HandEyeFrame: " + self.image + ", " + state + ">");
      });
}

}  // namespace

void bindHandEye(py::module_& module) {
  bindRecord(module);
  bindFrame(module);
  py::class_<HandEyeResult, HandEyeValue, std::shared_ptr<HandEyeResult>>(module, "HandEyeCalibration",
                                                                          doc("HandEyeCalibration"))
      .def_property_readonly(
          "is_usable", [](const HandEyeResult& self) { return self.calibration.isUsable(); },
          doc("HandEyeCalibration.is_usable"))
      .def_property_readonly(
          "findings",
          [](const HandEyeResult& self) { return findingsFrom(self.calibration.diagnoses, Severity::kPass); },
          doc("HandEyeCalibration.findings"))
      .def_property_readonly(
          "warnings",
          [](const HandEyeResult& self) {
            return findingsFrom(self.calibration.diagnoses, Severity::kWarning);
          },
          doc("HandEyeCalibration.warnings"))
      .def_property_readonly(
          "frames", [](const HandEyeResult& self) { return self.calibration.frames; },
          doc("HandEyeCalibration.frames"))
      .def(
          "save",
          [](const HandEyeResult& self, const py::object& path, const std::string& format, bool keep) {
            requireUsable(self.calibration.diagnoses, pathOf(path), keep);
            saveHandEye(self, path, format);
          },
          "path"_a, "format"_a = "alidade", py::kw_only(), "keep_untrustworthy"_a = false,
          doc("HandEyeCalibration.save"))
      .def("__repr__", [](const HandEyeResult& self) {
        return "<alidade.HandEyeCalibration: " + titleOf(self.record) + ">";
      });
  module.def(
      "calibrate_hand_eye",
      [](const py::object& views, const py::object& poses, const py::object& board,
         const py::kwargs& options) {
        return std::make_shared<HandEyeResult>(calibratedHandEye(views, poses, board, options));
      },
      "views"_a, "poses"_a, "board"_a = py::none(), doc("calibrate_hand_eye"));
  module.def("load_hand_eye", &loadHandEye, "path"_a, doc("load_hand_eye"));
}

}  // namespace alidade::python
