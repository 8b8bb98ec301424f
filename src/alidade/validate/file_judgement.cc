// SPDX-License-Identifier: MIT
#include "alidade/validate/file_judgement.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "alidade/validate/file_checks.h"

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

std::size_t FileJudgement::count(Severity status) const {
  return static_cast<std::size_t>(std::count_if(
      checks.begin(), checks.end(), [status](const Diagnosis& c) { return c.severity == status; }));
}

FileJudgement judgeCamera(const CameraSource& source, std::size_t index) {
  const StatedCamera& stated = source.cameras[index];
  FileClaims file{.camera = &stated.camera,
                  .image_size = stated.image_size,
                  .half_units = stated.half_units,
                  .unknown_keys = {},
                  .assumed = {},
                  .not_carried = {}};
  const bool can_show_slips = stated.own && !stated.own->self_check.empty();
  // Points to check by show better than the look of numbers whether digits are missing.
  if (can_show_slips) file.half_units = {};
  for (const Remark& remark : stated.remarks) {
    // Every remark has its row, so that no command says more of a file than this one.
    auto& sentences = remark.id == "unknown_keys"  ? file.unknown_keys
                      : remark.id == "not_carried" ? file.not_carried
                                                   : file.assumed;
    sentences.push_back(remark.message);
  }
  FileJudgement judgement{
      .file = source.cameras.size() + source.refused.size() > 1 ? source.path + "#" + cameraLabel(stated)
                                                                : source.path,
      .format = std::string(source.format),
      .model = std::string(stated.camera.modelId()),
      .size =
          stated.image_size ? fmt::format("{}x{}", stated.image_size->width, stated.image_size->height) : "",
      .checks = {},
      .can_show_slips = can_show_slips};
  judgement.checks.push_back({.severity = Severity::kPass,
                              .id = "schema",
                              .cause = "all required keys are present and all numbers are finite",
                              .evidence = fmt::format("{}, {}", source.format_name, stated.camera.modelId()),
                              .limit = "a known format"});
  for (auto& checks :
       {checkStatement(file), checkCamera(recordToCheck(stated), {.can_say_more = stated.own.has_value(),
                                                                 .is_size_guessed = !stated.image_size})})
    judgement.checks.insert(judgement.checks.end(), checks.begin(), checks.end());
  return judgement;
}

FileJudgement judgeRefused(const CameraSource& source, const RefusedCamera& camera) {
  return {.file = source.path + "#" + cameraLabel(camera),
          .format = std::string(source.format),
          .model = {},
          .size = {},
          .checks = {{.severity = Severity::kFailure,
                      .id = "schema",
                      .cause = camera.reason.what(),
                      .evidence = std::string(source.format_name) + ", a camera that is not supported",
                      .limit = "a camera of a known model"}},
          .can_show_slips = false};
}

FileJudgement judgeUnreadable(const std::string& path, const std::string& reason) {
  return {.file = path,
          .format = {},
          .model = {},
          .size = {},
          .checks = {{.severity = Severity::kFailure,
                      .id = "schema",
                      .cause = reason,
                      .evidence = "cannot be read",
                      .limit = "a known format"}},
          .can_show_slips = false};
}

}  // namespace alidade
