// SPDX-License-Identifier: MIT
#include "camera_options.h"

#include <CLI/CLI.hpp>

#include "alidade/core/error.h"
#include "alidade/core/text.h"
#include "command.h"

namespace alidade {

ReadOptions CameraOptions::readOptions() const {
  ReadOptions options{.image_size = {}, .model = read_as};
  if (size.empty()) return options;
  const auto parts = split(size, 'x');
  const auto width = parseInt(parts.front());
  const auto height = parts.size() == 2 ? parseInt(parts.back()) : std::nullopt;
  constexpr int kMaxSide = 1'000'000;
  if (!width || !height || *width < 1 || *height < 1 || *width > kMaxSide || *height > kMaxSide) {
    throw usageError({.where = "--image-size",
                      .found = "'" + size + "'",
                      .expected = "WIDTHxHEIGHT in pixels, such as 640x480"});
  }
  options.image_size = {.width = *width, .height = *height};
  return options;
}

CameraRecord readCameraTelling(const std::string& path, const ReadOptions& options, bool quiet) {
  const CameraSource source = loadCameras(path, options);
  CameraRecord file = onlyCamera(source);
  if (quiet) return file;
  for (const Remark& remark : source.cameras.front().remarks) printMessage("note: " + remark.message);
  return file;
}

void addCameraOptions(CLI::App& app, CameraOptions& options) {
  app.add_option("--image-size", options.size,
                 "Image size in pixels (WIDTHxHEIGHT), for camera files that do not state it");
  app.add_option(
         "--read-as", options.read_as,
         "Model of four distortion coefficients, for files that do not state it: radtan or kannala_brandt")
      ->check(CLI::IsMember({"radtan", "kannala_brandt"}));
}

}  // namespace alidade
