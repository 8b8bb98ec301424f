// SPDX-License-Identifier: MIT
#include "alidade/camera/any_rig.h"

#include <algorithm>
#include <set>
#include <utility>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"

namespace alidade {

AnyRig::AnyRig(std::vector<MountedCamera> cameras) : cameras_(std::move(cameras)) {
  if (cameras_.empty())
    throw inputError({.where = "rig", .found = "no camera", .expected = "one camera or more"});
  std::set<std::string> names;
  for (const MountedCamera& camera : cameras_) {
    if (names.insert(camera.name).second) continue;
    throw inputError({.where = "rig",
                      .found = "two cameras of the name '" + camera.name + "'",
                      .expected = "a different name for each camera"});
  }
}

std::size_t AnyRig::index(std::string_view name) const {
  const auto at = std::ranges::find(cameras_, name, &MountedCamera::name);
  if (at != cameras_.end()) return static_cast<std::size_t>(at - cameras_.begin());
  const std::vector<std::string> names = mapped(cameras_, &MountedCamera::name);
  throw usageError({.where = "rig",
                    .found = "no camera '" + std::string(name) + "'",
                    .expected = "one of " + join(names, ", "),
                    .next_step = didYouMean(name, names)});
}

Projection AnyRig::project(std::size_t i, const Eigen::Vector3d& p_rig) const {
  const MountedCamera& camera = cameras_.at(i);
  return camera.camera.projectPoint(camera.camera_from_rig * p_rig);
}

std::vector<Projection> AnyRig::project(const Eigen::Vector3d& p_rig) const {
  std::vector<Projection> projections;
  for (std::size_t i = 0; i < size(); ++i) projections.push_back(project(i, p_rig));
  return projections;
}

std::optional<RigRay> AnyRig::unproject(std::size_t i, const Eigen::Vector2d& pixel) const {
  const MountedCamera& camera = cameras_.at(i);
  const auto ray = camera.camera.unproject(pixel);
  if (!ray) return std::nullopt;
  const SE3 rig_from_camera = camera.camera_from_rig.inverse();
  return RigRay{.origin = rig_from_camera * camera.camera.startOf(*ray),
                .direction = rig_from_camera.rotation * *ray};
}

}  // namespace alidade
