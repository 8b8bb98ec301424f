// SPDX-License-Identifier: MIT
#include "camera_files.h"

#include "alidade/camera/model_traits.h"
#include "alidade/core/mapped.h"
#include "alidade/core/text.h"
#include "alidade/files/formats/camera_format.h"
#include "console.h"

namespace alidade {

void addReadOptions(Flags& flags, ReadOptions& options, bool writes_formats) {
  const std::vector<AliasedName> formats = aliasedFormats();
  flags.under(kCameraFileGroup);
  flags.add("--image-size", &options.image_size,
            "Image size in pixels (WIDTHxHEIGHT), for camera files that do not state it", kSizeText);
  flags.add("--read-as", &options.model,
            "Model of four distortion coefficients, for files that do not state it: radtan or kannala_brandt",
            oneOf({"radtan", "kannala_brandt"}, 0, aliasedModels()));
  flags.add(writes_formats ? "--from" : "--from,--format", &options.format,
            "Format of the camera file (alidade formats), if it is not detected",
            oneOf(mapped(formats, &AliasedName::name), 0, formats));
  flags.addSwitch(
      "--apply-roi", options.applies_roi,
      "Read the camera of the published images if the file states that they are a part of the whole "
      "image (ROI, binning)");
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

void addFormatFlag(Flags& flags, std::string& format, const std::string& text, bool reads_formats) {
  const std::vector<AliasedName> formats = aliasedFormats(true);
  const std::vector<std::string> ids = mapped(formats, &AliasedName::name);
  flags.add("--to", &format, text + join(ids, ", "), oneOf(ids, 0, formats));
  flags.redirect(
      {"--format", "--output-format"},
      "--to with one of " + join(ids, ", ") + (reads_formats ? "; --from for the file that is read" : ""));
}

}  // namespace alidade
