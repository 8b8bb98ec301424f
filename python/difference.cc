// SPDX-License-Identifier: MIT
#include "difference.h"

#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "alidade/compare/rig_difference.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/rig_file.h"
#include "alidade/report/figures/difference_svg.h"
#include "bindings.h"
#include "calibration.h"
#include "camera.h"
#include "rig.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

ComparedCamera comparedCamera(const CameraRecord& record) {
  return {&record.camera, record.image_size, statedCovariance(record)};
}

// "RMS 0.4 px, 95 % within 0.8 px, at most 1.2 px"
std::string lengthsText(const ProjectionDifference& difference) {
  return "RMS " + numberText("%.4g", difference.rms_px) + " px, 95 % within " +
         numberText("%.4g", difference.p95_px) + " px, at most " + numberText("%.4g", difference.max_px) +
         " px";
}

std::string significanceWord(const DifferenceValue& value) {
  if (!value.significance) return "neither camera states a covariance";
  return value.significance->isSignificant() ? "significant" : "not significant";
}

py::str differenceHtml(const DifferenceValue& self) {
  const std::string title = lengthsText(self.difference) + ": " + significanceWord(self);
  FigureFile figure;
  {
    const py::gil_scoped_release without_lock;
    figure = figureOf(self, "difference.svg");
  }
  return resultHtml(title, {}, {figure}, {{"difference.svg", "Where b projects points, compared with a"}});
}

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
  std::optional<DifferenceValue> value;
  {
    const py::gil_scoped_release without_lock;
    value = tryDifference(record_a, record_b, options);
  }
  if (!value) {
    throw inputError({.where = "diff()",
                      .found = "cameras that have too little in common to be compared",
                      .expected = "two cameras of the same image",
                      .next_step = "check both with validate()"});
  }
  return *std::move(value);
}

py::object gridOf(const DifferenceValue& self, const std::vector<Eigen::Vector2d>& values) {
  return pixelsArray(values).attr("reshape")(self.difference.rows, self.difference.columns, 2);
}

// Return value of diff_rigs().
struct RigDifferenceValue {
  std::vector<std::string> names;
  std::vector<DifferenceValue> lenses;
  RigDifference difference;
};

RigRecord rigFromPython(const py::handle& rig) {
  if (py::isinstance<RigValue>(rig)) return rig.cast<const RigValue&>().record;
  return loadRig(pathOf(rig));
}

RigDifferenceValue differenceOfRigs(const py::object& a, const py::object& b,
                                    const std::optional<double>& distance_m) {
  const RigRecord rig_a = rigFromPython(a);
  RigRecord rig_b = rigFromPython(b);
  if (distance_m && !(*distance_m > 0))
    throw usageError(
        {.where = "distance_m", .found = numberText("%g", *distance_m), .expected = "a number above 0"});
  const py::gil_scoped_release without_lock;
  RigDifferenceValue value;
  value.names = mapped(rig_a.cameras, [](const RigCameraRecord& c) { return c.camera.name.name; });
  const auto refuse = [&](const std::string& where, const std::string& found, const std::string& expected) {
    throw inputError({.where = "diff_rigs(), " + where, .found = found, .expected = expected});
  };
  if (!orderCamerasAs(rig_a, rig_b)) {
    const auto others = mapped(rig_b.cameras, [](const RigCameraRecord& c) { return c.camera.name.name; });
    refuse("b", "the cameras " + join(others, ", "), "those of a: " + join(value.names, ", "));
  }
  for (std::size_t i = 0; i < value.names.size(); ++i) {
    const CameraRecord& in_a = rig_a.cameras[i].camera;
    const CameraRecord& in_b = rig_b.cameras[i].camera;
    if (in_a.image_size != in_b.image_size)
      refuse(value.names[i], "images of " + sizeText(in_b.image_size) + " px", sizeText(in_a.image_size));
    auto lens = tryDifference(in_a, in_b, {});
    if (!lens) refuse(value.names[i], "lenses that have too little in common", "lenses of the same image");
    value.lenses.push_back(*std::move(lens));
  }
  value.difference =
      rigDifference(rig_a.cameras, rig_b.cameras, distance_m.value_or(usualDistance(rig_a.cameras)));
  return value;
}

// One entry per camera, by its name.
template <class ValueAt>
py::dict byCamera(const RigDifferenceValue& self, const ValueAt& valueAt) {
  py::dict values;
  for (std::size_t i = 0; i < self.names.size(); ++i) values[nameText(self.names[i])] = valueAt(i);
  return values;
}

py::dict transfersOf(const RigDifferenceValue& self) {
  return byCamera(self, [&](std::size_t i) -> py::object {
    const auto& transfer = self.difference.transfers[i];
    if (!transfer) return py::none();
    return py::dict("from_camera"_a = nameText(self.names[transfer->from]), "rms_px"_a = transfer->rms_px,
                    "p95_px"_a = transfer->p95_px, "max_px"_a = transfer->max_px,
                    "num_compared"_a = transfer->num_compared);
  });
}

py::dict placesOf(const RigDifferenceValue& self) {
  return byCamera(self, [&](std::size_t i) {
    const PlaceDifference& place = self.difference.places[i];
    return py::make_tuple(place.distance_m, place.angle_rad);
  });
}

void bindRigDifference(py::module_& module) {
  py::class_<RigDifferenceValue>(module, "RigDifference", doc("RigDifference"))
      .def_property_readonly(
          "distance_m", [](const RigDifferenceValue& self) { return self.difference.distance_m; },
          doc("RigDifference.distance_m"))
      .def_property_readonly(
          "lenses",
          [](const RigDifferenceValue& self) {
            return byCamera(self, [&](std::size_t i) { return py::cast(self.lenses[i]); });
          },
          doc("RigDifference.lenses"))
      .def_property_readonly("places", &placesOf, doc("RigDifference.places"))
      .def_property_readonly("transfers", &transfersOf, doc("RigDifference.transfers"))
      .def("__repr__", [](const RigDifferenceValue& self) {
        std::string text;
        for (std::size_t i = 0; i < self.names.size(); ++i) {
          const auto& transfer = self.difference.transfers[i];
          text +=
              (i > 0 ? ", " : "") + self.names[i] + " " +
              (transfer ? "95 % within " + numberText("%.3g", transfer->p95_px) + " px" : "not comparable");
        }
        return "<alidade.RigDifference: points at " + numberText("%.4g", self.difference.distance_m) +
               " m: " + text + ">";
      });
  module.def("diff_rigs", &differenceOfRigs, "a"_a, "b"_a, py::kw_only(), "distance_m"_a = py::none(),
             doc("diff_rigs"));
}

}  // namespace

std::optional<DifferenceValue> tryDifference(const CameraRecord& a, const CameraRecord& b,
                                             const DifferenceOptions& options) {
  const ComparedCamera in_a = comparedCamera(a);
  const ComparedCamera in_b = comparedCamera(b);
  DifferenceValue value{.a = a, .b = b, .difference = projectionDifference(in_a, in_b, options)};
  if (!value.difference.is_converged || value.difference.num_compared == 0) return std::nullopt;
  value.significance = significanceOf(value.difference, in_a, in_b, options.freed);
  return value;
}

FigureFile figureOf(const DifferenceValue& value, const std::string& name) {
  return {.name = name,
          .svg = differenceSvg(comparedCamera(value.a), comparedCamera(value.b), value.difference, {})};
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
      .def(
          "answer",
          [](const DifferenceValue& self, double tolerance_px) {
            return answerOf(agreementOf(self.difference, self.significance, tolerance_px));
          },
          "tolerance_px"_a = kDefaultTolerancePx, doc("Difference.answer"))
      .def("__repr__",
           [](const DifferenceValue& self) {
             return "<alidade.Difference: " + lengthsText(self.difference) + ">";
           })
      .def("_repr_html_", &differenceHtml);
  module.def("diff", &difference, "a"_a, "b"_a, py::kw_only(), "distance_m"_a = py::none(),
             "same_frame"_a = false, doc("diff"));
  bindRigDifference(module);
}

}  // namespace alidade::python
