// SPDX-License-Identifier: MIT
#include "alidade/files/formats/camera_format.h"

#include <algorithm>
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
#include "alidade/files/formats/small_format.h"

namespace alidade {
namespace {

// The first parameter that is not zero and that the format does not store; empty if there is none.
std::string_view lackedParameter(const CameraFormat& format, const AnyCamera& camera) {
  for (const std::string_view parameter : absentParameters(format, camera.modelId()))
    if (camera.parameter(parameter) != 0) return parameter;
  return "";
}

// A row of the table of small formats, which are only read.
CameraFormat formatOf(const detail::SmallFormat& row) {
  CameraFormat format;
  format.id = row.id;
  format.title = row.title;
  for (const detail::SmallLens& lens : row.lenses) {
    for (const std::string_view model : modelsOf(lens))
      if (std::ranges::find(format.models, model) == format.models.end()) format.models.push_back(model);
  }
  format.max_cameras = row.cameras == "." ? 1 : CameraFormat::kAnyNumber;
  format.reads_poses = !row.pose.empty();
  format.holds_size = !row.size.empty() || row.is_size_named;
  format.recognises = [&row](const detail::CameraDocument& document) {
    return recognisesSmall(row, document);
  };
  format.read = [&row](const detail::CameraDocument& document, const ReadOptions& options) {
    return readSmall(row, document, options);
  };
  return format;
}

}  // namespace

std::string CameraFormat::camerasText() const {
  const auto text = [](std::size_t count) {
    return count >= kAnyNumber ? "any number" : std::to_string(count);
  };
  return text(max_cameras) + (max_read > max_cameras ? ", reads " + text(max_read) : "");
}

std::span<const CameraFormat* const> cameraFormats() {
  using namespace detail::formats;
  static const std::vector<CameraFormat> kSmall = mapped(detail::smallFormats(), formatOf);
  static const std::vector<const CameraFormat*> kFormats = [] {
    std::vector<const CameraFormat*> all = {&alidade(),   &opencv(), &ros(),    &kalibr(),     &colmap(),
                                            &colmapRig(), &mrcal(),  &basalt(), &nerfstudio(), &camodocal(),
                                            &orbslam(),   &matlab(), &ocam()};
    for (const CameraFormat& format : kSmall) all.push_back(&format);
    return all;
  }();
  return kFormats;
}

std::vector<AliasedName> aliasedFormats(bool only_written) {
  std::vector<AliasedName> names;
  for (const CameraFormat* format : cameraFormats()) {
    if (format->write != nullptr || !only_written)
      names.push_back({std::string(format->id), format->aliases});
  }
  return names;
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
  const std::string_view lacked = has_model ? lackedParameter(format, camera) : "";
  if (has_model && lacked.empty()) return camera;
  for (const std::string_view model : models) {
    const auto parameters = sameLensParameters(camera, model);
    if (!parameters) continue;
    AnyCamera held = AnyCamera::make(model, *parameters);
    if (lackedParameter(format, held).empty() && projectsEqually(camera, held, named.image_size)) return held;
  }
  const std::vector<std::string> ids(models.begin(), models.end());
  std::string found = "a " + std::string(camera.modelId()) + " camera";
  if (has_model) {
    found += " with " + std::string(lacked) + " = " + exactText(camera.parameter(lacked)) +
             ", which this format cannot represent";
  }
  std::string expected =
      "a lens that the format " + std::string(format.title) + " can represent exactly: " + join(ids, ", ");
  for (const auto& [model, parameter] : format.absent)
    expected += "; " + std::string(model) + " with " + std::string(parameter) + " = 0";
  throw detail::errorAt(named.where, "found " + found, expected,
                        "add --model with one of these to fit it and see the fitting error");
}

// The model as which the format stores the lens; empty if it cannot.
std::string_view heldAs(const CameraFormat& format, const NamedCamera& lens) {
  try {
    return heldCamera(format, lens).modelId();
  } catch (const Error&) {
    return "";
  }
}

NamedCamera without(std::span<const std::string_view> parameters, const NamedCamera& lens) {
  std::vector<double> params(lens.camera.parameters().begin(), lens.camera.parameters().end());
  for (const std::string_view name : parameters)
    if (const auto at = parameterIndex(lens.camera.parameterNames(), name)) params[*at] = 0;
  NamedCamera changed = lens;
  changed.camera = lens.camera.withParameters(params);
  return changed;
}

}  // namespace

NamedCamera exampleLens(std::string_view model) {
  constexpr ImageSize kSize{.width = 640, .height = 480};
  std::vector<double> params = {0.5 * kSize.width, 0.5 * kSize.width, 0.5 * (kSize.width - 1),
                                0.5 * (kSize.height - 1)};
  for (const double start : modelTraits(model).start_lens) params.push_back(start + 0.01);
  return {.name = {}, .camera = AnyCamera::make(model, params), .image_size = kSize};
}

std::vector<HeldModel> heldModels(const CameraFormat& format) {
  std::vector<HeldModel> held;
  for (const std::string& id : modelIds()) {
    const std::string_view model = modelTraits(id).id;
    const NamedCamera lens = exampleLens(model);
    const std::vector<std::string_view> absent = absentParameters(format, model);
    if (const std::string_view as = heldAs(format, lens); !as.empty()) {
      held.push_back({.model = model, .as = as});
    } else if (!absent.empty() && !heldAs(format, without(absent, lens)).empty()) {
      held.push_back({.model = model, .as = model, .absent = absent});
    }
  }
  return held;
}

std::vector<std::string_view> absentParameters(const CameraFormat& format, std::string_view model) {
  std::vector<std::string_view> parameters;
  for (const auto& [of_model, parameter] : format.absent)
    if (of_model == model) parameters.push_back(parameter);
  return parameters;
}

std::vector<std::string_view> unrepresentableParameters(const CameraFormat& format, std::string_view model) {
  std::vector<std::string_view> absent = absentParameters(format, model);
  if (!absent.empty() && !heldAs(format, exampleLens(model)).empty()) absent.clear();
  return absent;
}

namespace {

void requireRoom(const CameraFormat& format, std::span<const NamedCamera> cameras) {
  if (format.write == nullptr) {
    throw usageError({.where = "camera format",
                      .found = "'" + std::string(format.id) + "', which is only read",
                      .expected = "one of " + join(mapped(aliasedFormats(true), &AliasedName::name), ", ")});
  }
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
