// SPDX-License-Identifier: MIT
#include "alidade/io/formats/camera_format.h"

#include <algorithm>
#include <array>

#include "alidade/camera/same_lens.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/io/formats/formats.h"

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
  using namespace formats;
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
  const auto nearest = nearestName(id, ids);
  throw usageError({.where = "camera format",
                    .found = "'" + std::string(id) + "'",
                    .expected = "one of " + join(ids, ", "),
                    .next_step = nearest ? "did you mean '" + *nearest + "'?" : ""});
}

AnyCamera heldCamera(const CameraFormat& format, const AnyCamera& camera, const std::string& name) {
  const auto& models = format.models;
  const bool has_model = std::find(models.begin(), models.end(), camera.modelId()) != models.end();
  if (has_model && absentPart(format, camera).empty()) return camera;
  for (const std::string_view model : models) {
    const auto parameters = sameLensParameters(camera, model);
    if (!parameters) continue;
    AnyCamera held = AnyCamera::make(model, *parameters);
    if (absentPart(format, held).empty()) return held;
  }
  const std::vector<std::string> ids(models.begin(), models.end());
  const std::string absent = has_model ? " with " + absentPart(format, camera) + ", which has no place" : "";
  std::string expected = "a lens that " + std::string(format.title) + " can hold exactly: " + join(ids, ", ");
  for (const AbsentParameter& part : format.absent)
    expected += "; " + std::string(part.model) + " with " + std::string(part.parameter) + " = 0";
  throw inputError({.where = name,
                    .found = "a " + std::string(camera.modelId()) + " camera" + absent,
                    .expected = expected,
                    .next_step = "add --model " + ids.back() + " to fit one of these, with its error"});
}

}  // namespace alidade
