// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_calibrator.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "alidade/adjust/board/errors.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/record_of.h"
#include "alidade/core/error.h"
#include "alidade/core/parallel.h"
#include "alidade/core/text.h"
#include "alidade/rig/camera_motion.h"
#include "alidade/rig/given_lens.h"
#include "alidade/rig/joint_camera.h"
#include "alidade/rig/joint_fit.h"
#include "alidade/rig/rig_holdout.h"
#include "alidade/rig/rig_judge.h"
#include "alidade/rig/rig_uncertainty.h"

namespace alidade {
namespace {

// A camera that was calibrated before keeps its lens; its views give their poses.
CalibratorOptions optionsOf(std::size_t camera, const RigOptions& options) {
  CalibratorOptions of_camera = options.camera;
  if (!options.models.empty()) of_camera.model = options.models[camera];
  if (options.given.empty() || !options.given[camera]) return of_camera;
  const CameraRecord& given = *options.given[camera];
  of_camera.model = given.camera.modelId();
  of_camera.initial = {.camera = given.camera, .size = given.image_size};
  for (const std::string_view name : given.camera.parameterNames()) of_camera.held.emplace_back(name);
  return of_camera;
}

// Errors name their camera.
std::vector<RigCamera> calibratedAlone(std::span<const Board> boards, const std::vector<RigViews>& cameras,
                                       const RigOptions& options) {
  std::vector<RigCamera> result(cameras.size());
  const int num_threads = resolveJobs(options.camera.jobs);
  parallelFor(
      cameras.size(), num_threads,
      [&](std::size_t c) {
        RigCamera& camera = result[c];
        camera.name = cameras[c].name;
        if (!options.given.empty()) camera.given = options.given[c];
        try {
          CalibratorOptions of_camera = optionsOf(c, options);
          of_camera.jobs = std::max(1, num_threads / static_cast<int>(cameras.size()));
          camera.alone = calibrate(boards, cameras[c].views, of_camera);
        } catch (const Error& error) {
          throw Error(error.code(), {.where = camera.name, .found = error.what()});
        }
        camera.alone_rms_px = rms(camera.alone.fit);
      },
      options.camera.cancel);
  return result;
}

void requireOnePart(const std::vector<RigCamera>& cameras, const RigStart& start) {
  if (start.num_parts == 1) return;
  std::vector<std::string> parts(start.num_parts);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    std::string& part = parts[start.part_of[c]];
    part += (part.empty() ? "" : ", ") + cameras[c].name;
  }
  throw inputError({.where = "rig",
                    .found = "cameras that nothing links: " + join(parts, " | "),
                    .expected = "frames in which a camera of each part sees the same board at the same time",
                    .next_step = "check that the images' numbers or names match, or take frames in which "
                                 "both parts see the board"});
}

void requireCounts(std::size_t num_cameras, const RigOptions& options) {
  if (num_cameras < 2) {
    throw usageError({.where = "rig", .found = "one camera", .expected = "the views of two or more cameras"});
  }
  const auto isOneEach = [&](std::size_t count) { return count == 0 || count == num_cameras; };
  expect(isOneEach(options.models.size()) && isOneEach(options.given.size()), "one option for each camera");
}

// With the given lenses freed, to compare them with; nothing where their images alone give no rig.
std::optional<RigCalibration> freedRig(std::span<const Board> boards, const std::vector<RigViews>& cameras,
                                       const RigOptions& options) {
  RigOptions freed = options;
  freed.given.clear();
  freed.models.clear();
  for (std::size_t c = 0; c < cameras.size(); ++c) freed.models.push_back(optionsOf(c, options).model);
  try {
    return calibrate(boards, cameras, freed);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void countCommonViews(const JointViews& views, RigCalibration& rig) {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> num_of_board;  // by frame and board
  for (const PosedView& pose : views.poses) ++num_of_board[{pose.frame, pose.board}];
  const std::vector<std::vector<std::size_t>> placements = viewsOfPlacements(rig.fit);
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    if (num_of_board[{views.poses[v].frame, views.poses[v].board}] < 2) continue;
    ++rig.num_common_views;
    if (placements[rig.fit.views[v].placement].size() == 1) ++rig.num_lone_views;
  }
  for (const auto& of_placement : placements) rig.num_linked += of_placement.size() > 1 ? 1 : 0;
}

}  // namespace

RigCalibration calibrate(std::span<const Board> boards, std::vector<RigViews> cameras,
                         const RigOptions& options) {
  requireCounts(cameras.size(), options);
  const RigFrames frames = options.frames.empty() ? matchFrames(cameras) : framesOf(options.frames, cameras);
  RigCalibration rig;
  rig.frames = frames.names;
  rig.unmatched = frames.unmatched;
  rig.time_spread = frames.time_spread;
  rig.cameras = calibratedAlone(boards, cameras, options);
  const JointViews views = jointViews(boards, rig.cameras, FramesOfBoards(frames, cameras, rig.cameras));
  requireOnePart(rig.cameras, views.start);
  const bool is_any_given = std::ranges::any_of(rig.cameras, [](const RigCamera& c) { return !!c.given; });
  const auto freed = is_any_given ? freedRig(boards, cameras, options) : std::nullopt;
  rig.are_lenses_tested = !is_any_given || (freed && freed->covariance.rows() > 0);
  rig.num_renumbered = static_cast<std::size_t>(
      std::ranges::count_if(views.start.turn_of, [](std::size_t turn) { return turn != 0; }));
  std::vector<const Fit*> fits;
  for (const RigCamera& camera : rig.cameras) fits.push_back(&camera.alone.fit);
  if (freed) fits.push_back(&freed->fit);
  const JointFit joint = jointFit(rig.cameras, views, unevenBoards(fits), options.camera.cancel);
  rig.fit = joint.fit;
  rig.are_points_lost = joint.are_points_lost;
  for (const std::size_t v : joint.unlinked) {
    rig.unlinked.push_back({.camera = rig.fit.views[v].camera,
                            .image = rig.fit.views[v].image,
                            .frame = rig.frames[views.poses[v].frame]});
  }
  countCommonViews(views, rig);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) rig.cameras[c].rms_px = rmsOfCamera(rig.fit, c);
  setUncertainty(rig);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    rig.cameras[c].calibration = jointCamera(rig, c, options.camera.tolerance_px, options.camera.distance_m);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    RigCamera& camera = rig.cameras[c];
    if (camera.given && freed) camera.misfit = givenLensMisfit(*camera.given, *freed, c);
  }
  rig.motions = cameraMotions(rig, views, joint);
  rig.holdout = rigHoldout(rig.fit, options.camera.cancel);
  rig.diagnoses = judgeRig(rig, options.camera.tolerance_px);
  return rig;
}

int numLinkedFrames(const RigCalibration& rig) {
  std::set<std::size_t> frames;
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(rig.fit)) {
    if (of_placement.size() > 1)
      frames.insert(rig.fit.placements[rig.fit.views[of_placement.front()].placement].frame);
  }
  return static_cast<int>(frames.size());
}

RigCalibration calibrate(const Board& board, std::vector<RigViews> cameras, const RigOptions& options) {
  return calibrate(std::span(&board, 1), std::move(cameras), options);
}

RigRecord recordOf(const RigCalibration& rig, const std::string& created_by) {
  RigRecord record{.cameras = {},
                   .verdict = rig.verdict(),
                   .rms_px = rms(rig.fit),
                   .num_frames = numLinkedFrames(rig),
                   .findings = {},
                   .created_by = created_by};
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    if (std::ranges::find(record.findings, diagnosis.id) == record.findings.end())
      record.findings.push_back(diagnosis.id);
  }
  const JointColumns columns = jointColumns(rig.fit);
  if (rig.covariance.rows() > 0) {
    const int num_kept = columns.pose.back() + 6;  // without the boards' bends
    record.covariance = lowerTriangle(rig.covariance.view().topLeftCorner(num_kept, num_kept));
  }
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    if (camera.given) {
      record.cameras.push_back({.camera = *camera.given,
                                .camera_from_rig = rig.fit.cameras[c].camera_from_rig,
                                .translation_std_m = camera.translation_std_m,
                                .rotation_std_rad = camera.rotation_std_rad});
      record.cameras.back().camera.name.name = camera.name;
      continue;
    }
    CameraName name;
    name.name = camera.name;
    CameraRecord of_camera = recordOf(camera.calibration, {.created_by = "", .name = std::move(name)});
    if (of_camera.calibration && rig.covariance.rows() > 0)
      of_camera.calibration->is_covariance_by_views = rig.is_by_frames;
    record.cameras.push_back({.camera = std::move(of_camera),
                              .camera_from_rig = rig.fit.cameras[c].camera_from_rig,
                              .translation_std_m = camera.translation_std_m,
                              .rotation_std_rad = camera.rotation_std_rad});
  }
  return record;
}

}  // namespace alidade
