// SPDX-License-Identifier: MIT
#include "camera_files.h"

#include "alidade/camera/model_traits.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_format.h"
#include "console.h"

namespace alidade {

void addReadOptions(Flags& flags, ReadOptions& options) {
  flags.under(kCameraFileGroup);
  flags.add("--image-size", &options.image_size,
            "Image size in pixels (WIDTHxHEIGHT), for camera files that do not state it", kSizeText);
  flags.add("--read-as", &options.model,
            "Model of four distortion coefficients, for files that do not state it: radtan or kannala_brandt",
            oneOf({"radtan", "kannala_brandt"}, 0, aliasedModels()));
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

void addFormatFlag(Flags& flags, std::string& format, const std::string& text) {
  const std::vector<AliasedName> formats = aliasedFormats();
  const std::vector<std::string> ids = mapped(formats, &AliasedName::name);
  flags.add("--to", &format, text + join(ids, ", "), oneOf(ids, 0, formats));
  flags.redirect({"--format", "--output-format"}, "--to with one of " + join(ids, ", "));
}

}  // namespace alidade
