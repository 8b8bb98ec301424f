// SPDX-License-Identifier: MIT
#include "alidade/files/rig_file.h"

#include <yaml-cpp/yaml.h>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/nodes.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/file_text.h"
#include "alidade/files/text/yaml_writer.h"

namespace alidade {
namespace {

using detail::flowMap;
using detail::writeEntries;
using detail::YamlNode;

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

// What other formats do not have.
void readOwn(const YamlNode& root, RigRecord& rig) {
  const std::vector<YamlNode> entries = root.at("cameras").items();
  expect(entries.size() == rig.cameras.size(), "a rig is read whole");
  std::size_t num_columns = 6 * (entries.size() - 1);
  for (std::size_t c = 0; c < entries.size(); ++c) {
    rig.cameras[c] = detail::readRigCamera(entries[c]);
    num_columns += rig.cameras[c].camera.camera.parameters().size();
  }
  if (const auto calibration = root.find("calibration")) {
    calibration->allowKeys({"verdict", "rms_px", "num_frames", "findings"});
    rig.verdict = detail::readVerdict(calibration->at("verdict"));
    rig.rms_px = calibration->at("rms_px").number();
    rig.num_frames = calibration->at("num_frames").integer();
    rig.findings = calibration->at("findings").texts();
  }
  if (const auto covariance = root.find("covariance"))
    rig.covariance = detail::readTriangle(*covariance, num_columns);
  if (const auto created_by = root.find("created_by")) rig.created_by = created_by->text();
  rig.user_keys = detail::userKeys(root.node());
}

}  // namespace

void detail::checkRigRoot(const YamlNode& root) {
  root.allowKeys({"alidade_rig", "conventions", "cameras", "calibration", "covariance", "created_by"});
  const YamlNode version = root.at("alidade_rig");
  if (version.integer() != 1) {
    throw version.error("format version " + version.text(), "1",
                        "the file may come from a newer release of Alidade; update the program");
  }
}

RigCameraRecord detail::readRigCamera(const YamlNode& entry) {
  entry.allowKeys({"name", "camera_from_rig", "camera_from_rig_std", "camera"});
  RigCameraRecord record{.camera = readCameraRoot(entry.at("camera")),
                         .camera_from_rig = readPose(entry.at("camera_from_rig"))};
  record.camera.name.name = entry.at("name").text();
  if (const auto std = entry.find("camera_from_rig_std")) {
    std->allowKeys({"translation_m", "rotation_rad"});
    record.translation_std_m = Eigen::Vector3d(std->at("translation_m").numbers(3).data());
    record.rotation_std_rad = Eigen::Vector3d(std->at("rotation_rad").numbers(3).data());
  }
  return record;
}

RigRecord loadRig(const std::string& path) {
  if (cameraFilePath(path) != path) {
    throw inputError({.where = path,
                      .found = "one camera of a rig",
                      .expected = "the whole rig",
                      .next_step = "use " + cameraFilePath(path)});
  }
  const CameraSource source = loadCameras(path);  // with the self-check of each camera
  requireAll(source);
  return rigOf(source);
}

RigRecord rigOf(const CameraSource& source) {
  RigRecord rig;
  for (const StatedCamera& camera : source.cameras) {
    requirePose(camera, source.path);
    rig.cameras.push_back(
        {.camera = recordOf(camera, source.path), .camera_from_rig = *camera.camera_from_rig});
    rig.cameras.back().camera.name.name = cameraLabel(camera);
  }
  if (source.format == "alidade") readOwn(YamlNode::readFile(source.path), rig);
  return rig;
}

void requirePose(const StatedCamera& camera, const std::string& path) {
  if (camera.camera_from_rig) return;
  for (const Remark& remark : camera.remarks) {
    if (remark.id == "bad_pose") throw inputError({.where = path, .found = remark.message});
  }
  throw inputError({.where = path + ": " + cameraLabel(camera),
                    .found = "no pose",
                    .expected = "a rig: cameras and where they are",
                    .next_step = "make one with alidade rig calibrate"});
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
    writeEntries(out, "calibration",
                 flowMap("verdict", verdictName(rig.verdict), "rms_px", rig.rms_px, "num_frames",
                         rig.num_frames, "findings", rig.findings));
  }
  if (!rig.covariance.empty()) writeEntries(out, "covariance", detail::triangleRows(rig.covariance));
  if (!rig.created_by.empty()) writeEntries(out, "created_by", rig.created_by);
  out << YAML::EndMap;
  return text + detail::withBytesShown(detail::documentText(out)) + rig.user_keys;
}

void saveRig(const std::string& path, const RigRecord& rig) {
  writeFileAtomically(path, rigFileText(rig));
}

}  // namespace alidade
