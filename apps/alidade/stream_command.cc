// SPDX-License-Identifier: MIT
#include "stream_command.h"

#include <string_view>

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/files/camera_source.h"
#include "point_stream.h"

namespace alidade {
namespace {

const std::array<std::string_view, 4> kStatusNames = {statusId(ProjectStatus::kOk), "out_of_image",
                                                      statusId(ProjectStatus::kBehind),
                                                      statusId(ProjectStatus::kOutsideDomain)};

}  // namespace

int StreamCommand::run(const CLI::App& app) {
  if (camera_path_.empty())
    throw usageError({.where = app.get_name(),
                      .found = "no camera file",
                      .expected = "a camera file",
                      .next_step = "alidade " + app.get_name() + " --help"});
  const CameraRecord file = readCameraTelling(camera_path_, camera_.readOptions(), common_.quiet);
  prepare(file);
  AnswerWriter& out = out_.emplace(format(file));
  // Whoever writes the points may wait for these rows before writing more. A header alone is no answer.
  PointReader reader(points_path_, inputColumns(), [&] {
    if (out.hasRows()) out.flush();
  });
  out.begin();
  std::vector<Eigen::Vector3d> rows;
  while (reader.next(rows)) take(file, rows, out);
  finish(file, out);
  out.end();
  if (!common_.quiet) printMessage(countsText());
  return 0;
}

void StreamCommand::setUpStream(CLI::App& app, const char* points) {
  app.add_option("camera", camera_path_, "Camera file of any format (docs/formats.md)");
  app.add_option("points", points_path_, points);
  addCameraOptions(app, camera_);
  addCommonOptions(app, common_, false);
}

void StreamCommand::answer(std::span<const double> values, Status status, std::span<const double> details,
                           AnswerWriter& out) {
  const auto index = static_cast<std::size_t>(status);
  ++counts_[index];
  out.row(values, kStatusNames[index], details);
}

bool StreamCommand::isInImage(const Eigen::Vector2d& pixel, ImageSize size) {
  return pixel.x() >= -0.5 && pixel.x() < size.width - 0.5 && pixel.y() >= -0.5 &&
         pixel.y() < size.height - 0.5;
}

std::string StreamCommand::countsText() const {
  std::string text;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    if (counts_[i] == 0) continue;
    text += (text.empty() ? "" : ", ") + std::to_string(counts_[i]) + " " + std::string(kStatusNames[i]);
  }
  return text.empty() ? "no points" : text;
}

}  // namespace alidade
