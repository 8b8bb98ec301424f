// SPDX-License-Identifier: MIT
#include "rig.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>
#include <nlohmann/json.hpp>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/files/rig_file.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/report/data/evidence.h"
#include "alidade/report/data/json_output.h"
#include "alidade/report/pages/page.h"
#include "alidade/rig/rig_calibrator.h"
#include "bindings.h"
#include "calibration.h"
#include "camera.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

RigValue calibratedRig(const py::dict& views, const py::object& board, const py::kwargs& given) {
  Keywords keywords("calibrate_rig", given);
  RigOptions options{.camera = calibratorOptions(keywords)};
  const auto progress = keywords.take<py::object>("progress", py::none());
  const ViewsArguments arguments = viewsArguments(keywords);
  keywords.finish();
  options.camera.jobs = arguments.search.jobs;
  if (views.size() < 2) {
    throw usageError({.where = "calibrate_rig()",
                      .found = std::to_string(views.size()) + " cameras",
                      .expected = "two or more, by name: {'left': ..., 'right': ...}"});
  }
  std::vector<Board> boards;
  std::vector<RigViews> cameras;
  for (const auto& [name, of_camera] : views) {
    ViewsValue value =
        gatheredViews(py::reinterpret_borrow<py::object>(of_camera), board, arguments, progress);
    if (cameras.empty()) boards = value.boards;
    cameras.push_back(
        {.name = pathOf(name), .views = std::move(value.views), .images = std::move(value.images)});
    if (boards == value.boards) continue;
    throw inputError({.where = cameras.back().name,
                      .found = "other boards than of " + cameras.front().name,
                      .expected = "the same boards for all cameras, in the same order"});
  }
  RigValue value{.result = {}, .record = {}, .tolerance_px = options.camera.tolerance_px};
  runInterruptibly(progress, [&](const CancelFlag* cancel, const ReportProgress& report) {
    report("calibrating", 0, 1);
    options.camera.cancel = cancel;
    value.result = calibrate(boards, std::move(cameras), options);
    value.record = recordOf(value.result, creatorName());
    report("calibrating", 1, 1);
  });
  return value;
}

// The cameras as load_cameras() reads them from the rig's file.
std::vector<CameraValue> camerasOf(const RigValue& self) {
  std::vector<CameraValue> cameras;
  for (const RigCameraRecord& camera : self.record.cameras)
    cameras.push_back({.record = camera.camera, .camera_from_rig = camera.camera_from_rig});
  return cameras;
}

nlohmann::json evidenceOf(const RigValue& self) {
  return rigEvidenceDocument(self.result, self.tolerance_px, {.created_by = creatorName()});
}

void saveRigOf(const RigValue& self, const py::object& path, bool keep_untrustworthy) {
  const std::string file = pathOf(path);
  requireUsable(self.result.diagnoses, file, keep_untrustworthy);
  const py::gil_scoped_release without_lock;
  saveRig(file, self.record);
}

void writeRigReport(const RigValue& self, const py::object& path) {
  const std::string file = pathOf(path);
  const py::gil_scoped_release without_lock;
  writeFileAtomically(file, reportPage(evidenceOf(self), "the evidence"));
}

std::string rigTitle(const RigValue& self) {
  return std::to_string(self.result.cameras.size()) + " cameras, " +
         std::string(verdictName(self.result.verdict())) + ", RMS " +
         numberText("%.3f", rms(self.result.fit)) + " px, " + std::to_string(self.record.num_frames) +
         " frames";
}

py::str rigHtml(const RigValue& self) {
  const auto figures = reportFigures(evidenceOf(self), "the evidence");
  return resultHtml(rigTitle(self), self.result.diagnoses, figures,
                    {{"scene.svg", "The cameras and the boards"}});
}

}  // namespace

void bindRig(py::module_& module) {
  py::class_<RigValue, std::shared_ptr<RigValue>>(module, "RigCalibration", doc("RigCalibration"))
      .def_property_readonly("cameras", &camerasOf, doc("RigCalibration.cameras"))
      .def_property_readonly(
          "verdict", [](const RigValue& self) { return std::string(verdictName(self.result.verdict())); },
          doc("RigCalibration.verdict"))
      .def_property_readonly(
          "is_usable", [](const RigValue& self) { return self.result.isUsable(); },
          doc("RigCalibration.is_usable"))
      .def_property_readonly(
          "rms_px", [](const RigValue& self) { return rms(self.result.fit); }, doc("RigCalibration.rms_px"))
      .def_property_readonly(
          "holdout_rms_px", [](const RigValue& self) { return self.result.holdout.rms_px; },
          doc("RigCalibration.holdout_rms_px"))
      .def_property_readonly(
          "findings",
          [](const RigValue& self) { return findingsFrom(self.result.diagnoses, Severity::kPass); },
          doc("RigCalibration.findings"))
      .def_property_readonly(
          "warnings",
          [](const RigValue& self) { return findingsFrom(self.result.diagnoses, Severity::kWarning); },
          doc("RigCalibration.warnings"))
      .def_property_readonly(
          "evidence",
          [](const RigValue& self) {
            return py::module_::import("json").attr("loads")(jsonText(evidenceOf(self)));
          },
          doc("RigCalibration.evidence"))
      .def("save", &saveRigOf, "path"_a, py::kw_only(), "keep_untrustworthy"_a = false,
           doc("RigCalibration.save"))
      .def("report", &writeRigReport, "path"_a, doc("RigCalibration.report"))
      .def("__repr__",
           [](const RigValue& self) { return "<alidade.RigCalibration: " + rigTitle(self) + ">"; })
      .def("_repr_html_", &rigHtml);
  module.def(
      "calibrate_rig",
      [](const py::dict& views, const py::object& board, const py::kwargs& options) {
        return std::make_shared<RigValue>(calibratedRig(views, board, options));
      },
      "views"_a, "board"_a = py::none(), doc("calibrate_rig"));
}

}  // namespace alidade::python
