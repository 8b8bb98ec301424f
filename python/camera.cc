// SPDX-License-Identifier: MIT
#include "camera.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include <pybind11/stl.h>

#include "alidade/camera/batch.h"
#include "alidade/camera/camera_edit.h"
#include "alidade/camera/correction_field.h"
#include "alidade/camera/model_fit.h"
#include "alidade/core/error.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/files/camera_source.h"
#include "alidade/imagery/remap.h"
#include "alidade/imagery/undistortion_view.h"
#include "bindings.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

std::span<ProjectStatus> statusSpan(std::uint8_t* statuses, std::size_t n) {
  static_assert(sizeof(ProjectStatus) == sizeof(std::uint8_t));
  return {reinterpret_cast<ProjectStatus*>(statuses), n};
}

// The same Jacobians, starting at row `begin`.
PixelJacobians from(const PixelJacobians& all, std::size_t begin, std::size_t num_params) {
  const auto at = [&](double* jacobians, std::size_t size) {
    return jacobians == nullptr ? nullptr : jacobians + begin * size;
  };
  return {.by_point = at(all.by_point, 6),
          .by_pose = at(all.by_pose, 12),
          .by_params = at(all.by_params, 2 * num_params)};
}

void projectInto(const AnyCamera& camera, const std::optional<SE3>& pose, const Rows& points, RowOutputs& out,
                 const PixelJacobians& jacobians, int jobs) {
  double* const pixels = out.values.mutable_data();
  std::uint8_t* const statuses = out.statuses.mutable_data();
  eachRun(points.count, jobs, [&](std::size_t begin, std::size_t n) {
    projectRows(camera, pose ? &*pose : nullptr, {points.data() + 3 * begin, 3 * n},
                {pixels + 2 * begin, 2 * n}, statusSpan(statuses + begin, n),
                from(jacobians, begin, camera.parameters().size()));
  });
}

void unprojectInto(const AnyCamera& camera, const Rows& pixels, RowOutputs& out, double* J_ray_pixel,
                   int jobs) {
  double* const rays = out.values.mutable_data();
  std::uint8_t* const statuses = out.statuses.mutable_data();
  eachRun(pixels.count, jobs, [&](std::size_t begin, std::size_t n) {
    unprojectRows(camera, {pixels.data() + 2 * begin, 2 * n}, {rays + 3 * begin, 3 * n},
                  statusSpan(statuses + begin, n),
                  J_ray_pixel == nullptr ? nullptr : J_ray_pixel + 6 * begin);
  });
}

py::tuple project(const CameraValue& self, const py::object& points, const py::object& camera_from_points,
                  const py::object& out, int jobs) {
  const Rows rows = rowsOf(points, 3, "points");
  const std::optional<SE3> pose = poseOf(camera_from_points, "camera_from_points");
  RowOutputs results = outputsOf(out, rows, 2);
  projectInto(self.record.camera, pose, rows, results, {}, jobs);
  return py::make_tuple(std::move(results.values), std::move(results.statuses));
}

py::tuple projectWithJacobians(const CameraValue& self, const py::object& points,
                               const py::object& camera_from_points, int jobs) {
  const Rows rows = rowsOf(points, 3, "points");
  const std::optional<SE3> pose = poseOf(camera_from_points, "camera_from_points");
  RowOutputs results = outputsOf(py::none(), rows, 2);
  py::array_t<double> by_point = rows.results({2, 3});
  py::array_t<double> by_pose = rows.results({2, 6});
  py::array_t<double> by_params =
      rows.results({2, static_cast<py::ssize_t>(self.record.camera.parameters().size())});
  projectInto(self.record.camera, pose, rows, results,
              {.by_point = by_point.mutable_data(),
               .by_pose = by_pose.mutable_data(),
               .by_params = by_params.mutable_data()},
              jobs);
  return py::make_tuple(std::move(results.values), std::move(results.statuses), std::move(by_point),
                        std::move(by_pose), std::move(by_params));
}

py::tuple unproject(const CameraValue& self, const py::object& pixels, const py::object& out, int jobs) {
  const Rows rows = rowsOf(pixels, 2, "pixels");
  RowOutputs results = outputsOf(out, rows, 3);
  unprojectInto(self.record.camera, rows, results, nullptr, jobs);
  return py::make_tuple(std::move(results.values), std::move(results.statuses));
}

py::tuple unprojectWithJacobians(const CameraValue& self, const py::object& pixels, int jobs) {
  const Rows rows = rowsOf(pixels, 2, "pixels");
  RowOutputs results = outputsOf(py::none(), rows, 3);
  py::array_t<double> by_pixel = rows.results({3, 2});
  unprojectInto(self.record.camera, rows, results, by_pixel.mutable_data(), jobs);
  return py::make_tuple(std::move(results.values), std::move(results.statuses), std::move(by_pixel));
}

ViewRequest viewRequest(const std::string& projection, const std::string& keep, const py::object& fov_deg,
                        const py::object& size) {
  ViewRequest request{.projection = projectionOf(projection), .size = {}};
  if (!size.is_none()) request.size = sizeOf(size, "size");
  if (!fov_deg.is_none() && !keep.empty())
    throw usageError({.where = "fov_deg and keep", .found = "both", .expected = "one of them"});
  if (!fov_deg.is_none()) {
    request.extent = ViewExtent::kFieldOfView;
    request.horizontal_field_rad = fov_deg.cast<double>() * std::numbers::pi / 180;
  } else if (keep == "valid" || keep == "all") {
    request.extent = keep == "all" ? ViewExtent::kAll : ViewExtent::kValid;
  } else if (!keep.empty()) {
    throw usageError({.where = "keep", .found = "'" + keep + "'", .expected = "'valid', 'all' or None"});
  }
  return request;
}

py::tuple undistortMap(const CameraValue& self, const std::string& projection,
                       const std::optional<std::string>& keep, const py::object& fov_deg,
                       const py::object& size, int jobs) {
  const CameraRecord& record = self.record;
  const ViewRequest request = viewRequest(projection, keep.value_or(""), fov_deg, size);
  std::unique_ptr<RemapTable> table;
  OutputView view;
  {
    const py::gil_scoped_release without_lock;
    view = chooseView(record.camera, record.image_size, request).view;
    table = std::make_unique<RemapTable>(makeRemapTable(record.camera, record.image_size, view, jobs));
  }
  // The array refers to the table's own memory, which a capsule keeps alive.
  static_assert(sizeof(SourcePixel) == 2 * sizeof(float));
  const auto* const data = reinterpret_cast<const float*>(table->pixels.data());
  const std::vector<py::ssize_t> shape = {table->size.height, table->size.width, 2};
  const py::capsule owner(table.release(), [](void* held) { delete static_cast<RemapTable*>(held); });
  py::object camera = py::none();
  if (view.projection == ViewProjection::kRectilinear)
    camera = py::cast(CameraValue{bareRecord(pinholeOf(view), view.size, creatorName() + " undistort")});
  return py::make_tuple(py::array_t<float>(shape, data, owner), std::move(camera));
}

AnyCamera madeCamera(const std::string& model, const py::object& parameters) {
  if (py::isinstance<py::dict>(parameters))
    return AnyCamera::make(model, parameters.cast<std::map<std::string, double>>());
  const auto names = parameterNames(model);
  const Rows rows = rowsOf(parameters, static_cast<py::ssize_t>(names.size()), "parameters of " + model);
  if (!rows.shape.empty())
    throw usageError(
        {.where = "parameters", .found = "an array of several rows", .expected = "one row of numbers"});
  return AnyCamera::make(model, std::span(rows.data(), names.size()));
}

CameraValue newCamera(const std::string& model, const py::object& size, const py::object& parameters,
                      const std::string& name, const std::pair<double, double>& pupil) {
  const EntrancePupil moving{.s1_m = pupil.first, .s2_m = pupil.second};
  moving.validate();
  const AnyCamera camera = madeCamera(model, parameters).withPupil(moving);
  CameraRecord record = bareRecord(camera, sizeOf(size, "size"), creatorName());
  record.name.name = name;
  return {record};
}

CameraValue edited(const CameraValue& self, const EditedCamera& camera, const char* what) {
  CameraRecord record = bareRecord(camera.camera, camera.size, creatorName() + " " + what);
  record.name = self.record.name;
  return {record};
}

py::tuple toModel(const CameraValue& self, const std::string& model) {
  const auto fit = [&] {
    const py::gil_scoped_release without_lock;
    return fitModel(self.record.camera, self.record.image_size, model);
  }();
  CameraRecord record = bareRecord(fit.camera, self.record.image_size, creatorName() + " to_model");
  record.name = self.record.name;
  return py::make_tuple(CameraValue{record}, fit.max_error_px);
}

std::string reprOf(const CameraValue& self) {
  const CameraRecord& record = self.record;
  std::string text = "Camera('" + std::string(record.camera.modelId()) + "', (" +
                     std::to_string(record.image_size.width) + ", " +
                     std::to_string(record.image_size.height) + "), {";
  const auto names = record.camera.parameterNames();
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i > 0 ? ", '" : "'") + std::string(names[i]) +
            "': " + py::repr(py::float_(record.camera.parameters()[i])).cast<std::string>();
  }
  text += "}";
  if (!record.name.name.empty()) text += ", name=" + py::repr(nameText(record.name.name)).cast<std::string>();
  return text + ")";
}

// A number, with two digits of its standard deviation if that is known.
std::string roundedText(double value, double std) {
  constexpr int kMostDecimals = 15;
  if (!(std > 0)) return numberText("%.10g", value);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(std))), 0, kMostDecimals);
  const std::string format = "%." + std::to_string(decimals) + "f";
  return numberText(format.c_str(), value) + " &plusmn; " + numberText(format.c_str(), std);
}

// The calibration stated in a camera file, for people.
py::str htmlOf(const CameraValue& self) {
  const CameraRecord& record = self.record;
  std::string rows;
  const auto names = record.camera.parameterNames();
  const auto& stated = record.calibration;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double std = stated && i < stated->parameter_std.size() ? stated->parameter_std[i] : 0;
    rows += "<tr><th>" + std::string(names[i]) + "</th><td>" +
            roundedText(record.camera.parameters()[i], std) + "</td></tr>";
  }
  std::string title = std::string(record.camera.modelId()) + ", " + sizeText(record.image_size) + " px";
  if (stated) title += ", " + std::string(verdictName(stated->verdict));
  const py::object escape = py::module_::import("html").attr("escape");
  if (!record.name.name.empty())
    title = escape(nameText(record.name.name)).cast<std::string>() + ": " + title;
  return "<table><caption>" + title + "</caption>" + rows + "</table>";
}

void bindInfo(py::module_& module) {
  const auto covariance = [](const CalibrationRecord& info) -> py::object {
    if (info.covariance.empty()) return py::none();
    // n (n + 1) / 2 numbers; a file may state them without parameter_std.
    const auto n = static_cast<Eigen::Index>(std::sqrt(2.0 * static_cast<double>(info.covariance.size())));
    return matrixArray(fullMatrix(info.covariance, n));
  };
  py::class_<CalibrationRecord>(module, "CalibrationInfo", doc("CalibrationInfo"))
      .def_property_readonly(
          "verdict", [](const CalibrationRecord& info) { return std::string(verdictName(info.verdict)); },
          doc("CalibrationInfo.verdict"))
      .def_readonly("accuracy_px", &CalibrationRecord::accuracy_px, doc("CalibrationInfo.accuracy_px"))
      .def_readonly("accuracy_distance_m", &CalibrationRecord::accuracy_distance_m,
                    doc("CalibrationInfo.accuracy_distance_m"))
      .def_readonly("covered_share", &CalibrationRecord::covered_share, doc("CalibrationInfo.covered_share"))
      .def_readonly("rms_px", &CalibrationRecord::rms_px, doc("CalibrationInfo.rms_px"))
      .def_readonly("holdout_rms_px", &CalibrationRecord::holdout_rms_px,
                    doc("CalibrationInfo.holdout_rms_px"))
      .def_readonly("num_views", &CalibrationRecord::num_views, doc("CalibrationInfo.num_views"))
      .def_readonly("num_corners", &CalibrationRecord::num_corners, doc("CalibrationInfo.num_corners"))
      .def_readonly("boards", &CalibrationRecord::boards, doc("CalibrationInfo.boards"))
      .def_readonly("findings", &CalibrationRecord::findings, doc("CalibrationInfo.findings"))
      .def_property_readonly(
          "parameter_std", [](const CalibrationRecord& info) { return vectorArray(info.parameter_std); },
          doc("CalibrationInfo.parameter_std"))
      .def_property_readonly("covariance", covariance, doc("CalibrationInfo.covariance"))
      .def("__repr__", [](const CalibrationRecord& info) {
        return "<alidade.CalibrationInfo: " + std::string(verdictName(info.verdict)) + ", within " +
               numberText("%.3g", info.accuracy_px) + " px (95 %)>";
      });
}

void bindAttributes(py::class_<CameraValue>& type) {
  type.def_property_readonly(
          "model", [](const CameraValue& self) { return std::string(self.record.camera.modelId()); },
          doc("Camera.model"))
      .def_property_readonly(
          "size", [](const CameraValue& self) { return sizeTuple(self.record.image_size); },
          doc("Camera.size"))
      .def_property_readonly(
          "name", [](const CameraValue& self) { return nameText(self.record.name.name); }, doc("Camera.name"))
      .def_property_readonly(
          "serial", [](const CameraValue& self) { return nameText(self.record.name.serial); },
          doc("Camera.serial"))
      .def_property_readonly(
          "parameters", [](const CameraValue& self) { return parametersDict(self.record.camera); },
          doc("Camera.parameters"))
      .def_property_readonly(
          "parameter_values",
          [](const CameraValue& self) {
            const auto values = self.record.camera.parameters();
            return vectorArray({values.begin(), values.end()});
          },
          doc("Camera.parameter_values"))
      .def_property_readonly(
          "calibration", [](const CameraValue& self) { return self.record.calibration; },
          doc("Camera.calibration"))
      .def_property_readonly(
          "max_angle_deg",
          [](const CameraValue& self) {
            return self.record.camera.cone().max_angle_rad * 180 / std::numbers::pi;
          },
          doc("Camera.max_angle_deg"))
      .def_property_readonly(
          "pupil",
          [](const CameraValue& self) {
            const EntrancePupil& pupil = self.record.camera.pupil();
            return py::make_tuple(pupil.s1_m, pupil.s2_m);
          },
          doc("Camera.pupil"))
      .def_property_readonly(
          "correction",
          [](const CameraValue& self) -> py::object {
            const auto& field = self.record.camera.correction();
            if (field == nullptr) return py::none();
            const CorrectionGrid& grid = field->grid();
            py::array_t<double> points({grid.rows + 3, grid.pointsAcross(), 2});
            std::ranges::copy(field->points(), points.mutable_data());
            return py::make_tuple(py::make_tuple(grid.origin_px.x(), grid.origin_px.y()),
                                  py::make_tuple(grid.cell_px.x(), grid.cell_px.y()), points);
          },
          doc("Camera.correction"))
      .def_property_readonly(
          "camera_from_rig",
          [](const CameraValue& self) -> py::object {
            if (!self.camera_from_rig) return py::none();
            return poseArray(*self.camera_from_rig);
          },
          doc("Camera.camera_from_rig"))
      .def_readonly("remarks", &CameraValue::remarks, doc("Camera.remarks"));
}

}  // namespace

std::string creatorName() {
  return "alidade " ALIDADE_VERSION;
}

py::dict parametersDict(const AnyCamera& camera) {
  py::dict parameters;
  const auto names = camera.parameterNames();
  for (std::size_t i = 0; i < names.size(); ++i)
    parameters[py::str(std::string(names[i]))] = camera.parameters()[i];
  return parameters;
}

void bindCamera(py::module_& module) {
  bindInfo(module);
  module.def(
      "models", [] { return modelIds(); }, doc("models"));
  module.def(
      "parameter_names",
      [](const std::string& model) {
        const auto names = parameterNames(model);
        return std::vector<std::string>(names.begin(), names.end());
      },
      "model"_a, doc("parameter_names"));
  py::class_<CameraValue> type(module, "Camera", doc("Camera"));
  bindAttributes(type);
  type.def(py::init(&newCamera), "model"_a, "size"_a, "parameters"_a, py::kw_only(), "name"_a = "",
           "pupil"_a = std::pair(0.0, 0.0), doc("Camera.__init__"))
      .def("project", &project, "points"_a, "camera_from_points"_a = py::none(), py::kw_only(),
           "out"_a = py::none(), "jobs"_a = 1, doc("Camera.project"))
      .def("project_with_jacobians", &projectWithJacobians, "points"_a, "camera_from_points"_a = py::none(),
           py::kw_only(), "jobs"_a = 1, doc("Camera.project_with_jacobians"))
      .def("unproject", &unproject, "pixels"_a, py::kw_only(), "out"_a = py::none(), "jobs"_a = 1,
           doc("Camera.unproject"))
      .def("unproject_with_jacobians", &unprojectWithJacobians, "pixels"_a, py::kw_only(), "jobs"_a = 1,
           doc("Camera.unproject_with_jacobians"))
      .def("undistort_map", &undistortMap, "projection"_a = "rectilinear", py::kw_only(),
           "keep"_a = py::none(), "fov_deg"_a = py::none(), "size"_a = py::none(), "jobs"_a = 0,
           doc("Camera.undistort_map"))
      .def(
          "crop",
          [](const CameraValue& self, int x, int y, int width, int height) {
            return edited(self, cropCamera(self.record.camera, self.record.image_size, {x, y, width, height}),
                          "crop");
          },
          "x"_a, "y"_a, "width"_a, "height"_a, doc("Camera.crop"))
      .def(
          "resize",
          [](const CameraValue& self, const py::object& size) {
            return edited(self,
                          resizeCamera(self.record.camera, self.record.image_size, sizeOf(size, "size")),
                          "resize");
          },
          "size"_a, doc("Camera.resize"))
      .def("to_model", &toModel, "model"_a, doc("Camera.to_model"))
      .def("__repr__", &reprOf)
      .def("_repr_html_", &htmlOf)
      .def(py::pickle(
          [](const CameraValue& self) {
            return py::make_tuple(py::bytes(cameraText(self.record, "alidade")));
          },
          [](const py::tuple& state) {
            return CameraValue{onlyCamera(parseCameras(state[0].cast<std::string>(), "the pickled camera"))};
          }));
}

}  // namespace alidade::python
