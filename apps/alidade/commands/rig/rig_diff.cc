// SPDX-License-Identifier: MIT
#include "commands/rig/rig_diff.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "alidade/compare/rig_difference.h"
#include "alidade/core/degrees.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/size_groups.h"
#include "alidade/core/text.h"
#include "alidade/files/rig_file.h"
#include "alidade/report/data/json_output.h"
#include "camera_files.h"
#include "command.h"
#include "console.h"

namespace alidade {
namespace {

RigRecord rigFrom(const CameraSource& source, const CameraSource& other) {
  requireAll(source);
  if (!isRigSource(source) && source.cameras.size() == 1) {
    throw inputError({.where = source.path,
                      .found = "one camera",
                      .expected = "a rig, as " + other.path + " is one",
                      .next_step = "select a camera of the rig: " + other.path + "#" +
                                   cameraLabel(other.cameras.front())});
  }
  return rigOf(source);
}

std::vector<std::string> namesOf(const RigRecord& rig) {
  return mapped(rig.cameras, [](const RigCameraRecord& camera) { return camera.camera.name.name; });
}

// Sorts the cameras of `b` into the order of those of `a` by name, or keeps them by number.
// @returns true if the names match
bool matchCameras(const RigRecord& a, RigRecord& b, const std::string& path_a, const std::string& path_b) {
  const std::vector<std::string> names = namesOf(a);
  const std::vector<std::string> others = namesOf(b);
  if (names.size() != others.size()) {
    throw inputError(
        {.where = path_b,
         .found = fmt::format("{} cameras: {}", others.size(), join(others, ", ")),
         .expected = fmt::format("{} as in {}: {}", names.size(), path_a, join(names, ", ")),
         .next_step = "write rigs of the same cameras: alidade convert RIG#NAME RIG#NAME -o RIG"});
  }
  return orderCamerasAs(a, b);
}

void requireSameSizes(const RigRecord& a, const RigRecord& b, const std::string& path_b) {
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const ImageSize expected = a.cameras[i].camera.image_size;
    const ImageSize found = b.cameras[i].camera.image_size;
    if (expected == found) continue;
    throw inputError({.where = path_b + "#" + b.cameras[i].camera.name.name,
                      .found = "an image of " + sizeText(found) + " pixels",
                      .expected = sizeText(expected),
                      .next_step = "resize it first: alidade convert " + path_b +
                                   " -o resized.yaml --resize " + sizeText(expected)});
  }
}

std::string lensText(const LensComparison& pair) {
  const ProjectionDifference& difference = pair.difference;
  if (!isComparable(difference)) return "cannot be compared: the lenses see too little in common";
  if (difference.max_px < kEqualPx) return "no difference";
  std::string text =
      fmt::format("95 % within {:.3g} px, at most {:.3g} px", difference.p95_px, difference.max_px);
  if (difference.b_from_a.rotation.log().norm() * kDegPerRad > 1e-6) {
    text +=
        fmt::format("; aligned by {:.3g} degrees", difference.b_from_a.rotation.log().norm() * kDegPerRad);
  }
  if (pair.significance) text += pair.significance->isSignificant() ? "; significant" : "; not significant";
  return text;
}

std::string transferText(const std::optional<TransferDifference>& transfer,
                         const std::vector<std::string>& names) {
  if (!transfer) return "cannot be compared: no other camera sees enough of the same points";
  const std::string from = "pixels of " + names[transfer->from] + ": ";
  if (transfer->max_px < kEqualPx) return from + "no difference";
  return from + fmt::format("95 % within {:.3g} px, at most {:.3g} px at pixel ({:.0f}, {:.0f})",
                            transfer->p95_px, transfer->max_px, transfer->worst_pixel.x(),
                            transfer->worst_pixel.y());
}

std::string rigText(const std::vector<std::string>& names, const std::vector<LensComparison>& pairs,
                    const RigDifference& difference) {
  constexpr double kMillimetres = 1000;
  std::string text = "Lenses   each by itself\n";
  for (std::size_t i = 0; i < pairs.size(); ++i)
    text += fmt::format("  {:<10} {}\n", names[i], lensText(pairs[i]));
  text += fmt::format("Poses    from {}\n", names.front());
  for (std::size_t i = 1; i < names.size(); ++i) {
    text += fmt::format("  {:<10} {:.4g} mm and {:.4g} degrees different\n", names[i],
                        kMillimetres * difference.places[i].distance_m,
                        kDegPerRad * difference.places[i].angle_rad);
  }
  text +=
      fmt::format("Points   at {:.4g} m from one camera, in the image of another\n", difference.distance_m);
  for (std::size_t i = 0; i < names.size(); ++i)
    text += fmt::format("  {:<10} {}\n", names[i], transferText(difference.transfers[i], names));
  return text;
}

json rigJson(const std::vector<std::string>& names, const std::vector<LensComparison>& pairs,
             const RigDifference& difference) {
  json cameras = json::array();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const ProjectionDifference& lens = pairs[i].difference;
    const auto& significance = pairs[i].significance;
    const bool is_known = isComparable(lens);
    const auto& transfer = difference.transfers[i];
    json into = nullptr;
    if (transfer) {
      into = {{"from", names[transfer->from]}, {"num_compared", transfer->num_compared},
              {"rms_px", transfer->rms_px},    {"p95_px", transfer->p95_px},
              {"max_px", transfer->max_px},    {"worst_pixel", vectorJson(transfer->worst_pixel)}};
    }
    cameras.push_back({{"name", names[i]},
                       {"p95_px", is_known ? json(lens.p95_px) : json(nullptr)},
                       {"max_px", is_known ? json(lens.max_px) : json(nullptr)},
                       {"significant", significance ? json(significance->isSignificant()) : json(nullptr)},
                       {"place_difference_m", difference.places[i].distance_m},
                       {"rotation_difference_rad", difference.places[i].angle_rad},
                       {"transfer", std::move(into)}});
  }
  return {{"distance_m", difference.distance_m}, {"cameras", std::move(cameras)}};
}

// Sets the answer: that of the first lens or pose that differs, or else of the first that cannot be judged.
void judge(const std::vector<std::string>& names, const std::vector<LensComparison>& pairs,
           const RigDifference& difference, double tolerance_px, ComparedPair& rig) {
  rig.agreement = Agreement::kWithin;
  double worst_px = 0;
  const auto settle = [&](Agreement agreement, const std::string& reason, const std::string& next_step = "") {
    const ComparedPair found{.agreement = agreement, .reason = reason, .next_step = next_step};
    const std::array both = {rig, found};
    if (agreementOf(both) != rig.agreement) {
      rig.agreement = agreement;
      rig.reason = reason;
      rig.next_step = next_step;
    }
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const LensComparison& pair = pairs[i];
    settle(agreementOf(pair.difference, pair.significance, tolerance_px),
           names[i] + ": the lens: " + agreementText(pair.difference, pair.significance, tolerance_px),
           isComparable(pair.difference) ? "" : "check both files with alidade validate");
    worst_px = std::max(worst_px, pair.difference.p95_px);
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& transfer = difference.transfers[i];
    if (!transfer) {
      settle(Agreement::kNotComparable,
             fmt::format("{}: the pose cannot be judged, because no other camera sees enough of the same "
                         "points at {:.4g} m",
                         names[i], difference.distance_m),
             "add --distance with one at which the cameras' images overlap");
      continue;
    }
    worst_px = std::max(worst_px, transfer->p95_px);
    settle(transfer->p95_px > tolerance_px ? Agreement::kBeyond : Agreement::kWithin,
           fmt::format("{}: points from {} differ by {:.3g} px (95 %); limit {:g} px", names[i],
                       names[transfer->from], transfer->p95_px, tolerance_px));
  }
  if (rig.reason.empty())
    rig.reason = fmt::format("lenses and poses differ by at most {:.3g} px (95 %); limit {:g} px",
                             worst_px < kEqualPx ? 0.0 : worst_px, tolerance_px);
}

}  // namespace

LensComparison compareLenses(const CameraRecord& a, const CameraRecord& b, const DifferenceOptions& options) {
  LensComparison lens{.a = {&a.camera, a.image_size, statedCovariance(a)},
                      .b = {&b.camera, b.image_size, statedCovariance(b)},
                      .difference = {},
                      .significance = {}};
  lens.difference = projectionDifference(lens.a, lens.b, options);
  lens.significance = significanceOf(lens.difference, lens.a, lens.b, options.freed);
  return lens;
}

bool isRigSource(const CameraSource& source) {
  return source.cameras.size() > 1 &&
         std::all_of(source.cameras.begin(), source.cameras.end(),
                     [](const StatedCamera& camera) { return camera.camera_from_rig.has_value(); });
}

DiffResult diffRigs(const CameraSource& a, const CameraSource& b, const DifferenceOptions& of_cameras,
                    std::optional<double> distance_m, double tolerance_px, const CommonOptions& common) {
  const RigRecord rig_a = rigFrom(a, b);
  RigRecord rig_b = rigFrom(b, a);
  const bool is_by_name = matchCameras(rig_a, rig_b, a.path, b.path);
  requireSameSizes(rig_a, rig_b, b.path);
  std::vector<LensComparison> pairs;
  for (std::size_t i = 0; i < rig_a.cameras.size(); ++i)
    pairs.push_back(compareLenses(rig_a.cameras[i].camera, rig_b.cameras[i].camera, of_cameras));
  const RigDifference difference =
      rigDifference(rig_a.cameras, rig_b.cameras, distance_m.value_or(usualDistance(rig_a.cameras)));
  const std::vector<std::string> names = namesOf(rig_a);
  if (!common.quiet) {
    tellRemarks(a);
    tellRemarks(b);
    if (!is_by_name)
      printMessage("note: the names of the cameras differ, so they are compared in the order of the files");
  }
  DiffResult result{.pair = {.a = a.path, .b = b.path}};
  judge(names, pairs, difference, tolerance_px, result.pair);
  result.document = rigJson(names, pairs, difference);
  result.document["a"] = a.path;
  result.document["b"] = b.path;
  result.text = fmt::format("A        {}: {} cameras\nB        {}: {} cameras\n", a.path,
                            rig_a.cameras.size(), b.path, rig_b.cameras.size()) +
                rigText(names, pairs, difference);
  return result;
}

}  // namespace alidade
