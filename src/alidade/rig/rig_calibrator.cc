// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_calibrator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/adjust/noise/correction_fit.h"
#include "alidade/adjust/noise/joint_information.h"
#include "alidade/calibrate/calibrator.h"
#include "alidade/calibrate/uncertainty/print_errors.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/parallel.h"
#include "alidade/core/text.h"
#include "alidade/rig/motion_link.h"
#include "alidade/rig/rig_stages.h"
#include "alidade/rig/rig_start.h"
#include "alidade/rig/shared_models.h"
#include "alidade/target/board_turns.h"

namespace alidade {
namespace {

// A camera that was calibrated before keeps its lens; its views determine only their poses.
CalibratorOptions optionsOf(std::size_t camera, const RigOptions& options) {
  CalibratorOptions of_camera = options.camera;
  if (!options.models.empty()) of_camera.model = options.models[camera];
  if (!options.num_pupil.empty()) of_camera.num_pupil = options.num_pupil[camera];
  of_camera.correction_cells = {0, 0};
  if (options.given.empty() || !options.given[camera]) return of_camera;
  const CameraRecord& given = *options.given[camera];
  of_camera.model = given.camera.modelId();
  of_camera.initial = {.camera = given.camera, .size = given.image_size};
  for (const std::string_view name : given.camera.parameterNames()) of_camera.held.emplace_back(name);
  return of_camera;
}

bool isAnyGiven(const RigOptions& options) {
  return std::ranges::any_of(options.given, [](const auto& given) { return given.has_value(); });
}

// Calibrates the cameras for which `isWanted` is true; the others are kept. Adds the camera's name to errors.
void calibrateAlone(std::span<const Board> boards, const std::vector<RigViews>& cameras,
                    const RigOptions& options, const std::function<bool(std::size_t)>& isWanted,
                    std::vector<Calibration>& result) {
  result.resize(cameras.size());
  const int num_threads = resolveJobs(options.camera.jobs);
  parallelFor(
      cameras.size(), num_threads,
      [&](std::size_t c) {
        if (!isWanted(c)) return;
        try {
          CalibratorOptions of_camera = optionsOf(c, options);
          of_camera.jobs = std::max(1, num_threads / static_cast<int>(cameras.size()));
          result[c] = calibrate(boards, cameras[c].views, of_camera);
        } catch (const Error& error) {
          throw Error(error.code(), {.where = cameras[c].name, .found = error.what()});
        }
      },
      options.camera.cancel);
}

std::vector<Calibration> calibratedAlone(std::span<const Board> boards, const std::vector<RigViews>& cameras,
                                         const RigOptions& options) {
  std::vector<Calibration> result;
  calibrateAlone(
      boards, cameras, options, [](std::size_t) { return true; }, result);
  // A board that flexes before one camera flexes before all.
  const auto is_flexible = [](const Calibration& alone) { return isAnyFlexible(alone.fit); };
  if (options.camera.board_shape != BoardShapeMode::kAuto || std::ranges::none_of(result, is_flexible))
    return result;
  std::vector<Calibration> flexible = result;
  RigOptions flexibly = options;
  flexibly.camera.board_shape = BoardShapeMode::kFlexible;
  try {
    calibrateAlone(
        boards, cameras, flexibly, [&](std::size_t c) { return !is_flexible(result[c]); }, flexible);
  } catch (const Error&) {  // bends in each view may leave a camera undetermined
    return result;
  }
  for (std::size_t c = 0; c < result.size(); ++c) {
    if (is_flexible(flexible[c])) result[c] = std::move(flexible[c]);
  }
  return result;
}

// Gives equal cameras one model, where they are usable with it and fit about as well.
void shareModels(std::span<const Board> boards, const std::vector<RigViews>& cameras, RigOptions options,
                 std::vector<Calibration>& alone) {
  options.models = sharedModels(alone);
  const auto is_other = [&](std::size_t c) { return options.models[c] != onlyCamera(alone[c].fit).model; };
  std::vector<Calibration> shared = alone;
  try {
    calibrateAlone(boards, cameras, options, is_other, shared);
  } catch (const Error&) {
    return;
  }
  constexpr double kMostRise = 1.02;  // of the RMS
  for (std::size_t c = 0; c < alone.size(); ++c) {
    const bool is_as_good = rms(shared[c].fit) < kMostRise * rms(alone[c].fit);
    const bool is_usable = shared[c].isUsable() || !alone[c].isUsable();
    const bool is_like = isAnyFlexible(shared[c].fit) == isAnyFlexible(alone[c].fit);
    if (is_other(c) && is_usable && is_as_good && is_like) alone[c] = std::move(shared[c]);
  }
}

void requireOnePart(const std::vector<RigViews>& cameras, const JointViews& views) {
  if (views.num_parts == 1) return;
  const std::string parts = partsText(mapped(cameras, &RigViews::name), views.part_of);
  if (const auto& motion = views.little_motion) {
    throw inputError(
        {.where = "rig",
         .found =
             fmt::format("too little motion to link {}: {} and {} see no board together, and between frames "
                         "the boards turn {}",
                         parts, cameras[motion->first].name, cameras[motion->second].name,
                         turnsText(motion->turns, cameras[motion->second].name)),
         .expected =
             "boards that do not move relative to each other, and turns by 10 degrees or more about a second axis",
         .next_step =
             "tilt the rig, or the boards together, about another axis as well; or take frames in which both "
             "see the same board"});
  }
  throw inputError(
      {.where = "rig",
       .found = "cameras that nothing links: " + parts,
       .expected =
           "frames in which a camera of each part sees the same board at the same time, or boards that "
           "do not move relative to each other",
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

// The boards with the gap that the cameras see on average where one refutes that of the SPEC; nothing if none
// does.
std::optional<std::vector<Board>> boardsAsSeen(std::span<const Board> stated,
                                               const std::vector<Calibration>& alone) {
  std::vector<Board> boards(stated.begin(), stated.end());
  bool is_any = false;
  for (std::size_t b = 0; b < boards.size(); ++b) {
    double sum = 0;
    double num_views = 0;
    for (const Calibration& calibration : alone) {
      const Board& target = calibration.fit.boards[b].target;
      const auto own = static_cast<double>(numViews(calibration.fit, b));
      if (!target.refutedGap() || own == 0) continue;
      sum += own * *target.gap();
      num_views += own;
    }
    if (num_views == 0 || boards[b].refutedGap()) continue;
    boards[b] = withSeenGap(boards[b], sum / num_views);
    is_any = true;
  }
  return is_any ? std::optional(boards) : std::nullopt;
}

// Which of two groups of cameras has the mirrored images: that with the larger share of boards from behind,
// or the smaller one.
void requireUnmirrored(const std::vector<RigViews>& cameras, const JointViews& views) {
  std::array<std::vector<std::string>, 2> groups;
  std::array<double, 2> num_views = {};
  std::array<double, 2> num_from_behind = {};
  for (std::size_t c = 0; c < cameras.size(); ++c)
    groups[views.are_mirrored[c] ? 1 : 0].push_back(cameras[c].name);
  if (groups[1].empty()) return;
  for (const PosedView& view : views.poses) {
    const std::size_t group = views.are_mirrored[view.camera] ? 1 : 0;
    ++num_views[group];
    num_from_behind[group] += seesPrintedSide(view.camera_from_board) ? 0 : 1;
  }
  const double apart = num_from_behind[0] * num_views[1] - num_from_behind[1] * num_views[0];
  const bool are_first = apart != 0 ? apart > 0 : groups[0].size() < groups[1].size();
  throw inputError(
      {.where = "rig",
       .found = fmt::format("mirrored images of {}: in the images of {} the boards move in the opposite "
                            "direction",
                            join(groups[are_first ? 0 : 1], ", "), join(groups[are_first ? 1 : 0], ", ")),
       .expected = "images that are not flipped",
       .next_step = "switch the mirror mode of these cameras off, or give --mirrored image for them "
                    "('-' for the others), so that their images are flipped back; where that was given, "
                    "leave it out"});
}

// Cameras calibrated alone; throws unless all of them are linked. If recordings started at different times,
// cameras get their leads and frames are matched again.
JointViews linkedViews(std::span<const Board> boards, std::vector<RigViews>& cameras, const RigFrames& frames,
                       const RigOptions& options) {
  std::vector<Calibration> alone = calibratedAlone(boards, cameras, options);
  shareModels(boards, cameras, options, alone);
  if (const auto seen = boardsAsSeen(boards, alone)) {
    return linkedViews(*seen, cameras, frames, options);
  }
  JointViews views = jointViews(boards, frames, cameras, std::move(alone));
  if (options.frames.empty() &&
      std::ranges::any_of(views.lags, [](double lag) { return std::round(lag) != 0; })) {
    for (std::size_t c = 0; c < cameras.size(); ++c)
      cameras[c].lead += std::round(views.lags[c]) * frames.step;
    views = jointViews(boards, matchFrames(cameras), cameras, std::move(views.alone));
  }
  requireOnePart(cameras, views);
  requireUnmirrored(cameras, views);
  return views;
}

RigLinks linksOf(const JointViews& views, const JointFit& joint) {
  RigLinks links{.num_renumbered = static_cast<std::size_t>(
                     std::ranges::count_if(views.turn_of, [](std::size_t turn) { return turn != 0; }))};
  for (const std::size_t v : joint.unlinked) {
    links.unlinked.push_back({.camera = joint.fit.views[v].camera,
                              .image = joint.fit.views[v].image,
                              .frame = views.frames.names[views.poses[v].frame]});
  }
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> num_of_body;  // by frame and body
  const auto placeOf = [&](const PosedView& pose) {
    return std::pair(pose.frame, views.body_of[pose.board]);
  };
  for (const PosedView& pose : views.poses) ++num_of_body[placeOf(pose)];
  const std::vector<std::vector<std::size_t>> placements = viewsOfPlacements(joint.fit);
  for (std::size_t v = 0; v < views.poses.size(); ++v) {
    if (num_of_body[placeOf(views.poses[v])] < 2) continue;
    ++links.num_common_views;
    if (placements[joint.fit.views[v].placement].size() == 1) ++links.num_lone_views;
  }
  for (const auto& of_placement : placements) links.num_linked += of_placement.size() > 1 ? 1 : 0;
  if (!views.common_part_of.empty()) {
    links.common_part_of = views.common_part_of;
    links.turns = turnsOf(joint.fit);
  }
  return links;
}

// Cameras that see different sides of the boards agree only if none is mirrored, so nothing is left to ask.
void settleMirrors(RigCalibration& rig) {
  const bool is_front_seen = std::ranges::any_of(
      rig.fit.views, [&](const FitView& view) { return seesPrintedSide(cameraFromBoard(rig.fit, view)); });
  if (!is_front_seen) return;
  for (RigCamera& camera : rig.cameras) {
    for (Diagnosis& diagnosis : camera.calibration.diagnoses) {
      if (diagnosis.id != DiagnosisId("mirrored_view")) continue;
      diagnosis.severity = Severity::kNote;
      diagnosis.next_step.clear();
    }
  }
}

// Solves a rig of linked cameras.
// @param freed  the same rig with the given lenses freed, for comparison; may be null
RigCalibration joined(JointViews views, const std::vector<RigViews>& cameras, const RigOptions& options,
                      const RigCalibration* freed) {
  std::vector<const Fit*> fits = mapped(views.alone, [](const Calibration& alone) { return &alone.fit; });
  if (freed != nullptr) fits.push_back(&freed->fit);
  const JointFit joint = jointFit(views, unevenBoards(fits), options.camera.cancel);
  const RigCovariance covariance = rigCovariance(joint.fit, options.given, views.alone);
  RigCalibration rig{.fit = joint.fit,
                     .frames = views.frames,
                     .links = linksOf(views, joint),
                     .covariance = covariance,
                     .exposure = joint.exposure,
                     .are_points_lost = joint.are_points_lost,
                     .are_lenses_tested = !isAnyGiven(options) || (freed && freed->covariance.isKnown()),
                     .motions = cameraMotions(views, joint, covariance),
                     .holdout = rigHoldout(joint.fit, options.camera.cancel)};
  if (options.rate_hz > 0) rig.frames.interval_s = rig.frames.step / options.rate_hz;
  const std::vector<CameraLink> links = cameraLinks(rig.fit, covariance);
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    RigCamera camera{.name = cameras[c].name,
                     .calibration = jointCamera(views.alone[c], rig.fit, covariance, c,
                                                options.camera.tolerance_px, options.camera.distance_m),
                     .rms_px = rmsOfCamera(rig.fit, c),
                     .alone_rms_px = rms(views.alone[c].fit),
                     .link = links[c]};
    if (!options.given.empty()) camera.given = options.given[c];
    if (camera.given && freed != nullptr) camera.misfit = givenLensMisfit(*camera.given, *freed, c);
    camera.alone = std::move(views.alone[c]);
    rig.cameras.push_back(std::move(camera));
  }
  settleMirrors(rig);
  rig.diagnoses = judgeRig(rig, options.camera.tolerance_px);
  for (RigCamera& camera : rig.cameras) {
    const double found_px = std::max(foundErrorPx(camera), foundErrorPx(rig.cameras[camera.link.partner]));
    camera.link.transfer_px = std::hypot(camera.link.transfer_px, found_px);
  }
  return rig;
}

// The rig with the given lenses freed; nothing if its images alone do not determine a rig.
std::optional<RigCalibration> freedRig(std::span<const Board> boards, std::vector<RigViews> cameras,
                                       const RigFrames& frames, const RigOptions& options) {
  RigOptions freed = options;
  freed.given.clear();
  freed.models.clear();
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    freed.models.push_back(optionsOf(c, options).model);
    const auto& given = options.given[c];
    freed.num_pupil.push_back(given ? std::optional(numPupil(given->camera)) : options.camera.num_pupil);
  }
  try {
    JointViews views = linkedViews(boards, cameras, frames, freed);
    return joined(std::move(views), cameras, freed, nullptr);
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool isCorrected(const std::optional<CameraRecord>& given) {
  return given && given->camera.correction() != nullptr;
}

// With corners free of the given cameras' correction fields.
RigCalibration calibrateCorrected(std::span<const Board> boards, std::vector<RigViews> cameras,
                                  const RigOptions& options) {
  RigOptions plain = options;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (!isCorrected(options.given[c])) continue;
    const AnyCamera& camera = options.given[c]->camera;
    cameras[c].views = freeOf(*camera.correction(), std::move(cameras[c].views));
    plain.given[c]->camera = camera.withCorrection(nullptr);
  }
  RigCalibration rig = calibrate(boards, std::move(cameras), plain);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    rig.cameras[c].given = options.given[c];
    if (isCorrected(options.given[c])) rig.fit.cameras[c].correction = options.given[c]->camera.correction();
  }
  return rig;
}

}  // namespace

RigCalibration calibrate(std::span<const Board> boards, std::vector<RigViews> cameras,
                         const RigOptions& options) {
  requireCounts(cameras.size(), options);
  if (std::ranges::any_of(options.given, isCorrected))
    return calibrateCorrected(boards, std::move(cameras), options);
  RigFrames frames = options.frames.empty() ? matchFrames(cameras) : framesOf(options.frames, cameras);
  frames.are_simultaneous = options.are_simultaneous;
  JointViews views = linkedViews(boards, cameras, frames, options);
  const auto freed = isAnyGiven(options) ? freedRig(boards, cameras, views.frames, options) : std::nullopt;
  return joined(std::move(views), cameras, options, freed ? &*freed : nullptr);
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
    if (std::ranges::find(record.findings, std::string_view(diagnosis.id)) == record.findings.end())
      record.findings.emplace_back(diagnosis.id);
  }
  const JointColumns columns = jointColumns(rig.fit);
  if (rig.covariance.isKnown()) {
    std::vector<int> kept;  // without entrance pupils and the boards' bends
    for (std::size_t c = 0; c < columns.params.size(); ++c) {
      for (int i = 0; i < static_cast<int>(rig.fit.cameras[c].numLensParams()); ++i)
        kept.push_back(columns.params[c] + i);
    }
    for (const int pose : columns.pose) {
      for (int i = 0; pose >= 0 && i < 6; ++i) kept.push_back(pose + i);
    }
    record.covariance = lowerTriangle(rig.covariance.matrix.view()(kept, kept));
  }
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    CameraRecord of_camera = camera.given ? *camera.given : recordOf(camera.calibration, "");
    of_camera.name.name = camera.name;
    if (!camera.given && of_camera.calibration && rig.covariance.isKnown())
      of_camera.calibration->is_covariance_by_views = rig.covariance.is_by_frames;
    record.cameras.push_back({.camera = std::move(of_camera),
                              .camera_from_rig = rig.fit.cameras[c].camera_from_rig,
                              .translation_std_m = camera.link.translation_std_m,
                              .rotation_std_rad = camera.link.rotation_std_rad});
    if (!(rig.frames.interval_s > 0) || !(rig.exposure || rig.frames.areShifted())) continue;
    const double num_steps = (rig.frames.leads[c] - rig.frames.leads.front()) / rig.frames.step;
    record.cameras.back().time_offset_s = rig.frames.interval_s * (rig.fit.cameras[c].delay - num_steps);
  }
  return record;
}

}  // namespace alidade
