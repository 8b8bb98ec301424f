// SPDX-License-Identifier: MIT
#include "alidade/files/point_cloud.h"

#include <cstddef>
#include <iterator>

#include <fmt/format.h>

#include "alidade/core/error_text.h"

namespace alidade {

std::string pointCloudText(std::span<const std::string> comments,
                           std::span<const std::vector<Eigen::Vector3d>> pieces) {
  std::size_t count = 0;
  for (const auto& points : pieces) count += points.size();
  std::string text = "ply\nformat ascii 1.0\n";
  for (const std::string& comment : comments) text += "comment " + oneLine(comment) + "\n";
  text += fmt::format(
      "element vertex {}\nproperty double x\nproperty double y\nproperty double z\nproperty int piece\n"
      "end_header\n",
      count);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (const Eigen::Vector3d& p : pieces[i])
      fmt::format_to(std::back_inserter(text), "{:.9g} {:.9g} {:.9g} {}\n", p.x(), p.y(), p.z(), i + 1);
  }
  return text;
}

}  // namespace alidade
