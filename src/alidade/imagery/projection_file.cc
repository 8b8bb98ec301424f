// SPDX-License-Identifier: MIT
#include "alidade/imagery/projection_file.h"

#include <yaml-cpp/yaml.h>

#include "alidade/core/error.h"
#include "alidade/files/text/atomic_file.h"
#include "alidade/files/text/yaml_writer.h"

namespace alidade {
namespace {

using detail::flowMap;
using detail::writeEntries;

void writeSelfCheck(YAML::Emitter& out, const OutputView& view) {
  out << YAML::BeginSeq;
  for (const double y : {0.02, 0.5, 0.98}) {
    for (const double x : {0.02, 0.5, 0.98}) {
      const Eigen::Vector2d pixel(x * (view.size.width - 1), y * (view.size.height - 1));
      const auto ray = view.rayFromPixel(pixel);
      if (ray) flowMap("pixel", pixel, "ray", ray->normalized())(out);
    }
  }
  out << YAML::EndSeq;
}

}  // namespace

std::string projectionFileText(const ProjectionFile& file) {
  const OutputView& view = file.view;
  expect(view.projection != ViewProjection::kRectilinear, "a rectilinear view is a pinhole camera's");
  expect(view.scale_px.x() == view.scale_px.y(), "radians per pixel are equal for both coordinates");
  // Uses the number as written to the file, so that the self check is exact.
  const double step = 1 / view.scale_px.x();
  OutputView written = view;
  written.scale_px.setConstant(1 / step);
  YAML::Emitter out;
  out << YAML::BeginMap;
  writeEntries(out, "alidade_projection", 1, "projection", projectionName(view.projection), "image_size",
               flowMap("width", view.size.width, "height", view.size.height), "radians_per_pixel", step,
               "axis_pixel", flowMap("u", view.axis_px.x(), "v", view.axis_px.y()));
  out << YAML::Comment("of the optical axis; (0, 0) is the centre of the top-left pixel");
  writeEntries(out, "self_check", [&written](YAML::Emitter& to) { writeSelfCheck(to, written); });
  if (!file.created_by.empty()) writeEntries(out, "created_by", file.created_by);
  out << YAML::EndMap;
  return detail::documentText(out);
}

void writeProjectionFile(const std::string& path, const ProjectionFile& file) {
  writeFileAtomically(path, projectionFileText(file));
}

}  // namespace alidade
