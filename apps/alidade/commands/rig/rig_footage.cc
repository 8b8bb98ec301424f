// SPDX-License-Identifier: MIT
#include "commands/rig/rig_footage.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include <fmt/format.h>

#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/parallel.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/frame_table_file.h"
#include "alidade/imagery/image_file.h"
#include "alidade/imagery/image_list.h"
#include "alidade/report/data/json_output.h"
#include "alidade/rig/rig_frames.h"
#include "command.h"
#include "console.h"
#include "summary_lines.h"

namespace alidade {
namespace {

constexpr std::size_t kMostInstants = 40;
// Depth errors (along the rows) above which a note says that the images do not determine them.
constexpr double kOpenPx = 5;

void requireFootage(const RigRecord& rig, const RigInputs& inputs) {
  if (rig.cameras.size() < 2) {
    throw inputError({.where = "rig validate",
                      .found = "a rig with one camera",
                      .expected = "two or more, whose relative pose can be tested",
                      .next_step = "test the camera alone: alidade validate FILE --footage IMAGES"});
  }
  if (!inputs.boards.empty()) {
    throw flagError("rig validate", "--board with --footage",
                    "--board for images of a board, or --footage for any other images");
  }
  for (const std::string& input : inputs.inputs) {
    if (!isCornersFile(input)) continue;
    throw flagError("--footage: " + input, "a corners file", "a folder of images, or a pattern in quotes");
  }
}

// The images of one instant: one path per camera, or nothing.
using Instant = std::vector<std::string>;

std::vector<Instant> instantsOf(const RigRecord& rig, const RigInputs& inputs, bool is_quiet) {
  std::vector<RigViews> cameras;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    RigViews& camera = cameras.emplace_back();
    camera.name = rig.cameras[c].camera.name.name;
    camera.paths = listImages({&inputs.inputs[c], 1});
    camera.images = shortNames(camera.paths);
    for (const std::string& image : camera.images) camera.views.push_back({.image = image});
  }
  const FrameTable table = inputs.match.empty() ? FrameTable() : readFrameTable(inputs.match);
  const RigFrames frames = table.empty() ? matchFrames(cameras) : framesOf(table, cameras);
  if (!frames.unmatched.empty() && !is_quiet) {
    const RigImage& first = frames.unmatched.front();
    printMessage(
        fmt::format("note: {} without one of the same instant by another camera, for example {} of "
                    "{}: not used",
                    counted(frames.unmatched.size(), "image"), first.image, cameras[first.camera].name));
  }
  std::vector<Instant> instants(frames.names.size(), Instant(cameras.size()));
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (std::size_t i = 0; i < cameras[c].paths.size(); ++i)
      instants[frames.frame_of[c][i]][c] = cameras[c].paths[i];
  }
  std::erase_if(instants, [](const Instant& instant) {
    return std::ranges::count(instant, "") + 1 >= std::ssize(instant);
  });
  if (instants.size() <= kMostInstants) return instants;
  if (!is_quiet)
    printMessage(
        fmt::format("note: {} of {} instants are used, evenly spaced", kMostInstants, instants.size()));
  std::vector<Instant> some;
  for (std::size_t k = 0; k < kMostInstants; ++k)
    some.push_back(instants[k * instants.size() / kMostInstants]);
  return some;
}

GrayImage readImageOf(const CameraRecord& camera, const std::string& path) {
  GrayImage image = readGrayImage(path).image;
  if (image.size == camera.image_size) return image;
  throw inputError({.where = path,
                    .found = sizeText(image.size) + " pixels",
                    .expected = fmt::format("{}, as the rig file says of camera {}",
                                            sizeText(camera.image_size), camera.name.name),
                    .next_step = "adapt the rig file (alidade convert --resize or --crop), or give the "
                                 "images of this camera"});
}

std::string pixelWords(double px) {
  return fmt::format("{:.{}f} px", px, px < 10 ? 2 : 0);
}

std::string nextStepOf(const RigPairCheck& pair) {
  if (pair.is_behind) return "check that each folder belongs to its camera; if so, calibrate the rig again";
  const RigChange& change = pair.changes.at(pair.explanation.value());
  switch (change.kind) {
    case CameraChangeKind::kRotation:
    case CameraChangeKind::kPosition:
    case CameraChangeKind::kPose:
      return "a camera was moved or its mount gave way, or the images were not taken at the same time; "
             "fasten it and calibrate the rig again";
    case CameraChangeKind::kFocalLength:
      return "the zoom or the focus is another one, or images were cropped and scaled; calibrate again with "
             "these settings";
    case CameraChangeKind::kDistortion:
    case CameraChangeKind::kFirstRadial:
      return "another lens or focus, images that are already undistorted, or a file without its distortion; "
             "calibrate again, or give the images as the camera took them";
    case CameraChangeKind::kPrincipalPoint:
      return "images were cropped off the centre or stabilised; give the images as the camera took them";
    default:
      break;
  }
  return "the rig file is of other cameras or settings; calibrate the rig again";
}

std::string gapText(const RigPairCheck& pair) {
  switch (pair.gap) {
    case FootageGap::kFewPoints:
    case FootageGap::kNoMotion:
      return fmt::format("too few matches ({}); take images full of detail that both cameras see",
                         pair.num_matches);
    case FootageGap::kMovingScene:
      return fmt::format(
          "only {:.0f} % of {} matches agree with one pose; give images of the same instant, full of detail. "
          "(A rig file that is far off may do this too.)",
          100 * (1 - pair.outlier_share), pair.num_matches);
    case FootageGap::kNoParallax:
      return "all points are far away, so the direction of the baseline is open; show things nearer than 10 "
             "baselines";
    case FootageGap::kNone:
    case FootageGap::kFewFrames:
      return fmt::format("{} with enough matches; take three or more, of different scenes",
                         counted(pair.num_instants, "instant"));
    case FootageGap::kUnsolved:
      return "another value that may explain the images could not be computed; take other images, or test "
             "with a board";
    case FootageGap::kInstants:
      return "the images may not be of one instant: a pose of its own for each pair explains them better than "
             "any change of the rig; trigger the cameras together, or keep rig and scene still, and check "
             "that no mount gives way";
    case FootageGap::kShutter:
    case FootageGap::kWeak:
      break;
  }
  if (!pair.changes.empty() && !std::isfinite(pair.blind_px))
    return "an error of any size could go unnoticed; take more images, with detail in all parts of both";
  return pair.changes.empty() ? "the two cameras are at one place, so that their images show no parallax"
                              : "an error of " + pixelWords(pair.blind_px) +
                                    " would go unnoticed; take more images, with detail in all parts of both";
}

std::string foundText(const RigPairCheck& pair, std::string_view first, std::string_view second) {
  if (pair.is_behind)
    return "most points lie behind the cameras: the images were exchanged, or a camera was turned or its "
           "image shifted along the rows";
  const RigChange& change = pair.changes.at(pair.explanation.value());
  std::string text = fmt::format("{} explains the images; rows differ by {}", describe(change, first, second),
                                 pixelWords(change.effect_px));
  if (!pair.alternatives.empty()) {
    const auto others =
        mapped(pair.alternatives, [&](std::size_t i) { return describe(pair.changes[i], first, second); });
    text += "; nearly as well does: " + join(others, "; or ");
  }
  return text;
}

Lines pairLines(const RigPairCheck& pair, std::string_view first, std::string_view second) {
  std::string text = fmt::format("{}, {}: ", first, second);
  if (pair.verdict == FootageVerdict::kConsistent) {
    text +=
        fmt::format("consistent: no {}; one that displaces rows by less than {} would go unnoticed",
                    pair.explanation ? "error that counts" : "sign of an error", pixelWords(pair.blind_px));
  } else {
    text += pair.verdict == FootageVerdict::kInconsistent ? "inconsistent: " + foundText(pair, first, second)
                                                          : "cannot tell: " + gapText(pair);
  }
  Lines lines = wrapped("Pair", text);
  if (!pair.changes.empty() || pair.is_behind) {
    addLines(lines, "",
             "{}, {} of {} matches; epipolar error {:.2f} px RMS, noise {:.2f} px; parallax {:.0f} px",
             counted(pair.num_instants, "instant"), pair.num_used, pair.num_matches, pair.rms_px,
             pair.noise_px, pair.parallax_px);
  }
  if (pair.verdict == FootageVerdict::kInconsistent) append(lines, wrapped("", "next: " + nextStepOf(pair)));
  if (pair.verdict != FootageVerdict::kInconsistent && pair.explanation) {
    const RigChange& change = pair.changes[*pair.explanation];
    addLines(lines, "Note", "{} fits better; rows differ by {}, which is not enough to call the file wrong",
             describe(change, first, second), pixelWords(change.effect_px));
  }
  if (pair.verdict != FootageVerdict::kConsistent) return lines;
  std::vector<std::string> open;
  for (const RigChange& change : pair.changes) {
    const bool is_turn = change.kind == CameraChangeKind::kRotation;
    if (!(change.depth_blind_px > kOpenPx) || (!is_turn && change.kind != CameraChangeKind::kFocalLength))
      continue;
    const std::string_view of = change.side == PairSide::kBoth    ? "both"
                                : change.side == PairSide::kFirst ? first
                                                                  : second;
    open.push_back(fmt::format("the {} of {}", is_turn ? "direction" : "focal length", of));
  }
  if (!open.empty())
    append(lines, wrapped("Note", "the images leave open, because it moves points along their rows: " +
                                      join(open, ", ")));
  return lines;
}

std::string_view sideId(PairSide side) {
  return side == PairSide::kFirst ? "first" : side == PairSide::kSecond ? "second" : "both";
}

json changeJson(const RigChange& change, std::string_view first, std::string_view second) {
  const Eigen::Vector3d w = change.pair.second_from_first.rotation.log();
  return {{"id", changeId(change.kind)},
          {"camera", sideId(change.side)},
          {"text", describe(change, first, second)},
          {"amounts", change.amounts},
          {"std", change.std},
          {"rms_px", change.rms_px},
          {"cost_drop", change.cost_drop},
          {"gain", change.gain},
          {"score", change.score},
          {"effect_px", change.effect_px},
          {"sure_px", change.sure_px},
          {"blind_px", change.blind_px},
          {"depth_blind_px", change.depth_blind_px},
          {"rotation_rad", vectorJson(w)},
          {"direction", vectorJson(Eigen::Vector3d(change.pair.second_from_first.translation))}};
}

}  // namespace

std::vector<RigPairMatches> matchRigFootage(const RigRecord& rig, const RigInputs& inputs,
                                            const CommonOptions& common) {
  requireFootage(rig, inputs);
  const std::vector<Instant> instants = instantsOf(rig, inputs, common.quiet);
  const std::size_t num_cameras = rig.cameras.size();
  std::vector<RigPairMatches> pairs;
  for (std::size_t i = 0; i < num_cameras; ++i) {
    for (std::size_t j = i + 1; j < num_cameras; ++j) {
      const bool is_seen = std::ranges::any_of(
          instants, [&](const Instant& instant) { return !instant[i].empty() && !instant[j].empty(); });
      if (is_seen) pairs.push_back({i, j, std::vector<std::vector<PixelMatch>>(instants.size())});
    }
  }
  constexpr std::size_t kPoints = 1000;
  ProgressBar bar("matching images", common.quiet);
  std::mutex mutex;
  std::size_t num_done = 0;
  parallelFor(
      instants.size(), common.jobs,
      [&](std::size_t k) {
        std::vector<GrayImage> images(num_cameras);
        for (std::size_t c = 0; c < num_cameras; ++c) {
          if (!instants[k][c].empty()) images[c] = readImageOf(rig.cameras[c].camera, instants[k][c]);
        }
        for (RigPairMatches& pair : pairs) {
          const GrayImage& first = images[pair.first];
          const GrayImage& second = images[pair.second];
          if (!first.empty() && !second.empty()) pair.instants[k] = matchImages(first, second, kPoints);
        }
        const std::scoped_lock lock(mutex);
        bar.update(++num_done, instants.size());
      },
      common.cancel);
  return pairs;
}

std::string rigContradiction(const RigCheck& check, const AnyRig& rig) {
  const auto wrong = std::ranges::find(check.pairs, FootageVerdict::kInconsistent, &RigPairCheck::verdict);
  return foundText(*wrong, rig.camera(wrong->first).name, rig.camera(wrong->second).name);
}

std::string rigFootageText(const RigCheck& check, const AnyRig& rig) {
  const std::string verdict =
      check.verdict == FootageVerdict::kConsistent     ? "consistent: the images agree with the rig"
      : check.verdict == FootageVerdict::kInconsistent ? "inconsistent: the images contradict the rig"
      : check.pairs.size() == 1                        ? "cannot tell: these images would not show an error"
                                : "cannot tell: consistent pairs do not connect all cameras";
  Lines lines = wrapped("Verdict", verdict);
  for (const RigPairCheck& pair : check.pairs)
    append(lines, pairLines(pair, rig.camera(pair.first).name, rig.camera(pair.second).name));
  return join(lines, "\n") + "\n";
}

std::string rigFootageJson(const RigCheck& check, std::size_t num_instants, const AnyRig& rig) {
  json pairs = json::array();
  for (const RigPairCheck& pair : check.pairs) {
    const std::string& first = rig.camera(pair.first).name;
    const std::string& second = rig.camera(pair.second).name;
    const json changes =
        mapped(pair.changes, [&](const RigChange& change) { return changeJson(change, first, second); });
    pairs.push_back({{"first", first},
                     {"second", second},
                     {"verdict", verdictId(pair.verdict)},
                     {"gap", pair.gap == FootageGap::kNone ? json(nullptr) : json(gapId(pair.gap))},
                     {"is_behind", pair.is_behind},
                     {"explanation", orNull(pair.explanation)},
                     {"alternatives", pair.alternatives},
                     {"changes", changes},
                     {"blind_px", pair.changes.empty() ? json(nullptr) : json(pair.blind_px)},
                     {"num_instants", pair.num_instants},
                     {"num_matches", pair.num_matches},
                     {"num_used", pair.num_used},
                     {"outlier_share", pair.outlier_share},
                     {"noise_px", pair.noise_px},
                     {"rms_px", pair.rms_px},
                     {"parallax_px", pair.parallax_px}});
  }
  return jsonText(
      {{"verdict", verdictId(check.verdict)},
       {"tolerance_px", check.pairs.empty() ? json(nullptr) : json(check.pairs.front().tolerance_px)},
       {"num_instants", num_instants},
       {"pairs", std::move(pairs)}});
}

}  // namespace alidade
