// SPDX-License-Identifier: MIT
#include "alidade/files/formats/camera_format.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "alidade/camera/model_fit.h"
#include "alidade/camera/model_traits.h"
#include "alidade/camera/same_lens.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"
#include "alidade/core/mapped.h"
#include "alidade/core/number_text.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"
#include "alidade/files/formats/pose_numbers.h"

namespace alidade {
namespace {

bool lacksK3(const CameraFormat& format, const AnyCamera& camera) {
  return !format.holds_k3 && camera.modelId() == "radtan" && camera.parameter("k3") != 0;
}

}  // namespace

std::span<const CameraFormat* const> cameraFormats() {
  using namespace detail::formats;
  static const std::array kFormats = {&alidade(),    &opencv(),    &ros(),     &kalibr(),
                                      &colmap(),     &colmapRig(), &mrcal(),   &basalt(),
                                      &nerfstudio(), &camodocal(), &orbslam(), &matlab()};
  return kFormats;
}

std::vector<AliasedName> aliasedFormats() {
  return mapped(cameraFormats(), [](const CameraFormat* format) {
    return AliasedName{std::string(format->id), format->aliases};
  });
}

const CameraFormat& cameraFormat(std::string_view id) {
  const auto known = cameraFormats();
  const auto found = std::ranges::find(known, id, &CameraFormat::id);
  if (found != known.end()) return **found;
  const std::vector<AliasedName> formats = aliasedFormats();
  throw usageError({.where = "camera format",
                    .found = "'" + std::string(id) + "'",
                    .expected = "one of " + join(mapped(formats, &AliasedName::name), ", "),
                    .next_step = didYouMeanOne(id, formats)});
}

namespace {

// Two equivalent models may still end at different field angles.
bool projectsEqually(const AnyCamera& a, const AnyCamera& b, ImageSize size) {
  constexpr double kSamePx = 1e-9;
  const std::vector<SelfCheckPoint> points = makeSelfCheck(a, size);
  return std::all_of(points.begin(), points.end(), [&b](const SelfCheckPoint& point) {
    const Projection p = b.project(point.point);
    return p.ok() && (p.pixel - point.pixel).norm() < kSamePx;
  });
}

// The largest shift of a pixel, px, if points this far away are projected without the entrance pupil.
double shiftByPupil(const AnyCamera& camera, ImageSize size, double distance_m) {
  const AnyCamera central = camera.withPupil({});
  double largest = 0;
  for (const SelfCheckPoint& check : makeSelfCheck(central, size)) {
    const Eigen::Vector3d point = distance_m * check.point.normalized();
    const Projection moved = camera.projectPoint(point);
    if (moved.ok()) largest = std::max(largest, (moved.pixel - central.projectPoint(point).pixel).norm());
  }
  return largest;
}

void requirePupilHeld(const CameraFormat& format, const NamedCamera& named) {
  if (format.holds_pupil || named.camera.pupil().isFixed()) return;
  const auto shift = [&](double distance_m) {
    return numberText("%.2g", shiftByPupil(named.camera, named.image_size, distance_m)) + " px at " +
           numberText("%g", distance_m) + " m";
  };
  throw detail::errorAt(
      named.where,
      "an entrance pupil that moves; without it, pixels are off by up to " + shift(0.3) + " and " + shift(3),
      "a format that can state it: alidade",
      "to leave it out, because points are far away, add --drop-pupil");
}

void requireCorrectionHeld(const CameraFormat& format, const NamedCamera& named) {
  if (format.holds_correction || named.camera.correction() == nullptr) return;
  const ModelFit fit = fitModel(named.camera, named.image_size, named.camera.modelId());
  throw detail::errorAt(named.where,
                        "a correction field; the closest " + std::string(named.camera.modelId()) +
                            " camera without one is off by " + numberText("%.2g", fit.rms_px) +
                            " px (RMS), at most " + numberText("%.2g", fit.max_error_px) + " px",
                        "a format that can state it: alidade",
                        "for the closest camera without it: alidade convert --drop-correction");
}

// An equivalent of `camera` in a model that `format` stores.
AnyCamera heldCamera(const CameraFormat& format, const NamedCamera& named) {
  const AnyCamera& camera = named.camera;
  requirePupilHeld(format, named);
  requireCorrectionHeld(format, named);
  const auto& models = format.models;
  const bool has_model = std::find(models.begin(), models.end(), camera.modelId()) != models.end();
  if (has_model && !lacksK3(format, camera)) return camera;
  for (const std::string_view model : models) {
    const auto parameters = sameLensParameters(camera, model);
    if (!parameters) continue;
    AnyCamera held = AnyCamera::make(model, *parameters);
    if (!lacksK3(format, held) && projectsEqually(camera, held, named.image_size)) return held;
  }
  const std::vector<std::string> ids(models.begin(), models.end());
  std::string found = "a " + std::string(camera.modelId()) + " camera";
  if (has_model)
    found += " with k3 = " + exactText(camera.parameter("k3")) + ", which this format cannot represent";
  std::string expected =
      "a lens that the format " + std::string(format.title) + " can represent exactly: " + join(ids, ", ");
  if (!format.holds_k3) expected += "; radtan with k3 = 0";
  throw detail::errorAt(named.where, "found " + found, expected,
                        "add --model with one of these to fit it and see the fitting error");
}

// True if the format can store a lens of the model without zero coefficients, except k3 of radtan unless
// `has_k3`.
bool canHold(const CameraFormat& format, std::string_view model, bool has_k3) {
  std::vector<double> params = {500, 500, 250, 250};
  for (const double start : modelTraits(model).start_lens) {
    const bool is_zero = !has_k3 && model == "radtan" && parameterNames(model)[params.size()] == "k3";
    params.push_back(is_zero ? 0.0 : start + 0.01);
  }
  const NamedCamera camera{
      .name = {}, .camera = AnyCamera::make(model, params), .image_size = {.width = 501, .height = 501}};
  try {
    static_cast<void>(heldCamera(format, camera));
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::vector<std::string_view> representableModels(const CameraFormat& format) {
  std::vector<std::string_view> models;
  for (const std::string& id : modelIds()) {
    if (canHold(format, id, format.holds_k3)) models.emplace_back(id);
  }
  return models;
}

std::vector<std::string_view> absentParameters(const CameraFormat& format, std::string_view model) {
  if (format.holds_k3 || model != "radtan") return {};
  return {"k3"};
}

std::vector<std::string_view> unrepresentableParameters(const CameraFormat& format, std::string_view model) {
  std::vector<std::string_view> absent = absentParameters(format, model);
  if (!absent.empty() && canHold(format, model, true)) absent.clear();
  return absent;
}

namespace {

void requireRoom(const CameraFormat& format, std::span<const NamedCamera> cameras) {
  expect(!cameras.empty(), "a camera file has a camera");
  if (cameras.size() <= format.max_cameras) return;
  throw detail::errorAt(cameras.front().where, std::to_string(cameras.size()) + " cameras",
                        "at most " + std::to_string(format.max_cameras) + " in a file of the format " +
                            std::string(format.title));
}

// True if the poses are unchanged, as far as the format stores them.
bool standEqually(const CameraFormat& format, std::span<const NamedCamera> cameras,
                  const std::vector<StatedCamera>& back) {
  const bool is_from_rig = format.poses == CameraFormat::Poses::kFromRig;
  const bool is_from_first = format.poses == CameraFormat::Poses::kFromFirst && cameras.size() > 1;
  const std::vector<SE3> poses = is_from_rig     ? detail::posesOf(cameras)
                                 : is_from_first ? detail::posesFromFirst(cameras)
                                                 : std::vector<SE3>();
  constexpr double kSame = 1e-9;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // A file with one camera may not store its pose.
    if (poses.size() == 1 && !back[i].camera_from_rig) return true;
    const SE3 read = back[i].camera_from_rig.value_or(SE3());
    const double rotation = (read.rotation.inverse() * poses[i].rotation).log().norm();
    const double distance = (read.translation - poses[i].translation).norm();
    if (!(rotation < kSame && distance <= kSame * (1 + poses[i].translation.norm()))) return false;
  }
  return true;
}

}  // namespace

std::string formatText(const CameraFormat& format, std::span<const NamedCamera> cameras,
                       const std::string& path) {
  requireRoom(format, cameras);
  std::vector<NamedCamera> held(cameras.begin(), cameras.end());
  for (NamedCamera& named : held) named.camera = heldCamera(format, named);
  std::string text = format.write(held, path);
  const std::vector<StatedCamera> back =
      format.read(detail::CameraDocument(text, std::string(format.id)), {}).cameras;
  expect(back.size() == cameras.size(), "a written camera file has to hold all cameras");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (projectsEqually(cameras[i].camera, back[i].camera, cameras[i].image_size)) continue;
    // The same coefficients may belong to models that end at different field angles.
    throw detail::errorAt(cameras[i].where,
                          "found a lens that would project differently when it is read from the format " +
                              std::string(format.title) +
                              ": it sees rays near 90 degrees, or its numbers are extreme",
                          "the same projection", "use --to alidade, or crop the image");
  }
  if (!standEqually(format, cameras, back)) {
    throw detail::errorAt(cameras.front().where,
                          "found poses that would differ when they are read from the format " +
                              std::string(format.title) + ": their numbers are extreme",
                          "the same poses", "check the unit, which is metres");
  }
  return text;
}

namespace {

constexpr std::size_t kMaxKeys = 2000;
// Shorter words resemble too many others.
constexpr std::size_t kMinNearSize = 8;
constexpr std::size_t kMaxSlip = 2;  // adjacent letters that differ

using PlacedKey = std::pair<std::string, int>;  // with its line

bool isKeyChar(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
}

// Words before a colon, quoted or not, and the names of elements: "<name". Comments have none.
void addKeys(std::string_view line, int number, std::vector<PlacedKey>& keys) {
  for (std::size_t at = 0; at < line.size();) {
    if (line[at] == '#' && (at == 0 || line[at - 1] == ' ')) return;
    const std::size_t begin = at;
    while (at < line.size() && isKeyChar(line[at])) ++at;
    if (at == begin) {
      ++at;
      continue;
    }
    std::size_t colon = at;
    if (colon < line.size() && (line[colon] == '"' || line[colon] == '\'')) ++colon;
    while (colon < line.size() && line[colon] == ' ') ++colon;
    const bool is_element = begin > 0 && line[begin - 1] == '<';
    if (is_element || (colon < line.size() && line[colon] == ':'))
      keys.push_back({std::string(line.substr(begin, at - begin)), number});
  }
}

std::vector<PlacedKey> keysOf(const std::string& text) {
  std::vector<PlacedKey> keys;
  int number = 0;
  for (const std::string_view line : split(text, '\n')) {
    addKeys(line, ++number, keys);
    if (keys.size() > kMaxKeys) break;
  }
  return keys;
}

// The last word of "Cam1.fx" and "cam_fx".
std::string_view lastWord(std::string_view key) {
  const std::size_t at = key.find_last_of("._");
  return at == std::string_view::npos ? key : key.substr(at + 1);
}

const PlacedKey* findLastWord(const std::vector<PlacedKey>& keys, std::string_view word) {
  const auto found = std::find_if(keys.begin(), keys.end(),
                                  [&](const PlacedKey& key) { return lastWord(key.first) == word; });
  return found == keys.end() ? nullptr : &*found;
}

// True if equal except for case, underscores and one typo.
bool isNearly(std::string_view key, std::string_view mark) {
  const std::string a = bareWord(key);
  const std::string b = bareWord(mark);
  if (a == b) return true;
  const std::size_t size = std::max(a.size(), b.size());
  if (std::min(a.size(), b.size()) < kMinNearSize) return false;
  const auto prefix =
      static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
  const auto suffix =
      static_cast<std::size_t>(std::mismatch(a.rbegin(), a.rend(), b.rbegin(), b.rend()).first - a.rbegin());
  constexpr std::size_t kMinPrefix = 2;  // "extrinsics" is not "intrinsics"
  return prefix >= kMinPrefix && prefix + suffix + kMaxSlip >= size;
}

// Similarity of the keys to those of one format.
FormatGuess guessOf(const CameraFormat& format, const std::vector<PlacedKey>& keys) {
  FormatGuess guess{.format = &format};
  for (const std::string_view mark : format.marks) {
    const auto isMark = [&](const PlacedKey& key) { return key.first == mark; };
    const auto isNear = [&](const PlacedKey& key) { return isNearly(key.first, mark); };
    auto found = std::find_if(keys.begin(), keys.end(), isMark);
    const bool is_near = found == keys.end();
    if (is_near) found = std::find_if(keys.begin(), keys.end(), isNear);
    if (found == keys.end()) {
      if (guess.missing.empty()) guess.missing = mark;
      continue;
    }
    // The first typo, or else the first mark.
    const bool has_near = guess.key != guess.meant;
    if (guess.num_found++ > 0 && (has_near || !is_near)) continue;
    guess.line = found->second;
    guess.key = found->first;
    guess.meant = mark;
  }
  return guess;
}

}  // namespace

std::optional<FormatGuess> guessFormat(const std::string& text) {
  const std::vector<PlacedKey> keys = keysOf(text);
  const bool is_other_file = std::any_of(keys.begin(), keys.end(), [](const PlacedKey& key) {
    return key.first == "alidade_scene" || key.first == "alidade_projection";
  });
  if (is_other_file) return std::nullopt;
  FormatGuess best;
  for (const CameraFormat* format : cameraFormats()) {
    const FormatGuess guess = guessOf(*format, keys);
    if (guess.num_found > best.num_found) best = guess;
  }
  if (best.num_found > 0) return best;
  const PlacedKey* const fx = findLastWord(keys, "fx");
  if (fx == nullptr || findLastWord(keys, "fy") == nullptr) return std::nullopt;
  const bool is_bare = fx->first == "fx";
  return FormatGuess{.format = is_bare ? &detail::formats::alidade() : &detail::formats::orbslam(),
                     .line = fx->second,
                     .key = fx->first,
                     .meant = is_bare ? "fx" : "Camera1.fx",
                     .missing = is_bare ? "alidade_camera" : ""};
}

}  // namespace alidade
