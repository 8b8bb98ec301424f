// SPDX-License-Identifier: MIT
#include "alidade/files/formats/camera_format.h"

#include <algorithm>
#include <array>

#include "alidade/camera/same_lens.h"
#include "alidade/camera/self_check.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_document.h"

namespace alidade {
namespace {

// "k3 = 0.01", the first parameter that `format` cannot say of the camera; empty if there is none.
std::string absentPart(const CameraFormat& format, const AnyCamera& camera) {
  for (const AbsentParameter& absent : format.absent) {
    if (absent.model != camera.modelId()) continue;
    const auto names = camera.parameterNames();
    const auto index = std::find(names.begin(), names.end(), absent.parameter) - names.begin();
    const double value = camera.parameters()[static_cast<std::size_t>(index)];
    if (value != 0) return std::string(absent.parameter) + " = " + exactText(value);
  }
  return "";
}

}  // namespace

std::span<const CameraFormat* const> cameraFormats() {
  using namespace detail::formats;
  static const std::array kFormats = {&alidade(),   &opencv(),  &ros(),    &kalibr(),
                                      &colmap(),    &mrcal(),   &basalt(), &nerfstudio(),
                                      &camodocal(), &orbslam(), &matlab()};
  return kFormats;
}

const CameraFormat& cameraFormat(std::string_view id) {
  std::vector<std::string> ids;
  for (const CameraFormat* format : cameraFormats()) {
    if (format->id == id) return *format;
    ids.emplace_back(format->id);
  }
  throw usageError({.where = "camera format",
                    .found = "'" + std::string(id) + "'",
                    .expected = "one of " + join(ids, ", "),
                    .next_step = didYouMean(id, ids)});
}

namespace {

// Two models that are the same lens may still end at different field angles.
bool projectsEqually(const AnyCamera& a, const AnyCamera& b, ImageSize size) {
  constexpr double kSamePx = 1e-9;
  const std::vector<SelfCheckPoint> points = makeSelfCheck(a, size);
  return std::all_of(points.begin(), points.end(), [&b](const SelfCheckPoint& point) {
    const Projection p = b.project(point.point);
    return p.ok() && (p.pixel - point.pixel).norm() < kSamePx;
  });
}

// The same lens as `camera` in a model that `format` holds.
AnyCamera heldCamera(const CameraFormat& format, const NamedCamera& named) {
  const AnyCamera& camera = named.camera;
  const auto& models = format.models;
  const bool has_model = std::find(models.begin(), models.end(), camera.modelId()) != models.end();
  if (has_model && absentPart(format, camera).empty()) return camera;
  for (const std::string_view model : models) {
    const auto parameters = sameLensParameters(camera, model);
    if (!parameters) continue;
    AnyCamera held = AnyCamera::make(model, *parameters);
    if (absentPart(format, held).empty() && projectsEqually(camera, held, named.image_size)) return held;
  }
  const std::vector<std::string> ids(models.begin(), models.end());
  std::string found = "found a " + std::string(camera.modelId()) + " camera";
  if (has_model) found += " with " + absentPart(format, camera) + ", which this format cannot represent";
  std::string expected =
      "a lens that the format " + std::string(format.title) + " can represent exactly: " + join(ids, ", ");
  for (const AbsentParameter& absent : format.absent)
    expected += "; " + std::string(absent.model) + " with " + std::string(absent.parameter) + " = 0";
  throw inputError({.where = named.where,
                    .found = found,
                    .expected = expected,
                    .next_step = "add --model with one of these to fit it and see the fitting error"});
}

}  // namespace

std::string formatText(const CameraFormat& format, std::span<const NamedCamera> cameras,
                       const std::string& path) {
  std::vector<NamedCamera> held(cameras.begin(), cameras.end());
  for (NamedCamera& named : held) named.camera = heldCamera(format, named);
  const auto dialect =
      std::find_if(format.dialects.begin(), format.dialects.end(),
                   [&path](const CameraFormat::Dialect& d) { return path.ends_with(d.extension); });
  std::string text = dialect == format.dialects.end() ? format.write(held) : dialect->write(held);
  const std::vector<StatedCamera> back =
      format.read(detail::CameraDocument(text, std::string(format.id)), {}).cameras;
  expect(back.size() == cameras.size(), "a written camera file has to hold all cameras");
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    expect(projectsEqually(cameras[i].camera, back[i].camera, cameras[i].image_size),
           "a written camera file has to project as the camera that was written");
  }
  return text;
}

}  // namespace alidade
