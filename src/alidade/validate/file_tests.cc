// SPDX-License-Identifier: MIT
#include "alidade/validate/file_tests.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/validate/held_out/held_out_images.h"

namespace alidade {
namespace {

ComparedCamera compared(const CameraRecord& file) {
  return {.camera = &file.camera, .size = file.image_size, .covariance = statedCovariance(file)};
}

CheckValues valuesOf(DiagnosisId id, const HeldOutJudgement& judgement, double tolerance_px) {
  if (id == "held_out_error") {
    return {{"rms_px", judgement.held_out_rms_px},
            {"noise_rms_px", judgement.noise_rms_px},
            {"tolerance_px", tolerance_px},
            {"num_corners", static_cast<double>(judgement.numCorners())},
            {"num_views", static_cast<double>(judgement.views.size())}};
  }
  if (!judgement.difference) return {};
  return {{"p95_px", judgement.difference->p95_px},
          {"tolerance_px", tolerance_px},
          {"covered_share", judgement.covered_share}};
}

void testOnImages(const CameraRecord& record, const FileTests& tests, CameraJudgement& judgement) {
  const auto add = [&](const Diagnosis& check) -> FileCheck& {
    return judgement.checks.emplace_back(fileCheck(check));
  };
  const auto& stated = record.calibration;
  HeldOutJudgement on_images =
      judgeOnImages(compared(record), tests.boards, tests.views,
                    {.is_covariance_by_views = stated && stated->is_covariance_by_views,
                     .jobs = tests.jobs,
                     .cancel = tests.cancel});
  bool is_decided = true;
  for (const Diagnosis& check : heldOutChecks(on_images, tests.tolerance_px)) {
    add(check).values = valuesOf(check.id, on_images, tests.tolerance_px);
    is_decided = is_decided && !check.is_undecided;
  }
  if (const Slip* const slip = namedSlip(on_images, tests.tolerance_px)) {
    judgement.checks.back().slip = slip->id;
    judgement.checks.back().mended = slip->mended;
  }
  if (stated && std::isfinite(stated->accuracy_px) && std::isinf(stated->accuracy_distance_m)) {
    FileCheck& check = add(statedAccuracyCheck(stated->accuracy_px, on_images));
    check.values = {{"stated_px", stated->accuracy_px}};
    if (on_images.difference) check.values.push_back({"measured_px", on_images.difference->p95_px});
  }
  if (stated && std::isfinite(stated->accuracy_px) && std::isfinite(stated->accuracy_distance_m)) {
    add({.id = "stated_accuracy",
         .severity = Severity::kNote,
         .cause = fmt::format("not tested: it is stated for points at {:g} m", stated->accuracy_distance_m)});
  }
  if (stated && !stated->view_centers.empty()) add(ownImagesCheck(stated->view_centers, tests.views));
  judgement.can_show_slips = judgement.can_show_slips || is_decided;
  judgement.held_out = std::move(on_images);
}

CheckValues footageValues(const FootageJudgement& judgement) {
  const FootageCheck& check = judgement.check;
  CheckValues values = {{"tolerance_px", check.tolerance_px},
                        {"blind_px", check.blind_px},
                        {"holdout_rms_px", check.holdout_rms_px},
                        {"num_frames", static_cast<double>(check.num_frames)},
                        {"num_points", static_cast<double>(check.num_points)}};
  if (check.explanation) {
    const CameraChange& change = check.changes.at(*check.explanation);
    values.push_back({"effect_px", change.effect_px});
    values.push_back({"sure_px", change.sure_px});
  }
  return values;
}

void testOnFootage(const CameraRecord& record, const std::string& file, const FileTests& tests,
                   CameraJudgement& judgement) {
  FootageJudgement on_footage = judgeOnFootage(
      record, *tests.footage,
      {.tolerance_px = tests.footage_tolerance_px, .num_jobs = tests.jobs, .cancel = tests.cancel},
      tests.num_footage_frames > 0 ? tests.num_footage_frames : tests.footage->frames.size());
  for (const Diagnosis& finding : footageFindings(on_footage, record, file)) {
    judgement.checks.push_back(fileCheck(finding));
    if (finding.id == "footage") judgement.checks.back().values = footageValues(on_footage);
  }
  if (on_footage.verdict() != FootageVerdict::kCannotTell) judgement.can_show_slips = true;
  judgement.footage = std::move(on_footage);
}

// Adds the checks on images, on footage and against the other camera, as requested. Thread-safe without
// images and footage.
void addTests(const StatedCamera& camera, const std::string& file, const FileTests& tests,
              CameraJudgement& judgement, bool is_only_camera) {
  const auto attempt = [&](DiagnosisId id, const auto& addChecks) {
    try {
      addChecks(recordOf(camera, file));
    } catch (const Error& error) {
      judgement.checks.push_back({.severity = Severity::kFailure, .id = id, .message = error.what()});
    }
  };
  if (!tests.views.empty()) {
    attempt("held_out_error", [&](const CameraRecord& record) { testOnImages(record, tests, judgement); });
  }
  if (tests.footage && !is_only_camera) {
    judgement.checks.push_back(
        fileCheck({.id = "footage",
                   .severity = Severity::kWarning,
                   .cause = "not tested: the file has several cameras, and footage is of one",
                   .next_step = "test the camera alone: " + file + "#" + judgement.name}));
  } else if (tests.footage) {
    attempt("footage", [&](const CameraRecord& record) { testOnFootage(record, file, tests, judgement); });
  }
  if (tests.other) {
    attempt("against", [&](const CameraRecord& record) {
      const Diagnosis check = againstCheck(compared(record), compared(*tests.other), tests.tolerance_px);
      judgement.checks.push_back(fileCheck(check));
      if (!check.is_undecided) judgement.can_show_slips = true;
    });
  }
}

// The options --image-size and --read-as may be meant for other files of the folder: a file that can be read
// completely without them states these values itself.
CameraSource readListed(const ListedFile& file, const ReadOptions& options) {
  if (file.is_from_folder && (options.image_size || !options.model.empty())) {
    try {
      CameraSource source = readCamerasToJudge(file.path);
      const bool is_complete =
          std::ranges::all_of(source.cameras, [](const StatedCamera& c) { return c.image_size.has_value(); });
      if (is_complete) return source;
    } catch (const NotACameraFile&) {
      throw;
    } catch (const Error&) {
      // The options may supply what the file lacks.
    }
  }
  return readCamerasToJudge(file.path, options);
}

}  // namespace

std::optional<FileJudgement> judgeFile(const ListedFile& file, const ReadOptions& options,
                                       const FileTests& tests, const CameraSource* known) {
  FileJudgement judgement{.file = file.path};
  try {
    const CameraSource source = known != nullptr ? *known : readListed(file, options);
    judgement.format = source.format;
    const bool is_one = source.cameras.size() + source.refused.size() == 1;
    for (const StatedCamera& camera : source.cameras) {
      judgement.cameras.push_back(judgeCamera(camera, file.path));
      addTests(camera, file.path, tests, judgement.cameras.back(), is_one);
    }
    judgement.rig_checks = checkRig(source);
    for (const RefusedCamera& camera : source.refused) {
      judgement.cameras.push_back(
          {.name = cameraLabel(camera),
           .checks = {{.severity = Severity::kFailure,
                       .id = "model",
                       .message = withoutPath(camera.reason.what(), cameraFilePath(file.path))}}});
    }
  } catch (const Error& e) {
    const bool is_other = dynamic_cast<const NotACameraFile*>(&e) != nullptr;
    if (is_other && file.is_from_folder) return std::nullopt;
    if (e.code() != ErrorCode::kInput) throw;
    judgement.error = withoutPath(e.what(), cameraFilePath(file.path));
  }
  return judgement;
}

}  // namespace alidade
