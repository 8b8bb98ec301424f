// SPDX-License-Identifier: MIT
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "bindings.h"
#include "camera.h"

namespace alidade::python {
namespace {

using namespace pybind11::literals;

ReadOptions readOptions(const py::object& size, const std::string& model) {
  ReadOptions options{.image_size = {}, .model = model};
  if (!size.is_none()) options.image_size = sizeOf(size, "size");
  return options;
}

CameraSource sourceOf(const std::string& path, const ReadOptions& options) {
  const py::gil_scoped_release without_lock;
  return loadCameras(path, options);
}

CameraValue valueOf(const StatedCamera& camera, CameraRecord record) {
  CameraValue value{.record = std::move(record)};
  for (const Remark& remark : camera.remarks) value.remarks.push_back(remark.message);
  value.camera_from_rig = camera.camera_from_rig;
  return value;
}

CameraValue loadOne(const py::object& path, const py::object& size, const std::string& model) {
  const CameraSource source = sourceOf(pathOf(path), readOptions(size, model));
  CameraRecord record = onlyCamera(source);
  return valueOf(source.cameras.front(), std::move(record));
}

std::vector<CameraValue> loadAll(const py::object& path, const py::object& size, const std::string& model) {
  const CameraSource source = sourceOf(pathOf(path), readOptions(size, model));
  requireAll(source);
  std::vector<CameraValue> cameras;
  for (const StatedCamera& camera : source.cameras) {
    CameraRecord record = recordOf(camera, source.path);
    record.name.name = cameraLabel(camera);
    cameras.push_back(valueOf(camera, std::move(record)));
  }
  return cameras;
}

void save(const py::object& path, const CameraValue& camera, const std::string& format) {
  const std::string file = pathOf(path);
  const py::gil_scoped_release without_lock;
  saveCamera(file, camera.record, format);
}

}  // namespace

void bindFiles(py::module_& module) {
  module.def("load_camera", &loadOne, "path"_a, py::kw_only(), "size"_a = py::none(), "model"_a = "",
             doc("load_camera"));
  module.def("load_cameras", &loadAll, "path"_a, py::kw_only(), "size"_a = py::none(), "model"_a = "",
             doc("load_cameras"));
  module.def("save_camera", &save, "path"_a, "camera"_a, "format"_a = "alidade", doc("save_camera"));
}

}  // namespace alidade::python
