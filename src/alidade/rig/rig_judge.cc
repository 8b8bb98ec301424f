// SPDX-License-Identifier: MIT
#include "alidade/rig/rig_stages.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/degrees.h"
#include "alidade/core/diagnosis.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/rig/motion_link.h"
#include "alidade/rig/rig_start.h"

namespace alidade {
namespace {

constexpr double kRadius95 = 1.7308;  // 95 % radius of a normal variable in the plane, over its RMS
constexpr double kMillimetres = 1000;

// "left/1.png, left/2.png and 7 more".
std::string listedImages(const RigCalibration& rig, const std::vector<RigImage>& images) {
  constexpr std::size_t kMost = 5;
  std::vector<std::string> names;
  for (const RigImage& image : images) {
    if (names.size() < kMost) names.push_back(rig.cameras[image.camera].name + "/" + image.image);
  }
  const std::size_t num_more = images.size() - names.size();
  return join(names, ", ") + (num_more > 0 ? fmt::format(" and {} more", num_more) : "");
}

void judgeFit(const RigCalibration& rig, std::vector<Diagnosis>& diagnoses) {
  if (rig.fit.summary.termination != Termination::kConverged) {
    diagnoses.push_back(
        {.id = "not_converged",
         .cause = "the joint fit did not converge: " + rig.fit.summary.reason,
         .next_step =
             "remove the images that contradict their frames, then those of the worst camera; or name a "
             "model with fewer parameters, for example --model radtan"});
  }
  if (!rig.covariance.isKnown()) {
    diagnoses.push_back(
        {.id = "undetermined",
         .cause = "the frames do not determine the poses of the cameras",
         .next_step = "take more frames in which several cameras see the board, tilted differently"});
  }
}

void judgeMotions(const RigCalibration& rig, double tolerance_px, std::vector<Diagnosis>& diagnoses) {
  for (const CameraMotion& motion : rig.motions) {
    const std::string& name = rig.cameras[motion.camera].name;
    const SE3& change = motion.after_from_before;
    diagnoses.push_back(
        {.id = "camera_moved",
         .severity = severityOf(motion.effect_px, tolerance_px),
         .cause = fmt::format("{} stands elsewhere from frame {} on: by {:.2f} mm and {:.3f} degrees, which "
                              "moves points at the boards' distance by {:.2f} px",
                              rig.cameras.size() == 2 ? name + " relative to the other camera" : name,
                              motion.from_frame, change.translation.norm() * kMillimetres,
                              change.rotation.log().norm() * kDegPerRad, motion.effect_px),
         .next_step = "fix the cameras to each other; calibrate the frames before and after it separately",
         .effect_px = motion.effect_px});
  }
}

void judgeFrames(const RigCalibration& rig, double tolerance_px, std::vector<Diagnosis>& diagnoses) {
  std::vector<RigImage> unlinked;  // not explained by a motion
  std::ranges::copy_if(rig.links.unlinked, std::back_inserter(unlinked), [&](const RigImage& image) {
    return std::ranges::none_of(rig.motions, [&](const CameraMotion& motion) {
      return motion.camera == image.camera && motion.effect_px > tolerance_px;
    });
  });
  if (!unlinked.empty()) {
    // If two views contradict each other, either may be wrong.
    const bool are_many = 5 * rig.links.num_lone_views > rig.links.num_common_views;
    diagnoses.push_back(
        {.id = "not_simultaneous",
         .severity = are_many ? Severity::kFailure : Severity::kWarning,
         .cause = fmt::format("{} of {} common views of a board contradict the rig", unlinked.size(),
                              rig.links.num_common_views),
         .evidence = listedImages(rig, unlinked),
         .next_step = "hold the board still while the cameras take a frame, and check that names match"});
  }
  if (rig.frames.areShifted()) {
    std::vector<std::string> together;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      together.push_back(fmt::format("{:.9g} of {}", rig.frames.leads[c] - std::ranges::min(rig.frames.leads),
                                     rig.cameras[c].name));
    }
    diagnoses.push_back(
        {.id = "starts_differ",
         .cause = "the recordings start at different times. As the motion of the boards shows, these images "
                  "were taken together, and so on: number " +
                  join(together, ", ")});
  }
  if (rig.frames.time_spread > 0) {
    diagnoses.push_back(
        {.id = "times_differ",
         .cause = fmt::format("images were matched by the nearest times in their names; those of one frame "
                              "differ by up to {:.6g} in the names' unit",
                              rig.frames.time_spread)});
  }
  if (!rig.frames.unmatched.empty()) {
    diagnoses.push_back(
        {.id = "unmatched_images",
         .cause =
             fmt::format("{} image{} no other camera's image of the same instant; {} intrinsics only",
                         rig.frames.unmatched.size(), rig.frames.unmatched.size() == 1 ? " has" : "s have",
                         rig.frames.unmatched.size() == 1 ? "it serves" : "they serve"),
         .evidence = listedImages(rig, rig.frames.unmatched)});
  }
  for (const RigCamera& camera : rig.cameras) {
    const double more = camera.rms_px * camera.rms_px - camera.alone_rms_px * camera.alone_rms_px;
    const double effect_px = kRadius95 * std::sqrt(std::max(0.0, more));
    if (severityOf(effect_px, tolerance_px) == Severity::kNote) continue;
    diagnoses.push_back(
        {.id = "frames_disagree",
         .cause = fmt::format("{} has an RMS of {:.3f} px in the rig and of {:.3f} px alone", camera.name,
                              camera.rms_px, camera.alone_rms_px),
         .next_step = "trigger the cameras together, fix them to each other, and hold the board still",
         .effect_px = effect_px});
  }
}

// Milliseconds, or intervals between frames whose length is unknown.
std::string timeText(const RigFrames& frames, double intervals, double std) {
  const bool are_ms = frames.interval_s > 0;
  const double unit = are_ms ? frames.interval_s * kMillimetres : 1;
  const std::string spread = std > 0 ? fmt::format(" +- {:.2g}", std * unit) : "";
  return fmt::format("{:.3g}{} {}", intervals * unit, spread, are_ms ? "ms" : "intervals between frames");
}

// "b takes its images 118 +- 2 ms before a": what is not chance.
std::string delaysText(const RigCalibration& rig) {
  constexpr double kSure = 4;  // standard deviations
  std::vector<std::string> delays;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const double delay = rig.fit.cameras[c].delay;
    const double std = rig.cameras[c].link.delay_std_intervals;
    if (std > 0 && std::abs(delay) > kSure * std)
      delays.push_back(fmt::format("{} takes its images {} {} {}", rig.cameras[c].name,
                                   timeText(rig.frames, std::abs(delay), std), delay < 0 ? "before" : "after",
                                   rig.cameras.front().name));
  }
  return join(delays, ", ");
}

void judgeExposures(const RigCalibration& rig, double tolerance_px, std::vector<Diagnosis>& diagnoses) {
  if (!rig.exposure) return;
  double effect_px = 0;
  for (const RigCamera& camera : rig.cameras) effect_px = std::fmax(effect_px, camera.link.transfer_px);
  const std::string delays = delaysText(rig);
  diagnoses.push_back(
      {.id = "exposures_differ",
       .severity = std::min(Severity::kWarning, severityOf(effect_px, tolerance_px)),
       .cause = fmt::format(
           "the cameras do not take a frame at one instant, which moves the board by {:.2f} mm and "
           "its corners by {:.2f} px (RMS); this is taken into account",
           rig.exposure->shift_m * kMillimetres, rig.exposure->shift_px),
       .evidence = fmt::format("{}{}times scatter by {}", delays, delays.empty() ? "" : "; ",
                               timeText(rig.frames, rig.exposure->std_intervals, 0)),
       .next_step = "move the board slowly, hold it still for some frames, or trigger the cameras together",
       .effect_px = effect_px});
}

// What makes a pose that follows from motion more certain.
std::string motionAdvice(const RigCalibration& rig) {
  constexpr double kFarLess = 0.3;
  const RigTurns& turns = rig.links.turns;
  if (turns.second_rad > kFarLess * turns.main_rad)
    return "take more frames, and turn the rig relative to the boards farther about all axes";
  return "turn the rig relative to the boards about a second axis, too: it turned " +
         turnsText(turns, rig.cameras.front().name);
}

void judgeLinks(const RigCalibration& rig, double tolerance_px, std::vector<Diagnosis>& diagnoses) {
  for (const RigCamera& camera : rig.cameras) {
    const Severity severity = severityOf(camera.link.transfer_px, tolerance_px);
    if (severity == Severity::kNote) continue;
    const bool are_grazing = 2 * camera.link.num_grazing > camera.link.num_views;
    diagnoses.push_back(
        {.id = "weak_link",
         .severity = severity,
         .cause =
             fmt::format("mapping a point from '{}' to '{}' is uncertain by {:.2f} px (95 %) at the boards' "
                         "distance",
                         rig.cameras[camera.link.partner].name, camera.name, camera.link.transfer_px),
         .evidence = are_grazing ? fmt::format("{} of its {} common views are grazing",
                                               camera.link.num_grazing, camera.link.num_views)
                                 : "more than a quarter of the tolerance of " +
                                       numberText("%.3g", tolerance_px) + " px",
         .next_step = are_grazing ? "turn the board so that both cameras see it less obliquely"
                      : camera.link.is_by_motion
                          ? motionAdvice(rig)
                          : "take more frames that it shares with other cameras, near and far, tilted",
         .effect_px = camera.link.transfer_px});
  }
}

// Boards that are fixed to each other link cameras that see different ones.
void judgeMotionLinks(const RigCalibration& rig, std::vector<Diagnosis>& diagnoses) {
  if (rig.links.common_part_of.empty()) return;
  std::set<std::string> specs;
  for (const FitBoard& board : rig.fit.boards) specs.insert(board.target.spec());
  const bool are_prints = specs.size() < rig.fit.boards.size();
  diagnoses.push_back(
      {.id = "linked_by_motion",
       .cause =
           partsText(mapped(rig.cameras, &RigCamera::name), rig.links.common_part_of) +
           " see one board together in few frames or none: boards that do not move relative to each other "
           "link them" +
           (are_prints ? "; each part sees a print of the board of its own" : ""),
       .evidence = "between frames these turn " + turnsText(rig.links.turns, rig.cameras.front().name)});
}

// The part of the rig that each camera is in, by the links of all frames but one.
std::vector<std::size_t> partsWithout(std::size_t frame, const Fit& fit,
                                      const std::vector<std::vector<std::size_t>>& placements) {
  std::vector<std::size_t> part_of(fit.cameras.size());
  std::iota(part_of.begin(), part_of.end(), 0);
  for (std::size_t p = 0; p < placements.size(); ++p) {
    if (fit.placements[p].frame == frame) continue;
    for (const std::size_t v : placements[p]) {
      const std::size_t into = part_of[fit.views[placements[p].front()].camera];
      const std::size_t from = part_of[fit.views[v].camera];
      if (from != into) std::ranges::replace(part_of, from, into);
    }
  }
  return part_of;
}

// Boards of one frame always agree on some pose of the cameras, a wrong one if the frame is wrong.
void judgeLoneFrames(const RigCalibration& rig, std::vector<Diagnosis>& diagnoses) {
  const std::vector<std::vector<std::size_t>> placements = viewsOfPlacements(rig.fit);
  const std::vector<std::size_t> part_of = partsWithout(rig.frames.names.size(), rig.fit, placements);
  for (std::size_t frame = 0; frame < rig.frames.names.size(); ++frame) {
    const std::vector<std::size_t> without = partsWithout(frame, rig.fit, placements);
    if (without == part_of) continue;
    diagnoses.push_back(
        {.id = "unchecked_link",
         .cause =
             fmt::format("frame {} alone links {}: no other frame tells whether it is right",
                         rig.frames.names[frame], partsText(mapped(rig.cameras, &RigCamera::name), without)),
         .next_step = "take three or more frames in which cameras of these parts see the same board"});
  }
}

// Errors of the images in use do not predict those of the rig on others.
void judgeHoldout(const RigCalibration& rig, double tolerance_px, std::vector<Diagnosis>& diagnoses) {
  if (rig.holdout.num_corners == 0) {
    diagnoses.push_back({.id = "no_holdout",
                         .cause =
                             "there is no cross-validation: without a fifth of the frames, the others do not "
                             "determine the rig, or boards have too few corners",
                         .next_step = "take more frames"});
    return;
  }
  const double fitted_px = rms(rig.fit);
  const double more = rig.holdout.rms_px * rig.holdout.rms_px - fitted_px * fitted_px;
  const double effect_px = kRadius95 * std::sqrt(std::max(0.0, more));
  const bool are_many_unseen = 20 * rig.holdout.num_unseen > rig.holdout.num_corners;
  if (severityOf(effect_px, tolerance_px) == Severity::kNote && !are_many_unseen) return;
  diagnoses.push_back(
      {.id = "holdout_error",
       .severity = std::max(Severity::kWarning, severityOf(effect_px, tolerance_px)),
       .cause = more > 0
                    ? fmt::format("on frames that were left out, the RMS is {:.3f} px instead of {:.3f} px",
                                  rig.holdout.rms_px, fitted_px)
                    : std::string("many corners of frames that were left out cannot be predicted"),
       .evidence = rig.holdout.num_unseen > 0
                       ? fmt::format("{} corners have no error there", rig.holdout.num_unseen)
                       : "",
       .next_step = "take more frames, with boards tilted and in all parts of the images",
       .effect_px = effect_px});
}

// Two inputs with the same images give two cameras at one place, however bad the calibration is.
void judgeSameImages(const RigCalibration& rig, std::vector<Diagnosis>& diagnoses) {
  constexpr double kSamePx = 1e-6;
  std::map<std::pair<std::size_t, std::size_t>, std::pair<std::size_t, std::size_t>> counts;  // same, all
  for (const std::vector<std::size_t>& of_placement : viewsOfPlacements(rig.fit)) {
    for (std::size_t i = 0; i < of_placement.size(); ++i) {
      for (std::size_t k = i + 1; k < of_placement.size(); ++k) {
        const FitView& a = rig.fit.views[of_placement[i]];
        const FitView& b = rig.fit.views[of_placement[k]];
        if (a.camera == b.camera) continue;
        auto& [num_same, num_all] = counts[std::minmax(a.camera, b.camera)];
        ++num_all;
        const bool is_same = std::ranges::equal(a.corners, b.corners, [](const auto& one, const auto& other) {
          return one.id == other.id && (one.pixel - other.pixel).norm() < kSamePx;
        });
        if (is_same) ++num_same;
      }
    }
  }
  for (const auto& [cameras, count] : counts) {
    if (2 * count.first <= count.second) continue;
    diagnoses.push_back(
        {.id = "same_images",
         .cause = fmt::format("{} and {} have the same images: {} of {} common views agree to the last digit",
                              rig.cameras[cameras.first].name, rig.cameras[cameras.second].name, count.first,
                              count.second),
         .next_step = "give each camera its own images"});
  }
}

// The same camera twice, in other files or sizes, gives two cameras at one place.
void judgeBaselines(const RigCalibration& rig, std::vector<Diagnosis>& diagnoses) {
  constexpr double kChance = 16.27;  // exceeded by chi^2 with three degrees of freedom once in 1000
  if (!rig.covariance.isKnown()) return;
  for (std::size_t a = 0; a < rig.cameras.size(); ++a) {
    for (std::size_t b = a + 1; b < rig.cameras.size(); ++b) {
      const Baseline baseline = baselineOf(rig.fit, rig.covariance, a, b);
      if (!(baseline.vector_m.dot(baseline.covariance.ldlt().solve(baseline.vector_m)) < kChance)) continue;
      // The boards say nothing of places that are this uncertain, relative to their distance.
      constexpr double kUnknown = 0.1;
      const bool is_unknown =
          baseline.lengthStd() > kUnknown * rig.cameras[b].calibration.uncertainty.board_distance_m;
      diagnoses.push_back(
          {.id = "no_baseline",
           .cause = fmt::format("{} and {} may be {}", rig.cameras[a].name, rig.cameras[b].name,
                                is_unknown
                                    ? "anywhere: the frames hardly tell where they are relative to each other"
                                    : "the same camera twice: they are at the same place"),
           .evidence =
               fmt::format("{:.3f} mm apart, standard deviation {:.3f} mm",
                           kMillimetres * baseline.vector_m.norm(), kMillimetres * baseline.lengthStd()),
           .next_step = "give each camera its own images; cameras that are apart need more common frames"});
    }
  }
}

void judgeBoards(const RigCalibration& rig, std::vector<Diagnosis>& diagnoses) {
  if (!rig.are_points_lost) return;
  diagnoses.push_back(
      {.id = "points_lost",
       .cause = "a camera alone finds a board uneven, but no places of its points fit all cameras; the "
                "boards are taken as even",
       .next_step = "hold the board still while the cameras take a frame"});
}

void judgeGivenLenses(const RigCalibration& rig, double tolerance_px, std::vector<Diagnosis>& diagnoses) {
  for (const RigCamera& camera : rig.cameras) {
    if (!camera.given) continue;
    if (!rig.are_lenses_tested) {
      diagnoses.push_back(
          {.id = "given_lens_untested",
           .cause = fmt::format("these images do not tell whether the lens of {} is right: by themselves "
                                "they give no rig",
                                camera.name),
           .next_step = "take more frames"});
    }
    if (camera.misfit) {
      diagnoses.push_back(
          {.id = "given_lens_misfits",
           .severity = severityOf(camera.misfit->effect_px, tolerance_px),
           .cause = fmt::format("the images of {} contradict the lens of its camera file by {:.2f} px (95 %)",
                                camera.name, camera.misfit->effect_px),
           .evidence = fmt::format("RMS {:.3f} px with it, {:.3f} px with the lenses freed", camera.rms_px,
                                   camera.misfit->freed_rms_px),
           .next_step = "check that the files are in the order of the cameras; otherwise leave out --fixed",
           .effect_px = camera.misfit->effect_px});
    }
    const Verdict verdict =
        camera.given->calibration ? camera.given->calibration->verdict : Verdict::kTrustworthy;
    if (verdict == Verdict::kTrustworthy) continue;
    diagnoses.push_back(
        {.id = "given_lens_verdict",
         .severity = verdict == Verdict::kNo ? Severity::kFailure : Severity::kWarning,
         .cause = fmt::format("the camera file of {} says of itself: {}", camera.name, verdictName(verdict)),
         .next_step = "calibrate it again, or leave out --fixed"});
  }
}

}  // namespace

double foundErrorPx(const RigCamera& camera) {
  double most = camera.misfit ? camera.misfit->effect_px : 0;
  for (const Diagnosis& diagnosis : camera.calibration.diagnoses) {
    // Consequences describe other parts of the image, or what the covariance contains, as it does single
    // views.
    const DiagnosisKind kind = diagnosis.id.kind();
    const bool is_of_lens = kind.subject == Subject::kLens && !camera.given;
    if ((is_of_lens || kind.subject == Subject::kBoard) && kind.rank != Rank::kConsequence)
      most = std::fmax(most, diagnosis.effect_px);
  }
  return most;
}

std::vector<Diagnosis> judgeRig(const RigCalibration& rig, double tolerance_px) {
  std::vector<Diagnosis> diagnoses;
  judgeFit(rig, diagnoses);
  judgeMotions(rig, tolerance_px, diagnoses);
  judgeFrames(rig, tolerance_px, diagnoses);
  judgeExposures(rig, tolerance_px, diagnoses);
  judgeLinks(rig, tolerance_px, diagnoses);
  judgeLoneFrames(rig, diagnoses);
  judgeMotionLinks(rig, diagnoses);
  judgeHoldout(rig, tolerance_px, diagnoses);
  judgeSameImages(rig, diagnoses);
  judgeBaselines(rig, diagnoses);
  judgeBoards(rig, diagnoses);
  judgeGivenLenses(rig, tolerance_px, diagnoses);
  for (const RigCamera& camera : rig.cameras) {
    for (Diagnosis diagnosis : camera.calibration.diagnoses) {
      if (camera.given && diagnosis.id.kind().subject == Subject::kLens) continue;
      diagnosis.cause = camera.name + ": " + diagnosis.cause;
      // A rig has no suggestion for the next view.
      if (diagnosis.id == DiagnosisId("poor_coverage"))
        diagnosis.next_step = "run alidade calibrate on the images of this camera to see which view to add";
      diagnoses.push_back(std::move(diagnosis));
    }
  }
  sortDiagnoses(diagnoses);
  return diagnoses;
}

}  // namespace alidade
