// SPDX-License-Identifier: MIT
#include "camera_files.h"

#include "alidade/core/mapped.h"
#include "alidade/files/formats/camera_format.h"
#include "console.h"

namespace alidade {

void addReadOptions(Flags& flags, ReadOptions& options) {
  flags.under(kCameraFileGroup);
  flags.add("--image-size", &options.image_size,
            "Image size in pixels (WIDTHxHEIGHT), for camera files that do not state it", kSizeText);
  flags.add("--read-as", &options.model,
            "Model of four distortion coefficients, for files that do not state it: radtan or kannala_brandt",
            oneOf({"radtan", "kannala_brandt"}));
  flags.under(nullptr);
}

CameraRecord readCameraTelling(const std::string& path, const ReadOptions& options, bool quiet) {
  return onlyCameraTelling(loadCameras(path, options), quiet);
}

CameraRecord onlyCameraTelling(const CameraSource& source, bool quiet) {
  CameraRecord file = onlyCamera(source);
  if (!quiet) tellRemarks(source);
  return file;
}

void tellRemarks(const CameraSource& source) {
  for (const StatedCamera& camera : source.cameras) printNotes(mapped(camera.remarks, &Remark::message));
}

std::vector<std::string> formatIds() {
  return mapped(cameraFormats(), [](const CameraFormat* format) { return std::string(format->id); });
}

}  // namespace alidade
