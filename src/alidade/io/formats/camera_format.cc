// SPDX-License-Identifier: MIT
#include "alidade/io/formats/camera_format.h"

#include <algorithm>
#include <array>

#include "alidade/camera/same_lens.h"
#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "alidade/io/formats/formats.h"

namespace alidade {

std::span<const CameraFormat* const> cameraFormats() {
  using namespace formats;
  static const std::array kFormats = {&alidade(), &ros(), &opencv()};
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
  if (std::find(models.begin(), models.end(), camera.modelId()) != models.end()) return camera;
  for (const std::string_view model : models) {
    if (const auto parameters = sameLensParameters(camera, model)) return AnyCamera::make(model, *parameters);
  }
  const std::vector<std::string> ids(models.begin(), models.end());
  throw inputError(
      {.where = name,
       .found = "a " + std::string(camera.modelId()) + " camera",
       .expected = "a lens that " + std::string(format.title) + " can hold exactly: " + join(ids, ", "),
       .next_step = "add --model " + ids.back() + " to fit one of these, with its error"});
}

}  // namespace alidade
