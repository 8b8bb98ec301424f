// SPDX-License-Identifier: MIT
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "alidade/compare/projection_difference.h"
#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/files/camera_source.h"
#include "alidade/validate/file_tests.h"
#include "bindings.h"
#include "calibration.h"
#include "camera.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

// One check of one camera of a file.
struct CheckResult {
  std::string camera;  // its name in the file; empty for a check of the rig
  FileCheck check;
};

std::vector<CheckResult> checksOf(const FileJudgement& judgement) {
  std::vector<CheckResult> checks;
  for (const CameraJudgement& camera : judgement.cameras) {
    for (const FileCheck& check : camera.checks) checks.push_back({camera.name, check});
  }
  for (const FileCheck& check : judgement.rig_checks) checks.push_back({"", check});
  return checks;
}

std::vector<FileJudgement> validate(const py::object& path, const py::object& images, const py::object& board,
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
  std::vector<FileJudgement> judgements;
  runInterruptibly(progress, [&](const CancelFlag* cancel, const ReportProgress& report) {
    tests.cancel = cancel;
    const std::vector<ListedFile> files = listCameraFiles(inputs);
    for (std::size_t i = 0; i < files.size(); ++i) {
      throwIfCancelled(cancel);
      if (auto judgement = judgeFile(files[i], {}, tests)) judgements.push_back(*std::move(judgement));
      report("checking files", i + 1, files.size());
    }
  });
  return judgements;
}

// What diff() returns.
struct DifferenceValue {
  ProjectionDifference difference;
  std::optional<DifferenceSignificance> significance;
};

CameraRecord recordFrom(const py::handle& camera) {
  if (py::isinstance<CameraValue>(camera)) return camera.cast<const CameraValue&>().record;
  return loadCamera(pathOf(camera));
}

DifferenceValue difference(const py::object& a, const py::object& b, const std::optional<double>& distance_m,
                           bool same_frame) {
  if (distance_m && same_frame)
    throw usageError({.where = "distance_m and same_frame", .found = "both", .expected = "one of them"});
  const CameraRecord record_a = recordFrom(a);
  const CameraRecord record_b = recordFrom(b);
  DifferenceOptions options;
  if (same_frame) options.freed.reset();
  if (distance_m) {
    options.freed = Freed::kPose;
    options.distance_m = *distance_m;
  }
  const py::gil_scoped_release without_lock;
  const ComparedCamera in_a{&record_a.camera, record_a.image_size, statedCovariance(record_a)};
  const ComparedCamera in_b{&record_b.camera, record_b.image_size, statedCovariance(record_b)};
  DifferenceValue value{.difference = projectionDifference(in_a, in_b, options), .significance = {}};
  if (!value.difference.is_converged || value.difference.num_compared == 0) {
    throw inputError({.where = "diff()",
                      .found = "cameras that have too little in common to be compared",
                      .expected = "two cameras of the same image",
                      .next_step = "check both with validate()"});
  }
  value.significance = significanceOf(value.difference, in_a, in_b, options.freed);
  return value;
}

py::object gridOf(const DifferenceValue& self, const std::vector<Eigen::Vector2d>& values) {
  return pixelsArray(values).attr("reshape")(self.difference.rows, self.difference.columns, 2);
}

void bindChecksOfFiles(py::module_& module) {
  const auto status = [](Severity severity) { return std::string(severityName(severity)); };
  py::class_<CheckResult>(module, "Check", doc("Check"))
      .def_readonly("camera", &CheckResult::camera, doc("Check.camera"))
      .def_property_readonly(
          "id", [](const CheckResult& self) { return self.check.id; }, doc("Check.id"))
      .def_property_readonly(
          "severity", [=](const CheckResult& self) { return status(self.check.severity); },
          doc("Check.severity"))
      .def_property_readonly(
          "message", [](const CheckResult& self) { return self.check.message; }, doc("Check.message"))
      .def_property_readonly(
          "values",
          [](const CheckResult& self) {
            py::dict values;
            for (const CheckValue& value : self.check.values) values[py::str(value.name)] = value.value;
            return values;
          },
          doc("Check.values"))
      .def("__repr__", [=](const CheckResult& self) {
        return "<alidade.Check: " + status(self.check.severity) + ", " + self.check.id + ": " +
               self.check.message + ">";
      });
  py::class_<FileJudgement>(module, "FileValidation", doc("FileValidation"))
      .def_property_readonly(
          "file", [](const FileJudgement& self) { return nameText(self.file); }, doc("FileValidation.file"))
      .def_readonly("format", &FileJudgement::format, doc("FileValidation.format"))
      .def_readonly("error", &FileJudgement::error, doc("FileValidation.error"))
      .def_property_readonly(
          "severity", [=](const FileJudgement& self) { return status(self.severity()); },
          doc("FileValidation.severity"))
      .def_property_readonly("checks", &checksOf, doc("FileValidation.checks"))
      .def("__bool__", [](const FileJudgement& self) { return self.severity() < Severity::kFailure; })
      .def("__repr__", [=](const FileJudgement& self) {
        return "<alidade.FileValidation: " + self.file + ": " + status(self.severity()) + ">";
      });
  module.def("validate", &validate, "path"_a, "images"_a = py::none(), "board"_a = py::none(), py::kw_only(),
             "against"_a = py::none(), "tolerance_px"_a = kDefaultTolerancePx, "jobs"_a = 0,
             "progress"_a = py::none(), doc("validate"));
}

void bindDifference(py::module_& module) {
  py::class_<DifferenceValue>(module, "Difference", doc("Difference"))
      .def_property_readonly(
          "pixels", [](const DifferenceValue& self) { return gridOf(self, self.difference.pixels); },
          doc("Difference.pixels"))
      .def_property_readonly(
          "difference_px",
          [](const DifferenceValue& self) { return gridOf(self, self.difference.difference_px); },
          doc("Difference.difference_px"))
      .def_property_readonly(
          "mean_px", [](const DifferenceValue& self) { return self.difference.mean_px; },
          doc("Difference.mean_px"))
      .def_property_readonly(
          "rms_px", [](const DifferenceValue& self) { return self.difference.rms_px; },
          doc("Difference.rms_px"))
      .def_property_readonly(
          "p95_px", [](const DifferenceValue& self) { return self.difference.p95_px; },
          doc("Difference.p95_px"))
      .def_property_readonly(
          "max_px", [](const DifferenceValue& self) { return self.difference.max_px; },
          doc("Difference.max_px"))
      .def_property_readonly(
          "num_compared", [](const DifferenceValue& self) { return self.difference.num_compared; },
          doc("Difference.num_compared"))
      .def_property_readonly(
          "b_from_a", [](const DifferenceValue& self) { return poseArray(self.difference.b_from_a); },
          doc("Difference.b_from_a"))
      .def_property_readonly(
          "is_significant",
          [](const DifferenceValue& self) -> std::optional<bool> {
            if (!self.significance) return std::nullopt;
            return self.significance->isSignificant();
          },
          doc("Difference.is_significant"))
      .def("__repr__", [](const DifferenceValue& self) {
        return "<alidade.Difference: RMS " + numberText("%.4g", self.difference.rms_px) +
               " px, 95 % within " + numberText("%.4g", self.difference.p95_px) + " px, at most " +
               numberText("%.4g", self.difference.max_px) + " px>";
      });
  module.def("diff", &difference, "a"_a, "b"_a, py::kw_only(), "distance_m"_a = py::none(),
             "same_frame"_a = false, doc("diff"));
}

}  // namespace

void bindChecks(py::module_& module) {
  bindChecksOfFiles(module);
  bindDifference(module);
}

}  // namespace alidade::python
