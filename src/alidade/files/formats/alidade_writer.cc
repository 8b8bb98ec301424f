// SPDX-License-Identifier: MIT
#include "alidade/files/formats/alidade_writer.h"

#include <array>
#include <cmath>

#include <yaml-cpp/yaml.h>

#include "alidade/camera/correction_field.h"
#include "alidade/core/text.h"
#include "alidade/files/text/file_text.h"
#include "alidade/files/text/pose_node.h"
#include "alidade/files/text/yaml_writer.h"

namespace alidade {
namespace {

using detail::flowMap;
using detail::listOf;
using detail::quoted;
using detail::writeEntries;
using detail::writeValue;

auto byName(std::span<const std::string_view> names, std::span<const double> values) {
  return [names, values = std::vector(values.begin(), values.end())](YAML::Emitter& out) {
    out << YAML::Flow << YAML::BeginMap;
    for (std::size_t i = 0; i < names.size(); ++i) writeEntries(out, names[i], values[i]);
    out << YAML::EndMap;
  };
}

// One board as a SPEC and the map of its bend; several as lists.
void writeBoards(YAML::Emitter& out, const CalibrationRecord& record) {
  const auto writeBend = [](YAML::Emitter& to, const WarpRecord& warp) {
    writeEntries(to, "bend_x_m", warp.shape.bend_x_m, "bend_y_m", warp.shape.bend_y_m, "bend_x_std_m",
                 warp.std_m.x(), "bend_y_std_m", warp.std_m.y());
  };
  if (record.boards.size() > 1) {
    writeEntries(out, "board", listOf(record.boards, [](YAML::Emitter& to, const std::string& board) {
                   detail::writeValue(to, board);
                 }));
    if (record.warps.empty()) return;
    writeEntries(out, "board_warp", listOf(record.warps, [&](YAML::Emitter& to, const WarpRecord& warp) {
                   to << YAML::Flow << YAML::BeginMap;
                   writeEntries(to, "board", record.boards[warp.board]);
                   writeBend(to, warp);
                   to << YAML::EndMap;
                 }));
    return;
  }
  if (!record.boards.empty()) writeEntries(out, "board", record.boards.front());
  if (record.warps.empty()) return;
  writeEntries(out, "board_warp", [&](YAML::Emitter& to) {
    to << YAML::Flow << YAML::BeginMap;
    writeBend(to, record.warps.front());
    to << YAML::EndMap;
  });
}

void writeCalibration(YAML::Emitter& out, const CalibrationRecord& record,
                      std::span<const std::string_view> parameter_names) {
  const auto writeKnown = [&out](const char* key, double value, const char* comment) {
    if (!std::isfinite(value)) return;
    writeEntries(out, key, value);
    out << YAML::Comment(comment);
  };
  out << YAML::BeginMap;
  writeEntries(out, "verdict", verdictName(record.verdict));
  if (!record.date.empty()) writeEntries(out, "date", quoted(record.date));
  const bool is_far = std::isinf(record.accuracy_distance_m);
  writeKnown("accuracy_px", record.accuracy_px,
             is_far ? "error of a distant point (95 %) where boards were seen"
                    : "error of a point at that distance (95 %) where boards were seen");
  writeKnown("accuracy_distance_m", record.accuracy_distance_m, "with the pose aligned");
  writeKnown("covered_share", record.covered_share, "of the image");
  writeKnown("rms_px", record.rms_px, "sqrt(mean over corners of dx^2 + dy^2)");
  writeKnown("holdout_rms_px", record.holdout_rms_px, "cross-validation: corners not used for the estimate");
  writeEntries(out, "num_views", record.num_views, "num_corners", record.num_corners);
  writeBoards(out, record);
  writeEntries(out, "findings", record.findings);
  if (!record.parameter_std.empty())
    writeEntries(out, "parameter_std", byName(parameter_names, record.parameter_std));
  if (!record.pupil_std.empty())
    writeEntries(out, "pupil_std",
                 byName(std::span(EntrancePupil::kNames).first(record.pupil_std.size()), record.pupil_std));
  if (!record.covariance.empty()) {
    writeEntries(out, "covariance", detail::triangleRows(record.covariance));
    if (record.is_covariance_by_views) writeEntries(out, "covariance_by", "views");
  }
  if (!record.view_centers.empty()) writeEntries(out, "view_centers", record.view_centers);
  out << YAML::EndMap;
}

std::string indented(const std::string& text, std::size_t width) {
  std::string result;
  for (const std::string_view line : split(trim(text), '\n'))
    result += std::string(width, ' ') + std::string(line) + "\n";
  return result;
}

std::string cameraEntry(const RigCameraRecord& camera) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  writeEntries(out, "name", quoted(camera.camera.name.name), "camera_from_rig",
               [&camera](YAML::Emitter& to) { detail::writePose(to, camera.camera_from_rig); });
  if (camera.translation_std_m.norm() > 0) {
    writeEntries(out, "camera_from_rig_std",
                 flowMap("translation_m", camera.translation_std_m, "rotation_rad", camera.rotation_std_rad));
  }
  if (camera.time_offset_s) writeEntries(out, "time_offset_s", *camera.time_offset_s);
  out << YAML::EndMap;
  std::string entry = indented(detail::withBytesShown(detail::documentText(out)) + "camera:\n" +
                                   indented(cameraFileText(camera.camera), 2),
                               4);
  entry[2] = '-';
  return entry;
}

}  // namespace

std::string cameraFileText(const CameraRecord& file) {
  const auto names = file.camera.parameterNames();
  YAML::Emitter out;
  out << YAML::BeginMap;
  writeEntries(out, "alidade_camera", 1, "model", file.camera.modelId(), "image_size",
               flowMap("width", file.image_size.width, "height", file.image_size.height), "parameters",
               byName(names, file.camera.parameters()));
  const EntrancePupil& pupil = file.camera.pupil();
  if (!pupil.isFixed()) {
    const std::array values = {pupil.s1_m, pupil.s2_m};
    const std::size_t num_stated = pupil.s2_m == 0 ? 1 : 2;
    writeEntries(
        out, "pupil",
        byName(std::span(EntrancePupil::kNames).first(num_stated), std::span(values).first(num_stated)));
  }
  if (file.camera.correction() != nullptr) {
    const CorrectionGrid& grid = file.camera.correction()->grid();
    const auto place = [&grid](YAML::Emitter& to) {
      to << YAML::Flow << YAML::BeginMap;
      writeEntries(to, "columns", grid.columns, "rows", grid.rows, "x", grid.origin_px.x(), "y",
                   grid.origin_px.y(), "cell_width", grid.cell_px.x(), "cell_height", grid.cell_px.y());
      if (grid.is_bounded) writeEntries(to, "bounded", "true");
      to << YAML::EndMap;
    };
    const auto width = 2 * static_cast<std::size_t>(grid.pointsAcross());
    writeEntries(out, "correction", [&](YAML::Emitter& to) {
      to << YAML::BeginMap;
      writeEntries(to, "grid", place, "coefficients", [&](YAML::Emitter& rows) {
        rows << YAML::BeginSeq;
        const std::span<const double> all(file.camera.correction()->points());
        for (std::size_t at = 0; at < all.size(); at += width) writeValue(rows, all.subspan(at, width));
        rows << YAML::EndSeq;
      });
      to << YAML::EndMap;
    });
  }
  if (!file.name.isEmpty()) {
    const auto name = quoted(file.name.name);
    const auto serial = quoted(file.name.serial);
    const auto lens = quoted(file.name.lens);
    writeEntries(out, "camera", flowMap("name", name, "serial", serial, "lens", lens));
  }
  writeEntries(
      out, "conventions",
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

std::string rigFileText(const RigRecord& rig) {
  std::string text =
      "alidade_rig: 1\n"
      "conventions: {pose: camera_from_rig, length_unit: m, quaternion: xyzw}\n"
      "cameras:\n";
  for (const RigCameraRecord& camera : rig.cameras) text += cameraEntry(camera);
  if (!rig.isCalibrated() && rig.covariance.empty() && rig.created_by.empty()) return text + rig.user_keys;
  YAML::Emitter out;
  out << YAML::BeginMap;
  if (rig.isCalibrated()) {
    const auto entries = [&](const auto&... rms) {
      writeEntries(out, "calibration",
                   flowMap("verdict", verdictName(rig.verdict), rms..., "num_frames", rig.num_frames,
                           "findings", rig.findings));
    };
    if (std::isfinite(rig.rms_px)) entries("rms_px", rig.rms_px);
    if (!std::isfinite(rig.rms_px)) entries();
  }
  if (!rig.covariance.empty()) writeEntries(out, "covariance", detail::triangleRows(rig.covariance));
  if (!rig.created_by.empty()) writeEntries(out, "created_by", rig.created_by);
  out << YAML::EndMap;
  return text + detail::withBytesShown(detail::documentText(out)) + rig.user_keys;
}

}  // namespace alidade
