// SPDX-License-Identifier: MIT
#include <cmath>

#include <yaml-cpp/yaml.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/pose_node.h"
#include "alidade/files/utf8_check.h"

namespace alidade {
namespace {

// Numbers go out as text in their shortest exact form; the emitter's own 17 digits would turn 0.1 into
// 0.10000000000000001.
std::string number(double value) {
  expect(std::isfinite(value), "only finite numbers are written to a file");
  return exactText(value);
}

template <class Range>
void writeNumbers(YAML::Emitter& out, const Range& values) {
  out << YAML::Flow << YAML::BeginSeq;
  for (const double value : values) out << number(value);
  out << YAML::EndSeq;
}

void writeByName(YAML::Emitter& out, std::span<const std::string_view> names,
                 std::span<const double> values) {
  out << YAML::Flow << YAML::BeginMap;
  for (std::size_t i = 0; i < names.size(); ++i) {
    out << YAML::Key << std::string(names[i]) << YAML::Value << number(values[i]);
  }
  out << YAML::EndMap;
}

void writeSettings(YAML::Emitter& out, const std::vector<Setting>& settings) {
  out << YAML::BeginMap;
  for (const auto& [key, values] : settings) {
    out << YAML::Key << key << YAML::Value;
    if (values.size() == 1) {
      out << values.front();
    } else {
      out << YAML::Flow << values;
    }
  }
  out << YAML::EndMap;
}

void writeViews(YAML::Emitter& out, const std::vector<ViewRecord>& views) {
  out << YAML::BeginSeq;
  for (const ViewRecord& view : views) {
    out << YAML::Flow << YAML::BeginMap;
    out << YAML::Key << "image" << YAML::Value << view.image;
    out << YAML::Key << "num_corners" << YAML::Value << view.num_corners;
    out << YAML::Key << "rms_px" << YAML::Value << number(view.rms_px);
    out << YAML::Key << "camera_from_board" << YAML::Value;
    detail::writePose(out, view.camera_from_board);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

// NaN, of a pixel without a ray, is null.
void writeNumberOrNull(YAML::Emitter& out, double value) {
  if (std::isnan(value)) {
    out << YAML::Null;
  } else {
    out << number(value);
  }
}

void writeProjectionStd(YAML::Emitter& out, const ProjectionStdRecord& record) {
  out << YAML::Key << "projection_std_px" << YAML::Value << YAML::Flow << YAML::BeginMap  //
      << YAML::Key << "center" << YAML::Value;
  writeNumberOrNull(out, record.center_px);
  out << YAML::Key << "worst" << YAML::Value << number(record.worst_px) << YAML::EndMap
      << YAML::Comment("one standard deviation, for points at infinity, aligned by the best rotation");
  out << YAML::Key << "projection_std_grid" << YAML::Value << YAML::BeginMap;
  out << YAML::Key << "worst_pixel" << YAML::Value;
  writeNumbers(out, record.worst_pixel);
  out << YAML::Key << "columns" << YAML::Value << record.columns;
  out << YAML::Key << "rows" << YAML::Value << record.rows;
  out << YAML::Key << "std_px" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const double std : record.std_px) writeNumberOrNull(out, std);
  out << YAML::EndSeq << YAML::EndMap;
}

void writeModels(YAML::Emitter& out, const std::vector<ModelRecord>& models) {
  out << YAML::BeginSeq;
  for (const ModelRecord& model : models) {
    const auto write = [&](const char* key, double value) {
      if (std::isfinite(value)) out << YAML::Key << key << YAML::Value << number(value);
    };
    out << YAML::Flow << YAML::BeginMap;
    out << YAML::Key << "model" << YAML::Value << model.model;
    out << YAML::Key << "num_parameters" << YAML::Value << model.num_parameters;
    write("rms_px", model.rms_px);
    write("holdout_rms_px", model.holdout_rms_px);
    write("excess", model.excess);
    write("excess_std", model.excess_std);
    out << YAML::Key << "verdict" << YAML::Value << model.verdict << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

void writeCalibration(YAML::Emitter& out, const CalibrationRecord& record,
                      std::span<const std::string_view> parameter_names) {
  out << YAML::BeginMap;
  out << YAML::Key << "rms_px" << YAML::Value << number(record.rms_px)
      << YAML::Comment("sqrt(mean over corners of dx^2 + dy^2)");
  if (std::isfinite(record.holdout_rms_px)) {
    out << YAML::Key << "holdout_rms_px" << YAML::Value << number(record.holdout_rms_px)
        << YAML::Comment("cross-validation error: corners not used to estimate the camera or the pose");
  }
  out << YAML::Key << "verdict" << YAML::Value << std::string(verdictName(record.verdict));
  out << YAML::Key << "num_views" << YAML::Value << record.num_views;
  out << YAML::Key << "num_corners" << YAML::Value << record.num_corners;
  out << YAML::Key << "num_outliers" << YAML::Value << record.num_outliers;
  if (!record.parameter_std.empty()) {
    out << YAML::Key << "parameter_std" << YAML::Value;
    writeByName(out, parameter_names, record.parameter_std);
  }
  if (!record.covariance.empty()) {
    out << YAML::Key << "covariance" << YAML::Value;
    writeNumbers(out, record.covariance);
  }
  if (!record.parameter_std_by_view.empty()) {
    out << YAML::Key << "parameter_std_by_view" << YAML::Value;
    writeByName(out, parameter_names, record.parameter_std_by_view);
  }
  if (!record.stated_covariance.empty()) {
    out << YAML::Key << "stated_covariance" << YAML::Value;
    writeNumbers(out, record.stated_covariance);
  }
  if (record.projection_std) writeProjectionStd(out, *record.projection_std);
  if (!record.termination.empty()) out << YAML::Key << "termination" << YAML::Value << record.termination;
  if (!record.board.empty()) out << YAML::Key << "board" << YAML::Value << record.board;
  if (record.warp) {
    out << YAML::Key << "board_warp" << YAML::Value << YAML::Flow << YAML::BeginMap       //
        << YAML::Key << "bend_x_m" << YAML::Value << number(record.warp->shape.bend_x_m)  //
        << YAML::Key << "bend_y_m" << YAML::Value << number(record.warp->shape.bend_y_m)  //
        << YAML::Key << "bend_x_std_m" << YAML::Value << number(record.warp->std_m.x())   //
        << YAML::Key << "bend_y_std_m" << YAML::Value << number(record.warp->std_m.y()) << YAML::EndMap;
  }
  if (!record.model_choice.empty()) {
    out << YAML::Key << "model_choice" << YAML::Value;
    writeModels(out, record.model_choice);
  }
  out << YAML::Key << "findings" << YAML::Value << YAML::Flow << record.findings;
  out << YAML::Key << "views" << YAML::Value;
  writeViews(out, record.views);
  if (!record.settings.empty()) {
    out << YAML::Key << "settings" << YAML::Value;
    writeSettings(out, record.settings);
  }
  out << YAML::EndMap;
}

}  // namespace

std::string cameraFileText(const CameraRecord& file) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  out << YAML::Key << "alidade_camera" << YAML::Value << 1;
  out << YAML::Key << "model" << YAML::Value << std::string(file.camera.modelId());
  out << YAML::Key << "image_size" << YAML::Value << YAML::Flow << YAML::BeginMap  //
      << YAML::Key << "width" << YAML::Value << file.image_size.width              //
      << YAML::Key << "height" << YAML::Value << file.image_size.height << YAML::EndMap;
  out << YAML::Key << "parameters" << YAML::Value;
  writeByName(out, file.camera.parameterNames(), file.camera.parameters());
  out << YAML::Key << "conventions" << YAML::Value << YAML::Flow << YAML::BeginMap  //
      << YAML::Key << "pixel_origin" << YAML::Value << "top_left_pixel_center"      //
      << YAML::Key << "length_unit" << YAML::Value << "m"                           //
      << YAML::Key << "pose" << YAML::Value << "camera_from_board" << YAML::EndMap;
  if (file.domain) {
    out << YAML::Key << "domain" << YAML::Value << YAML::Flow << YAML::BeginMap               //
        << YAML::Key << "max_angle_rad" << YAML::Value << number(file.domain->max_angle_rad)  //
        << YAML::Key << "full_image" << YAML::Value << file.domain->full_image << YAML::EndMap;
  }
  if (!file.self_check.empty()) {
    out << YAML::Key << "self_check" << YAML::Value << YAML::BeginSeq;
    for (const SelfCheckPoint& check : file.self_check) {
      out << YAML::Flow << YAML::BeginMap << YAML::Key << "point" << YAML::Value;
      writeNumbers(out, check.point);
      out << YAML::Key << "pixel" << YAML::Value;
      writeNumbers(out, check.pixel);
      out << YAML::EndMap;
    }
    out << YAML::EndSeq;
  }
  if (file.calibration) {
    out << YAML::Key << "calibration" << YAML::Value;
    writeCalibration(out, *file.calibration, file.camera.parameterNames());
  }
  if (!file.created_by.empty()) out << YAML::Key << "created_by" << YAML::Value << file.created_by;
  out << YAML::EndMap;
  return detail::withBytesShown(std::string(out.c_str(), out.size())) + "\n";
}

void writeCameraFile(const std::string& path, const CameraRecord& file) {
  writeFileAtomically(path, cameraFileText(file));
}

}  // namespace alidade
