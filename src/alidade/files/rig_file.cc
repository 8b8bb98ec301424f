// SPDX-License-Identifier: MIT
#include "alidade/files/rig_file.h"

#include <yaml-cpp/yaml.h>

#include "alidade/core/text.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/file_text.h"
#include "alidade/files/nodes.h"
#include "alidade/files/yaml_writer.h"

namespace alidade {
namespace {

using detail::flowMap;
using detail::writeEntries;

std::string indented(const std::string& text, std::size_t width) {
  std::string result;
  for (const std::string_view line : split(trim(text), '\n'))
    result += std::string(width, ' ') + std::string(line) + "\n";
  return result;
}

std::string cameraEntry(const RigCameraRecord& camera) {
  const auto quoted = [&camera](YAML::Emitter& out) { out << YAML::DoubleQuoted << camera.camera.name.name; };
  YAML::Emitter out;
  out << YAML::BeginMap;
  writeEntries(out, "name", quoted, "camera_from_rig",
               [&camera](YAML::Emitter& to) { detail::writePose(to, camera.camera_from_rig); });
  if (camera.translation_std_m.norm() > 0) {
    writeEntries(out, "camera_from_rig_std",
                 flowMap("translation_m", camera.translation_std_m, "rotation_rad", camera.rotation_std_rad));
  }
  out << YAML::EndMap;
  std::string entry = indented(detail::withBytesShown(detail::documentText(out)) + "camera:\n" +
                                   indented(cameraFileText(camera.camera), 2),
                               4);
  entry[2] = '-';
  return entry;
}

}  // namespace

std::string rigFileText(const RigRecord& rig) {
  std::string text =
      "alidade_rig: 1\n"
      "conventions: {pose: camera_from_rig, length_unit: m, quaternion: xyzw}\n"
      "cameras:\n";
  for (const RigCameraRecord& camera : rig.cameras) text += cameraEntry(camera);
  YAML::Emitter out;
  out << YAML::BeginMap;
  writeEntries(out, "calibration",
               flowMap("verdict", verdictName(rig.verdict), "rms_px", rig.rms_px, "num_frames",
                       rig.num_frames, "findings", rig.findings));
  if (!rig.created_by.empty()) writeEntries(out, "created_by", rig.created_by);
  out << YAML::EndMap;
  return text + detail::withBytesShown(detail::documentText(out));
}

}  // namespace alidade
