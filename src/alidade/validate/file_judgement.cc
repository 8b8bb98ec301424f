// SPDX-License-Identifier: MIT
#include "alidade/validate/file_judgement.h"

#include <algorithm>
#include <utility>

#include "alidade/validate/camera_checks.h"

namespace alidade {
namespace {

// What the file says of the camera, with the size to check it by.
CameraRecord recordToCheck(const StatedCamera& stated) {
  if (stated.own) return *stated.own;
  return {.camera = stated.camera,
          .image_size = stated.image_size.value_or(sizeAround(stated.camera)),
          .domain = {},
          .self_check = {},
          .calibration = {},
          .created_by = {}};
}

}  // namespace

Severity CameraJudgement::severity() const {
  Severity worst = Severity::kPass;
  for (const FileCheck& check : checks) worst = std::max(worst, check.severity);
  return worst;
}

Severity FileJudgement::severity() const {
  Severity worst = error.empty() ? Severity::kPass : Severity::kFailure;
  for (const CameraJudgement& camera : cameras) worst = std::max(worst, camera.severity());
  return worst;
}

CameraJudgement judgeCamera(const StatedCamera& stated, const std::string& file) {
  CameraJudgement judgement{.name = cameraLabel(stated),
                            .camera = stated.camera,
                            .image_size = stated.image_size,
                            .checks = {},
                            .can_show_slips = stated.own && !stated.own->self_check.empty()};
  judgement.checks = checkCamera(recordToCheck(stated), {.is_size_guessed = !stated.image_size,
                                                         .rectified_center = stated.rectified_center});
  if (!stated.image_size) {
    judgement.checks.push_back({.severity = Severity::kNote,
                                .id = "image_size",
                                .message = "the file does not state the image size; --image-size adds it"});
  }
  // Every command prints these; only a key that is ignored may be a slip.
  for (const Remark& remark : stated.remarks) {
    judgement.checks.push_back(
        {.severity = remark.id == "unknown_keys" ? Severity::kWarning : Severity::kNote,
         .id = remark.id,
         .message = withoutPath(remark.message, cameraFilePath(file))});
  }
  return judgement;
}

CameraJudgement judgeRefused(const RefusedCamera& camera, const std::string& file) {
  return {.name = cameraLabel(camera),
          .camera = std::nullopt,
          .image_size = std::nullopt,
          .checks = {{.severity = Severity::kFailure,
                      .id = "model",
                      .message = withoutPath(camera.reason.what(), cameraFilePath(file))}}};
}

std::string withoutPath(const std::string& message, const std::string& file) {
  if (!message.starts_with(file + ":")) return message;
  std::string rest = message.substr(file.size() + 1);
  const bool is_line = !rest.empty() && rest.front() >= '0' && rest.front() <= '9';
  if (is_line) return "line " + rest;
  return rest.starts_with(' ') ? rest.substr(1) : rest;
}

}  // namespace alidade
