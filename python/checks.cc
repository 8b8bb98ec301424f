// SPDX-License-Identifier: MIT
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "alidade/calibrate/calibrator.h"
#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/files/camera_source.h"
#include "alidade/validate/file_tests.h"
#include "bindings.h"
#include "calibration.h"
#include "camera.h"
#include "difference.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

// One check of one camera of a file.
struct CheckResult {
  std::string camera;  // its name in the file; empty for a check of the rig
  FileCheck check;
};

// A judged file, and the camera it was compared with.
struct FileValue {
  FileJudgement judgement;
  std::shared_ptr<const CameraRecord> other;
};

std::vector<CheckResult> checksOf(const FileValue& self) {
  const FileJudgement& judgement = self.judgement;
  std::vector<CheckResult> checks;
  for (const CameraJudgement& camera : judgement.cameras) {
    for (const FileCheck& check : camera.checks) checks.push_back({camera.name, check});
  }
  for (const FileCheck& check : judgement.rig_checks) checks.push_back({"", check});
  return checks;
}

std::vector<FileValue> validate(const py::object& path, const py::object& images, const py::object& board,
                                const py::object& against, double tolerance_px, int jobs,
                                const py::object& progress) {
  FileTests tests{.tolerance_px = tolerance_px, .jobs = jobs};
  if (!(tolerance_px > 0))
    throw usageError(
        {.where = "tolerance_px", .found = numberText("%g", tolerance_px), .expected = "a number above 0"});
  if (!images.is_none()) {
    ViewsArguments arguments;
    arguments.search.jobs = jobs;
    ViewsValue value = gatheredViews(images, board, arguments, progress);
    if (value.views.empty()) {
      throw inputError({.where = "images",
                        .found = "no image with a board",
                        .expected = "images of " + value.boards.front().spec(),
                        .next_step = value.given.reasons.empty() ? "" : value.given.reasons.front()});
    }
    tests.boards = std::move(value.boards);
    tests.views = std::move(value.views);
  } else if (!board.is_none()) {
    throw usageError(
        {.where = "validate()", .found = "board without images", .expected = "images of the board"});
  }
  if (py::isinstance<CameraValue>(against)) {
    tests.other = against.cast<const CameraValue&>().record;
  } else if (!against.is_none()) {
    tests.other = loadCamera(pathOf(against));
  }
  const std::vector<std::string> inputs = {pathOf(path)};
  std::vector<FileValue> judgements;
  const auto other = tests.other ? std::make_shared<const CameraRecord>(*tests.other) : nullptr;
  runInterruptibly(progress, [&](const CancelFlag* cancel, const ReportProgress& report) {
    tests.cancel = cancel;
    const std::vector<ListedFile> files = listCameraFiles(inputs);
    for (std::size_t i = 0; i < files.size(); ++i) {
      throwIfCancelled(cancel);
      if (auto judgement = judgeFile(files[i], {}, tests))
        judgements.push_back({*std::move(judgement), other});
      report("checking files", i + 1, files.size());
    }
  });
  return judgements;
}

// The difference maps of a judged camera: against the other camera, and against the one calibrated from the
// images.
void addMaps(const FileValue& self, const CameraJudgement& judged, std::vector<FigureFile>& figures,
             std::vector<CaptionedFigure>& shown) {
  if (!judged.camera || !judged.image_size) return;
  CameraRecord record = bareRecord(*judged.camera, *judged.image_size, creatorName());
  record.calibration = judged.calibration;
  const auto add = [&](const CameraRecord& other, const std::string& caption) {
    std::optional<DifferenceValue> value;
    try {
      value = tryDifference(record, other, {});
    } catch (const Error&) {
      return;  // different aspect ratio; a check reports it
    }
    if (!value) return;
    const std::string name = std::to_string(figures.size()) + ".svg";
    figures.push_back(figureOf(*value, name));
    shown.push_back({name, (judged.name.empty() ? "" : judged.name + ": ") + caption});
  };
  if (self.other) add(*self.other, "where the other camera projects points");
  if (judged.held_out && judged.held_out->freed)
    add(recordOf(*judged.held_out->freed, creatorName()), "where the camera of the images projects points");
}

py::str validationHtml(const FileValue& self) {
  std::vector<FigureFile> figures;
  std::vector<CaptionedFigure> shown;
  {
    const py::gil_scoped_release without_lock;
    for (const CameraJudgement& judged : self.judgement.cameras) addMaps(self, judged, figures, shown);
  }
  const py::object escape = py::module_::import("html").attr("escape");
  const auto cell = [&](const std::string& text) {
    return "<td style=\"text-align: left\">" + escape(nameText(text)).cast<std::string>() + "</td>";
  };
  std::string table;
  for (const CheckResult& result : checksOf(self)) {
    table += "<tr>" + cell(std::string(severityName(result.check.severity))) + cell(result.camera) +
             cell(std::string(result.check.id)) + cell(result.check.message) + "</tr>";
  }
  if (!table.empty())
    table =
        "<table><tr><th>result</th><th>camera</th><th>check</th><th>message</th></tr>" + table + "</table>";
  std::string title = self.judgement.file + ": " + std::string(severityName(self.judgement.severity()));
  if (!self.judgement.error.empty()) title = self.judgement.error;
  return py::str(resultHtml(title, {}, {}, {}).cast<std::string>() + table +
                 resultHtml("", {}, figures, shown).cast<std::string>());
}

}  // namespace

void bindChecks(py::module_& module) {
  const auto status = [](Severity severity) { return std::string(severityName(severity)); };
  py::class_<CheckResult>(module, "Check", doc("Check"))
      .def_readonly("camera", &CheckResult::camera, doc("Check.camera"))
      .def_property_readonly(
          "id", [](const CheckResult& self) { return std::string(self.check.id); }, doc("Check.id"))
      .def_property_readonly(
          "severity", [=](const CheckResult& self) { return status(self.check.severity); },
          doc("Check.severity"))
      .def_property_readonly(
          "message", [](const CheckResult& self) { return self.check.message; }, doc("Check.message"))
      .def_property_readonly(
          "values",
          [](const CheckResult& self) {
            py::dict values;
            for (const auto& [name, value] : self.check.values) values[py::str(name)] = value;
            return values;
          },
          doc("Check.values"))
      .def("__repr__", [=](const CheckResult& self) {
        return "<alidade.Check: " + status(self.check.severity) + ", " + std::string(self.check.id) + ": " +
               self.check.message + ">";
      });
  py::class_<FileValue>(module, "FileValidation", doc("FileValidation"))
      .def_property_readonly(
          "file", [](const FileValue& self) { return nameText(self.judgement.file); },
          doc("FileValidation.file"))
      .def_property_readonly(
          "format", [](const FileValue& self) { return self.judgement.format; }, doc("FileValidation.format"))
      .def_property_readonly(
          "error", [](const FileValue& self) { return self.judgement.error; }, doc("FileValidation.error"))
      .def_property_readonly(
          "severity", [=](const FileValue& self) { return status(self.judgement.severity()); },
          doc("FileValidation.severity"))
      .def_property_readonly("checks", &checksOf, doc("FileValidation.checks"))
      .def("__bool__", [](const FileValue& self) { return self.judgement.severity() < Severity::kFailure; })
      .def("__repr__",
           [=](const FileValue& self) {
             return "<alidade.FileValidation: " + self.judgement.file + ": " +
                    status(self.judgement.severity()) + ">";
           })
      .def("_repr_html_", &validationHtml);
  module.def("validate", &validate, "path"_a, "images"_a = py::none(), "board"_a = py::none(), py::kw_only(),
             "against"_a = py::none(), "tolerance_px"_a = kDefaultTolerancePx, "jobs"_a = 0,
             "progress"_a = py::none(), doc("validate"));
}

}  // namespace alidade::python
