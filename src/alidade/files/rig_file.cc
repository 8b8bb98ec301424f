// SPDX-License-Identifier: MIT
#include "alidade/files/rig_file.h"

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/text/atomic_file.h"

namespace alidade {

RigRecord loadRig(const std::string& path) {
  if (cameraFilePath(path) != path) {
    throw inputError({.where = path,
                      .found = "one camera of a rig",
                      .expected = "the whole rig",
                      .next_step = "use " + cameraFilePath(path)});
  }
  const CameraSource source = loadCameras(path);  // including the self-check of each camera
  requireAll(source);
  return rigOf(source);
}

RigRecord rigOf(const CameraSource& source) {
  RigRecord rig;
  for (const StatedCamera& camera : source.cameras) {
    requirePose(camera, source.path);
    rig.cameras.push_back(
        {.camera = recordOf(camera, source.path), .camera_from_rig = *camera.camera_from_rig});
    rig.cameras.back().camera.name.name = source.readRigRest ? camera.name : cameraLabel(camera);
  }
  if (source.readRigRest) source.readRigRest(rig);
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

void saveRig(const std::string& path, const RigRecord& rig) {
  writeFileAtomically(path, rigFileText(rig));
}

}  // namespace alidade
