// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>

#include <yaml-cpp/yaml.h>

#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/camera_save.h"
#include "alidade/files/file_text.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/nodes.h"
#include "alidade/files/yaml_writer.h"

namespace alidade {
namespace {

using detail::flowMap;
using detail::listOf;
using detail::writeEntries;

auto byName(std::span<const std::string_view> names, std::span<const double> values) {
  return [names, values](YAML::Emitter& out) {
    out << YAML::Flow << YAML::BeginMap;
    for (std::size_t i = 0; i < names.size(); ++i) writeEntries(out, names[i], values[i]);
    out << YAML::EndMap;
  };
}

void writeSettings(YAML::Emitter& out, const std::vector<Setting>& settings) {
  out << YAML::BeginMap;
  for (const auto& [key, values] : settings) {
    if (values.size() == 1) {
      writeEntries(out, key, values.front());
    } else {
      writeEntries(out, key, values);
    }
  }
  out << YAML::EndMap;
}

void writeView(YAML::Emitter& out, const ViewRecord& view) {
  const auto writePose = [&view](YAML::Emitter& to) { detail::writePose(to, view.camera_from_board); };
  flowMap("image", view.image, "num_corners", view.num_corners, "rms_px", view.rms_px, "camera_from_board",
          writePose)(out);
}

// NaN, of a pixel without a ray, is null.
std::optional<double> orNull(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

void writeProjectionStd(YAML::Emitter& out, const ProjectionStdRecord& record) {
  writeEntries(out, "projection_std_px",
               flowMap("center", orNull(record.center_px), "worst", record.worst_px));
  out << YAML::Comment("one standard deviation, for points at infinity, aligned by the best rotation");
  std::vector<std::optional<double>> std_px;
  for (const double std : record.std_px) std_px.push_back(orNull(std));
  out << YAML::Key << "projection_std_grid" << YAML::Value << YAML::BeginMap;
  writeEntries(out, "worst_pixel", record.worst_pixel, "columns", record.columns, "rows", record.rows,
               "std_px", std_px);
  out << YAML::EndMap;
}

void writeModel(YAML::Emitter& out, const ModelRecord& model) {
  const auto write = [&out](const char* key, double value) {
    if (std::isfinite(value)) writeEntries(out, key, value);
  };
  out << YAML::Flow << YAML::BeginMap;
  writeEntries(out, "model", model.model, "num_parameters", model.num_parameters);
  write("rms_px", model.rms_px);
  write("holdout_rms_px", model.holdout_rms_px);
  write("excess", model.excess);
  write("excess_std", model.excess_std);
  writeEntries(out, "verdict", model.verdict);
  out << YAML::EndMap;
}

void writeCalibration(YAML::Emitter& out, const CalibrationRecord& record,
                      std::span<const std::string_view> parameter_names) {
  const auto writeKnown = [&out](const char* key, const auto& values, const auto& value) {
    if (!values.empty()) writeEntries(out, key, value);
  };
  out << YAML::BeginMap;
  writeEntries(out, "rms_px", record.rms_px);
  out << YAML::Comment("sqrt(mean over corners of dx^2 + dy^2)");
  if (std::isfinite(record.holdout_rms_px)) {
    writeEntries(out, "holdout_rms_px", record.holdout_rms_px);
    out << YAML::Comment("cross-validation error: corners not used to estimate the camera or the pose");
  }
  writeEntries(out, "verdict", verdictName(record.verdict), "num_views", record.num_views, "num_corners",
               record.num_corners, "num_outliers", record.num_outliers);
  writeKnown("parameter_std", record.parameter_std, byName(parameter_names, record.parameter_std));
  writeKnown("covariance", record.covariance, record.covariance);
  writeKnown("parameter_std_by_view", record.parameter_std_by_view,
             byName(parameter_names, record.parameter_std_by_view));
  writeKnown("stated_covariance", record.stated_covariance, record.stated_covariance);
  if (record.projection_std) writeProjectionStd(out, *record.projection_std);
  writeKnown("termination", record.termination, record.termination);
  writeKnown("board", record.board, record.board);
  if (const auto& warp = record.warp) {
    writeEntries(out, "board_warp",
                 flowMap("bend_x_m", warp->shape.bend_x_m, "bend_y_m", warp->shape.bend_y_m, "bend_x_std_m",
                         warp->std_m.x(), "bend_y_std_m", warp->std_m.y()));
  }
  writeKnown("model_choice", record.model_choice, listOf(record.model_choice, writeModel));
  writeEntries(out, "findings", record.findings, "views", listOf(record.views, writeView));
  writeKnown("settings", record.settings,
             [&record](YAML::Emitter& to) { writeSettings(to, record.settings); });
  out << YAML::EndMap;
}

}  // namespace

std::string cameraFileText(const CameraRecord& file) {
  const auto names = file.camera.parameterNames();
  YAML::Emitter out;
  out << YAML::BeginMap;
  writeEntries(
      out, "alidade_camera", 1, "model", file.camera.modelId(), "image_size",
      flowMap("width", file.image_size.width, "height", file.image_size.height), "parameters",
      byName(names, file.camera.parameters()), "conventions",
      flowMap("pixel_origin", "top_left_pixel_center", "length_unit", "m", "pose", "camera_from_board"));
  if (file.domain) {
    writeEntries(out, "domain",
                 flowMap("max_angle_rad", file.domain->max_angle_rad, "full_image", file.domain->full_image));
  }
  if (!file.self_check.empty()) {
    const auto writeCheck = [](YAML::Emitter& to, const SelfCheckPoint& check) {
      flowMap("point", check.point, "pixel", check.pixel)(to);
    };
    writeEntries(out, "self_check", listOf(file.self_check, writeCheck));
  }
  if (file.calibration) {
    writeEntries(out, "calibration",
                 [&](YAML::Emitter& to) { writeCalibration(to, *file.calibration, names); });
  }
  if (!file.created_by.empty()) writeEntries(out, "created_by", file.created_by);
  out << YAML::EndMap;
  return detail::withBytesShown(detail::documentText(out)) + file.user_keys;
}

void writeCameraFile(const std::string& path, const CameraRecord& file) {
  writeFileAtomically(path, cameraFileText(file));
}

void saveCamera(const std::string& path, const CameraRecord& record, std::string_view format) {
  const CameraFormat& chosen = cameraFormat(format);
  // Of all formats only this program's own has room for the rest of the record.
  if (&chosen == cameraFormats().front()) return writeCameraFile(path, record);
  const std::array<NamedCamera, 1> named = {
      NamedCamera{.name = {}, .camera = record.camera, .image_size = record.image_size}};
  writeFileAtomically(path, formatText(chosen, named, path));
}

}  // namespace alidade
