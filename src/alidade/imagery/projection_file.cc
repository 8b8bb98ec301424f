// SPDX-License-Identifier: MIT
#include "alidade/imagery/projection_file.h"

#include <yaml-cpp/yaml.h>

#include "alidade/core/error.h"
#include "alidade/files/atomic_file.h"
#include "alidade/files/nodes.h"
#include "alidade/files/yaml_node.h"
#include "alidade/files/yaml_writer.h"

namespace alidade {
namespace {

using detail::flowMap;
using detail::writeEntries;
using detail::YamlNode;

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

void checkRays(const YamlNode& node, const OutputView& view) {
  constexpr double kRounding = 1e-9;
  for (const YamlNode& item : node.items()) {
    item.allowKeys({"pixel", "ray"});
    const std::vector<double> pixel = item.at("pixel").numbers(2);
    const std::vector<double> ray = item.at("ray").numbers(3);
    const auto computed = view.rayFromPixel({pixel[0], pixel[1]});
    if (computed && (computed->normalized() - Eigen::Vector3d(ray[0], ray[1], ray[2])).norm() <= kRounding)
      continue;
    throw item.error("a ray that does not match its pixel", "the ray computed from the numbers above",
                     "a number in the file was changed or lost; create the file again");
  }
}

OutputView readView(const YamlNode& root) {
  const YamlNode name = root.at("projection");
  OutputView view{.size = detail::readImageSize(root.at("image_size"))};
  try {
    view.projection = projectionOf(name.text());
  } catch (const Error&) {
    view.projection = ViewProjection::kRectilinear;
  }
  if (view.projection == ViewProjection::kRectilinear)
    throw name.error("'" + name.text() + "'", "cylindrical or equirectangular");
  const YamlNode step = root.at("radians_per_pixel");
  if (!(step.number() > 0)) throw step.error(step.text(), "a positive number");
  view.scale_px.setConstant(1 / step.number());
  const YamlNode axis = root.at("axis_pixel");
  axis.allowKeys({"u", "v"});
  view.axis_px = {axis.at("u").number(), axis.at("v").number()};
  return view;
}

}  // namespace

std::string projectionFileText(const ProjectionFile& file) {
  const OutputView& view = file.view;
  expect(view.projection != ViewProjection::kRectilinear, "a rectilinear view is a pinhole camera's");
  expect(view.scale_px.x() == view.scale_px.y(), "radians per pixel are equal for both coordinates");
  // The file's own number decides, so that the self check holds to the last digit.
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

ProjectionFile parseProjectionFile(const std::string& text, const std::string& name) {
  const YamlNode root = YamlNode::parse(text, name);
  root.allowKeys({"alidade_projection", "projection", "image_size", "radians_per_pixel", "axis_pixel",
                  "self_check", "created_by"});
  const YamlNode version = root.at("alidade_projection");
  if (version.integer() != 1) throw version.error("format version " + version.text(), "1");
  ProjectionFile file{.view = readView(root), .created_by = {}};
  if (const auto n = root.find("self_check")) checkRays(*n, file.view);
  if (const auto n = root.find("created_by")) file.created_by = n->text();
  return file;
}

}  // namespace alidade
