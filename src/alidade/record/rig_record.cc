// SPDX-License-Identifier: MIT
#include "alidade/record/rig_record.h"

#include <utility>

namespace alidade {

AnyRig rigOf(const RigRecord& record) {
  std::vector<MountedCamera> cameras;
  for (const RigCameraRecord& camera : record.cameras) {
    cameras.push_back({.name = camera.camera.name.name,
                       .camera = camera.camera.camera,
                       .image_size = camera.camera.image_size,
                       .camera_from_rig = camera.camera_from_rig});
  }
  return AnyRig(std::move(cameras));
}

}  // namespace alidade
