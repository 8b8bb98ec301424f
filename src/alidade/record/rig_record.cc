// SPDX-License-Identifier: MIT
#include "alidade/record/rig_record.h"

#include <algorithm>
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

bool orderCamerasAs(const RigRecord& other, RigRecord& rig) {
  if (rig.cameras.size() != other.cameras.size()) return false;
  const auto nameOf = [](const RigCameraRecord& camera) -> const std::string& {
    return camera.camera.name.name;
  };
  std::vector<RigCameraRecord> ordered;
  for (const RigCameraRecord& wanted : other.cameras) {
    const auto found = std::ranges::find(rig.cameras, nameOf(wanted), nameOf);
    if (found == rig.cameras.end()) return false;
    ordered.push_back(*found);
  }
  if (!std::ranges::equal(ordered, rig.cameras, {}, nameOf, nameOf)) rig.covariance.clear();
  rig.cameras = std::move(ordered);
  return true;
}

}  // namespace alidade
