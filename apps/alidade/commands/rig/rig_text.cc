// SPDX-License-Identifier: MIT
#include "commands/rig/rig_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "alidade/adjust/board/errors.h"
#include "alidade/core/degrees.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/report/data/evidence.h"
#include "command.h"
#include "console.h"
#include "summary_lines.h"

namespace alidade {
namespace {

constexpr double kMillimetres = 1000;

std::string transferText(const RigCalibration& rig) {
  const RigCamera* worst = nullptr;
  for (const RigCamera& camera : rig.cameras) {
    if (!std::isfinite(camera.link.transfer_px)) continue;
    if (worst == nullptr || camera.link.transfer_px > worst->link.transfer_px) worst = &camera;
  }
  if (worst == nullptr) return "unknown: the frames do not determine the poses of the cameras";
  return fmt::format("within {} (95 %) from one camera to another at the boards' distance; worst {}",
                     pixels(worst->link.transfer_px), worst->name);
}

std::string countText(std::size_t n, const std::string& one, const std::string& many) {
  return n == 0 ? "" : fmt::format("; {} {}", n, n == 1 ? one : many);
}

std::string fitTextOfRig(const RigCalibration& rig, int num_frames) {
  std::size_t num_outliers = 0;
  std::size_t num_left_out = 0;
  std::size_t num_repeated = 0;
  for (const RigCamera& camera : rig.cameras) {
    num_outliers += camera.alone.dropped.outliers.size();
    num_left_out += camera.alone.dropped.views.size();
    num_repeated += camera.alone.dropped.repeated.size();
  }
  return fmt::format(
             "{} cameras; {} seen by two or more, in {}; RMS {:.3f} px, cross-validation {}",
             rig.cameras.size(), counted(rig.links.num_linked, "board"), counted(num_frames, "frame"),
             rms(rig.fit),
             rig.holdout.num_corners > 0 ? fmt::format("{:.3f} px", rig.holdout.rms_px) : "impossible") +
         (rig.frames.time_spread > 0 ? "; matched by nearest times" : "") +
         countText(rig.frames.unmatched.size(), "image without a partner", "images without a partner") +
         countText(rig.links.unlinked.size(), "view contradicts its frame", "views contradict their frames") +
         countText(num_left_out, "view left out", "views left out") +
         countText(num_repeated, "repeated view averaged", "repeated views averaged") +
         countText(num_outliers, "outlier", "outliers") +
         countText(rig.links.num_renumbered, "view of an ambiguous board renumbered",
                   "views of an ambiguous board renumbered");
}

std::string imagesText(const RigCamera& camera, const GivenViews& given) {
  return fmt::format("corners in {} of {} images", numImagesUsed(camera.calibration), given.num_images);
}

std::string cameraText(const RigCalibration& rig, std::size_t index, const GivenViews& given) {
  const RigCamera& camera = rig.cameras[index];
  const FitCamera& fitted = rig.fit.cameras[index];
  std::string text = fmt::format("{}: {}{}, {} px; {}; RMS {:.3f} px (alone {:.3f})", camera.name,
                                 fitted.model, camera.given ? " (fixed)" : "", sizeText(fitted.size),
                                 imagesText(camera, given), camera.rms_px, camera.alone_rms_px);
  if (std::isfinite(camera.link.transfer_px))
    text += "; from its neighbour within " + pixels(camera.link.transfer_px);
  if (index == 0) return text;
  const double std_mm = camera.link.distance_std_m * kMillimetres;
  const int decimals = decimalsFor(std_mm, 3);
  return text +
         fmt::format("; {:.{}f} mm from {}", fitted.camera_from_rig.translation.norm() * kMillimetres,
                     decimals, rig.cameras.front().name) +
         (std_mm > 0 ? fmt::format(" (standard deviation {:.{}f} mm)", std_mm, decimals) : "");
}

// True if the diagnosis is about the given images and not about the rig.
bool isOfInput(const Diagnosis& diagnosis) {
  return diagnosis.severity == Severity::kNote && diagnosis.id.kind().subject == Subject::kMatching;
}

std::string nextStepText(const RigCalibration& rig) {
  if (rig.isUsable()) return "test the rig on other frames: alidade rig validate";
  return "correct the failures above and calibrate again; --report page.html shows each frame";
}

std::string poseText(const RigCamera& camera, const SE3& camera_from_rig) {
  const Eigen::Vector3d origin = camera_from_rig.inverse().translation * kMillimetres;
  return fmt::format(
      "at ({:.1f}, {:.1f}, {:.1f}) mm, {:.2f} mm from the first camera, turned by {:.3f} degrees; standard "
      "deviation {:.2f} mm, {:.3f} degrees",
      origin.x(), origin.y(), origin.z(), origin.norm(), camera_from_rig.rotation.log().norm() * kDegPerRad,
      camera.link.position_std_m.norm() * kMillimetres, camera.link.rotation_std_rad.norm() * kDegPerRad);
}

std::string imageList(const RigCalibration& rig, const std::string& title,
                      const std::vector<RigImage>& images) {
  if (images.empty()) return "";
  return title + "\n" + listed(mapped(images, [&](const RigImage& image) {
           return printable(
               fmt::format("{}/{} (frame {})", rig.cameras[image.camera].name, image.image, image.frame));
         }));
}

}  // namespace

std::string rigSummaryText(const RigCalibration& rig, const std::vector<GivenViews>& given, int num_frames,
                           bool is_coloured) {
  Lines lines = wrapped("Verdict", verdictText(rig.verdict(), "rig", is_coloured));
  append(lines, wrapped("Accuracy", transferText(rig)));
  Lines rest = wrapped("Rig", fitTextOfRig(rig, num_frames));
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    append(rest, wrapped(c == 0 ? "Camera" : "", cameraText(rig, c, given[c])));
  append(rest, boardLines(rig.fit, rig.fit.boards.size() > 1 ? 2 : 1));
  append(rest, wrapped("Next", nextStepText(rig)));
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    if (diagnosis.severity == Severity::kFailure) append(lines, diagnosisLines(diagnosis));
  }
  // Warnings, and notes on the inputs, get the remaining lines; those that do not fit are counted. The first
  // warning is always shown, however many cameras there are.
  constexpr std::size_t kLinesOfAWarning = 3;
  const std::size_t num_reserved = lines.size() + rest.size() + 1;
  std::size_t room = std::max(kLinesOfAWarning, kMaxLines - std::min(num_reserved, kMaxLines));
  std::size_t num_untold = 0;
  std::size_t num_notes = 0;
  for (const Diagnosis& diagnosis : rig.diagnoses) {
    if (diagnosis.severity == Severity::kFailure) continue;
    const bool is_warning = diagnosis.severity == Severity::kWarning;
    const Lines told = is_warning || isOfInput(diagnosis) ? diagnosisLines(diagnosis) : Lines();
    if (told.empty() || told.size() > room) {
      ++(is_warning ? num_untold : num_notes);
      continue;
    }
    room -= told.size();
    append(lines, told);
  }
  append(lines, rest);
  append(lines, moreLines(num_untold, num_notes));
  return join(lines, "\n") + "\n";
}

std::string rigDetailsText(const RigCalibration& rig, const std::vector<GivenViews>& given) {
  std::string text;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    text += fmt::format("{}\n", printable(camera.name));
    Lines lines = wrapped("Images", fmt::format("{} given, {} with a board, {} used", given[c].num_images,
                                                given[c].num_found, numImagesUsed(camera.calibration)));
    append(lines, parameterLines(camera.calibration));
    if (c > 0) append(lines, wrapped("Pose", poseText(camera, rig.fit.cameras[c].camera_from_rig)));
    for (const std::string& note : given[c].notes) append(lines, wrapped("Note", note));
    text += join(lines, "\n") + "\n" + listed(given[c].reasons) + outliersText(camera.calibration);
  }
  text += imageList(rig, "Images without one of another camera", rig.frames.unmatched);
  text += imageList(rig, "Views that contradict their frames", rig.links.unlinked);
  return text + diagnosesText(rig.diagnoses);
}

}  // namespace alidade
