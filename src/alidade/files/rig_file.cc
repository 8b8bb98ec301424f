// SPDX-License-Identifier: MIT
#include "alidade/files/rig_file.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "alidade/core/distinct_names.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/files/camera_source.h"
#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/formats/pose_numbers.h"
#include "alidade/files/text/atomic_file.h"

namespace alidade {
namespace {

// The document of a file with R and T but without lenses; nothing for any other file.
std::optional<detail::CameraDocument> pairDocument(const std::string& path) {
  constexpr std::size_t kMaxBytes = 1U << 20U;
  try {
    detail::CameraDocument document(readTextFile(path, kMaxBytes), path);
    if (detail::statesPair(document) && !detail::formats::opencv().recognises(document)) return document;
  } catch (const Error&) {
    // Reading it as a camera file reports the error.
  }
  return std::nullopt;
}

GatheredCameras ofOneFile(const std::string& path, const ReadOptions& options) {
  GatheredCameras all{.source = loadCameras(path, options), .where = {}};
  const CameraSource& source = all.source;
  const bool has_several = source.cameras.size() + source.refused.size() > 1;
  for (const StatedCamera& camera : source.cameras)
    all.where.push_back(has_several ? source.path + "#" + cameraLabel(camera) : path);
  const bool is_whole_rig = source.format == "alidade" && path == source.path && source.refused.empty() &&
                            source.cameras.front().camera_from_rig;
  if (is_whole_rig) all.rig = rigOf(source);
  return all;
}

GatheredCameras ofOpenCvPair(const std::string& lenses, const detail::CameraDocument& poses,
                             const ReadOptions& options) {
  GatheredCameras all = ofOneFile(lenses, options);
  CameraSource& source = all.source;
  if (source.format != "opencv" || source.cameras.size() != 2 || !source.refused.empty()) {
    throw detail::errorAt(
        lenses,
        "found " + std::to_string(source.cameras.size()) + " cameras in the format " +
            std::string(source.format_name),
        "the two cameras of OpenCV (M1 D1 M2 D2) that R and T of " + poses.file() + " belong to");
  }
  detail::statePoses(source, [&poses](std::vector<Remark>& remarks) {
    return std::vector<SE3>{SE3(), detail::readPair(poses.root(), remarks)};
  });
  for (const StatedCamera& camera : source.cameras) requirePose(camera, poses.file());
  return all;
}

// "left" for left.cameramodel, "cam0" for cam0/sensor.yaml; numbers if names are not unique.
void nameCameras(GatheredCameras& all) {
  const std::vector<std::string> stated = mapped(all.source.cameras, &StatedCamera::name);
  const std::set<std::string> unique(stated.begin(), stated.end());
  if (unique.size() == stated.size() && !unique.contains("")) return;
  const std::vector<std::string> files = mapped(all.where, cameraFilePath);
  const std::vector<std::string> names = distinctNames(
      mapped(files, [](const std::string& file) { return std::filesystem::path(file).stem().string(); }),
      files);
  for (std::size_t i = 0; i < all.source.cameras.size(); ++i)
    all.source.cameras[i].name = names.empty() ? "" : names[i];
}

// Refuses files that each define their own reference frame, which puts every camera at the origin.
void refuseOnePlace(const GatheredCameras& all) {
  const SE3& first = *all.source.cameras.front().camera_from_rig;
  for (const StatedCamera& camera : all.source.cameras) {
    constexpr double kRounding = 1e-12;
    if ((camera.camera_from_rig->inverse() * first).log().norm() > kRounding) return;
  }
  throw detail::errorAt(all.where.back(), "found the same pose as in " + all.where.front(),
                        "files that say where the cameras are to each other",
                        "calibrate them together: alidade rig calibrate");
}

}  // namespace

RigRecord loadRig(const std::string& path) {
  if (cameraFilePath(path) != path) {
    throw detail::errorAt(path, "one camera of a rig", "the whole rig", "use " + cameraFilePath(path));
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
    if (remark.id == "bad_pose" || remark.id == "no_pose") throw detail::errorAt(path, remark.message);
  }
  throw detail::errorAt(path + ": " + cameraLabel(camera), "no pose", "a rig: cameras and where they are",
                        "make one with alidade rig calibrate");
}

void saveRig(const std::string& path, const RigRecord& rig) {
  writeFileAtomically(path, rigFileText(rig));
}

GatheredCameras gatherCameras(std::span<const std::string> paths, const ReadOptions& options) {
  expect(!paths.empty(), "cameras come from a file");
  if (paths.size() == 1) return ofOneFile(paths.front(), options);
  if (paths.size() == 2) {
    for (const std::size_t i : {1U, 0U}) {
      if (const auto poses = pairDocument(paths[i])) return ofOpenCvPair(paths[1 - i], *poses, options);
    }
  }
  GatheredCameras all;
  for (const std::string& path : paths) {
    GatheredCameras one = ofOneFile(path, options);
    requireAll(one.source);
    static_cast<void>(onlyCamera(one.source));
    requirePose(one.source.cameras.front(), path);
    if (all.where.empty())
      all.source = {.path = one.source.path,
                    .format = one.source.format,
                    .format_name = one.source.format_name,
                    .cameras = {}};
    all.source.cameras.push_back(std::move(one.source.cameras.front()));
    all.source.cameras.back().number = all.where.size();
    all.where.push_back(path);
  }
  nameCameras(all);
  refuseOnePlace(all);
  return all;
}

}  // namespace alidade
