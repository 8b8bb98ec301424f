// SPDX-License-Identifier: MIT
#include "alidade/files/camera_save.h"

#include <array>

#include "alidade/files/formats/alidade_writer.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/files/text/atomic_file.h"

namespace alidade {

std::string cameraText(const CameraRecord& record, std::string_view format, const std::string& path) {
  const CameraFormat& chosen = cameraFormat(format);
  // Only Alidade's own format stores the rest of the record.
  if (&chosen == cameraFormats().front()) return cameraFileText(record);
  const std::array<NamedCamera, 1> named = {
      NamedCamera{.name = record.name.name, .camera = record.camera, .image_size = record.image_size}};
  return formatText(chosen, named, path);
}

void saveCamera(const std::string& path, const CameraRecord& record, std::string_view format) {
  writeFileAtomically(path, cameraText(record, format, path));
}

}  // namespace alidade
