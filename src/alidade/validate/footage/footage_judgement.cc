// SPDX-License-Identifier: MIT
#include "alidade/validate/footage/footage_judgement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "alidade/core/size_groups.h"
#include "alidade/core/statistics.h"
#include "alidade/core/text.h"

namespace alidade {
namespace {

ImageSize turnedSize(ImageSize size) {
  return {.width = size.height, .height = size.width};
}

bool isUpright(ImageSize size) {
  return size.height > size.width;
}

// True if one size is a resized version of the other; a side may be rounded.
bool haveOneShape(ImageSize a, ImageSize b) {
  const double scale = static_cast<double>(b.width) / a.width;
  return std::abs(a.height * scale - b.height) <= 0.5 * std::max(1.0, scale);
}

PixelRect centred(ImageSize image, ImageSize part) {
  return {.x = (image.width - part.width) / 2,
          .y = (image.height - part.height) / 2,
          .width = part.width,
          .height = part.height};
}

// The largest centred part with the aspect ratio of a second image.
PixelRect centredPartOfShape(ImageSize image, ImageSize shape) {
  const auto side = [](std::int64_t length, std::int64_t over, std::int64_t under) {
    return static_cast<int>(std::max<std::int64_t>(1, (2 * length * over + under) / (2 * under)));
  };
  const bool is_wider = std::int64_t{shape.width} * image.height > std::int64_t{image.width} * shape.height;
  const ImageSize part = is_wider ? ImageSize{image.width, side(image.width, shape.height, shape.width)}
                                  : ImageSize{side(image.height, shape.width, shape.height), image.height};
  return centred(image, part);
}

ConversionRequest requestOf(std::optional<PixelRect> crop, std::optional<ImageSize> resize) {
  ConversionRequest request;
  request.crop = crop;
  request.resize = resize;
  return request;
}

// Edits without rotation, the most common ones first.
std::vector<ConversionRequest> plainEdits(ImageSize from, ImageSize to) {
  if (from == to) return {ConversionRequest{}};
  std::vector<ConversionRequest> edits;
  const bool has_shape = haveOneShape(from, to);
  if (has_shape) edits.push_back(requestOf({}, to));
  if (to.width <= from.width && to.height <= from.height) edits.push_back(requestOf(centred(from, to), {}));
  if (!has_shape) {
    edits.push_back(requestOf(centredPartOfShape(from, to), to));
    edits.push_back(requestOf({}, to));  // stretched
    // If nothing is left to resize, the crop and the part of that shape are the same.
    std::erase_if(edits, [&](const ConversionRequest& edit) {
      return edit.crop && edit.resize && ImageSize{edit.crop->width, edit.crop->height} == to;
    });
  }
  return edits;
}

// A smaller readout has no effect and is indistinguishable from none.
constexpr double kLittleReadout = 0.1;

std::string pixelsOf(double px) {
  if (px < 1) return fmt::format("{:.2g} px", px);
  return px < 10 ? fmt::format("{:.1f} px", px) : fmt::format("{:.0f} px", px);
}

// Reason why footage cannot decide, and what to film instead: "no parallax; film while moving sideways past
// near and far things".
std::string gapWords(const FootageJudgement& judgement) {
  const FootageCheck& check = judgement.check;
  switch (check.gap) {
    case FootageGap::kFewPoints:
      return "too few points can be followed; film a scene full of detail, bright and in focus, and move "
             "slowly";
    case FootageGap::kNoMotion:
      return judgement.num_frames_given < 2 ? "only one image; take several, from different places"
                                            : "all images show the same; move the camera while filming";
    case FootageGap::kNoParallax:
      return "no parallax; film while moving sideways past near and far things";
    case FootageGap::kMovingScene:
      return "too few points agree with one motion of the camera; film a scene in which nothing moves. (A "
             "camera file that is far off may do this too.)";
    case FootageGap::kNone:
    case FootageGap::kFewFrames:
      return "fewer than five images show a scene together; take more of it, from different places";
    case FootageGap::kUnsolved:
      return "another value that may explain the footage could not be computed; use other footage, or test "
             "with a board (--images)";
    case FootageGap::kShutter:
      return "what explains the footage best reads the rows of a frame more slowly than any camera; the video "
             "may be stabilised, cut or converted to another frame rate; take it as the camera wrote it";
    case FootageGap::kInstants:
    case FootageGap::kWeak:
      break;
  }
  const std::string size = std::isfinite(check.blind_px)
                               ? ": an error of " + pixelsOf(check.blind_px) + " would go unnoticed"
                               : "";
  return "the motion leaves the camera open" + size +
         "; film longer, moving sideways past near and far things and turning the camera";
}

bool hasDistortion(const AnyCamera& camera) {
  const auto params = camera.parameters();
  return std::any_of(params.begin() + 4, params.end(), [](double value) { return value != 0; });
}

Diagnosis findingOfCamera(const FootageJudgement& judgement, const AnyCamera& file) {
  const FootageCheck& check = judgement.check;
  Diagnosis finding{.id = "footage", .cause = ""};
  switch (check.verdict) {
    case FootageVerdict::kConsistent:
      finding.severity = Severity::kPass;
      finding.cause =
          fmt::format("consistent: no {}; one below {} would go unnoticed",
                      check.explanation ? "error that counts" : "sign of an error", pixelsOf(check.blind_px));
      break;
    case FootageVerdict::kInconsistent: {
      const CameraChange& change = check.changes.at(check.explanation.value());
      finding.severity = Severity::kFailure;
      finding.effect_px = change.effect_px;
      finding.cause = fmt::format("inconsistent: {} explains the footage; displaces points by {}",
                                  describe(change), pixelsOf(change.effect_px));
      finding.next_step = likelyCause(change, file);
      break;
    }
    case FootageVerdict::kCannotTell:
      finding.severity = Severity::kWarning;
      finding.is_undecided = true;
      finding.cause = "cannot tell: " + gapWords(judgement);
      break;
  }
  return finding;
}

std::string convertCommand(const FootageEdit& edit, const std::string& file) {
  return fmt::format("alidade convert {} -o OUT {}", file, editFlags(edit.request));
}

// Reports that image sizes of footage and file differ, and which edit explains it.
Diagnosis findingOfSize(const FootageJudgement& judgement, const std::string& file) {
  const std::string sizes = fmt::format("the images have {} px, the file is for {}",
                                        sizeText(judgement.image_size), sizeText(judgement.camera_size));
  Diagnosis finding{.id = "footage", .severity = Severity::kFailure, .cause = ""};
  if (const FootageEdit* const found = judgement.foundEdit()) {
    finding.cause =
        fmt::format("inconsistent: image {} without the file; {}", editWords(found->request), sizes);
    finding.next_step = convertCommand(*found, file);
    for (const FootageEdit& edit : judgement.edits) {
      if (&edit != found && edit.check.verdict == FootageVerdict::kConsistent)
        finding.next_step += fmt::format("; {} is consistent too", editFlags(edit.request));
    }
    return finding;
  }
  std::vector<std::string> undecided;
  for (const FootageEdit& edit : judgement.edits) {
    if (edit.check.verdict == FootageVerdict::kCannotTell) undecided.push_back(editFlags(edit.request));
  }
  finding.cause = "inconsistent: wrong image size; " + sizes;
  if (undecided.empty()) {
    finding.cause +=
        judgement.edits.empty() ? "" : ", and neither cropped nor resized does it agree with the footage";
    finding.next_step = "use the camera file of these images, or calibrate with images of this size";
  } else {
    finding.cause +=
        fmt::format("; the footage cannot tell what was done to the images: {}", gapWords(judgement));
    finding.next_step =
        fmt::format("test with other footage, or convert the file: alidade convert {} -o OUT {}", file,
                    join(undecided, ", or "));
  }
  return finding;
}

}  // namespace

const FootageEdit* FootageJudgement::foundEdit() const {
  const bool is_found = !edits.empty() && edits.front().check.verdict == FootageVerdict::kConsistent;
  return is_found ? &edits.front() : nullptr;
}

FootageVerdict FootageJudgement::verdict() const {
  return isOtherSize() ? FootageVerdict::kInconsistent : check.verdict;
}

std::vector<ConversionRequest> editsBetween(ImageSize from, ImageSize to) {
  if (from == to) return {};
  if (isUpright(from) == isUpright(to)) return plainEdits(from, to);
  std::vector<ConversionRequest> edits;
  for (const ConversionRequest& plain : plainEdits(from, turnedSize(to))) {
    for (const int degrees : {90, 270}) {
      edits.push_back(plain);
      edits.back().rotate_deg = degrees;
    }
  }
  if (to.width <= from.width && to.height <= from.height) edits.push_back(requestOf(centred(from, to), {}));
  return edits;
}

std::string editWords(const ConversionRequest& edit) {
  std::string words;
  const auto add = [&](const char* word) { words += (words.empty() ? "" : " and ") + std::string(word); };
  if (edit.crop) add("cropped");
  if (edit.resize) add("resized");
  if (edit.rotate_deg) add("rotated");
  return words;
}

std::string editFlags(const ConversionRequest& edit) {
  std::vector<std::string> flags;
  if (edit.crop) {
    flags.push_back(
        fmt::format("--crop {},{},{},{}", edit.crop->x, edit.crop->y, edit.crop->width, edit.crop->height));
  }
  if (edit.resize) flags.push_back("--resize " + sizeText(*edit.resize));
  if (edit.rotate_deg) flags.push_back(fmt::format("--rotate {}", *edit.rotate_deg));
  return join(flags, " ");
}

FootageJudgement judgeOnFootage(const CameraRecord& camera, const FootageTracks& tracks,
                                const FootageCheckOptions& options, std::size_t num_frames_given) {
  FootageJudgement judgement{.camera_size = camera.image_size,
                             .image_size = tracks.size,
                             .num_frames_given = num_frames_given,
                             .check = {}};
  if (!judgement.isOtherSize()) {
    judgement.check = checkOnFootage(camera.camera, tracks, options);
    return judgement;
  }
  for (ConversionRequest& edit : editsBetween(camera.image_size, tracks.size)) {
    FootageCheck check = checkOnFootage(convertCamera(camera, edit).camera(), tracks, options);
    judgement.edits.push_back({.request = std::move(edit), .check = std::move(check)});
  }
  std::ranges::stable_sort(judgement.edits, [](const FootageEdit& a, const FootageEdit& b) {
    if (a.check.verdict != b.check.verdict) return a.check.verdict < b.check.verdict;
    return a.check.verdict == FootageVerdict::kConsistent && a.check.holdout_rms_px < b.check.holdout_rms_px;
  });
  if (!judgement.edits.empty()) judgement.check = judgement.edits.front().check;
  return judgement;
}

std::string likelyCause(const CameraChange& change, const AnyCamera& file) {
  switch (change.kind) {
    case CameraChangeKind::kFocalLength:
      return "the zoom or the focus is another one, or the images were cropped and scaled, as stabilised "
             "videos are; calibrate again with these settings";
    case CameraChangeKind::kAspect:
      return "the images were stretched in one direction; calibrate again with such images, or make them "
             "without stretching";
    case CameraChangeKind::kPrincipalPoint:
      return "the images were cropped off the centre, or stabilised; calibrate with images as they are, or "
             "adapt the file (alidade convert --crop)";
    case CameraChangeKind::kDistortion:
      if (std::abs(1 + change.amounts.at(0)) <= kNormal95 * change.std.at(0))
        return "the images are already undistorted; use the camera file that undistort wrote beside them";
      return "another lens or another focus, or images that were partly corrected; calibrate again";
    case CameraChangeKind::kFirstRadial:
      if (!hasDistortion(file)) return "the file has no distortion, but the images have; calibrate the lens";
      return "another lens or another focus, or images that were partly corrected; calibrate again";
    default:
      break;
  }
  return "another camera or lens, or a file for other settings; calibrate this camera";
}

std::vector<Diagnosis> footageFindings(const FootageJudgement& judgement, const CameraRecord& camera,
                                       const std::string& file) {
  const FootageCheck& check = judgement.check;
  std::vector<Diagnosis> findings = {judgement.isOtherSize() ? findingOfSize(judgement, file)
                                                             : findingOfCamera(judgement, camera.camera)};
  if (check.verdict == FootageVerdict::kConsistent && check.explanation) {
    const CameraChange& change = check.changes.at(*check.explanation);
    findings.push_back(
        {.id = "footage_fit",
         .cause = fmt::format("{} fits better; displaces points by {}, surely by {}; not enough to call the "
                              "file wrong",
                              describe(change), pixelsOf(change.effect_px), pixelsOf(change.sure_px)),
         .effect_px = change.effect_px});
  }
  // With a wrong camera the readout compensates for part of the error.
  if (check.verdict == FootageVerdict::kConsistent && check.is_video &&
      std::abs(check.readout) > kLittleReadout) {
    findings.push_back(
        {.id = "footage_shutter",
         .cause = fmt::format("rolling shutter: from the first row to the last in {:.2f} of the time between "
                              "frames; taken into account",
                              check.readout)});
  }
  return findings;
}

}  // namespace alidade
