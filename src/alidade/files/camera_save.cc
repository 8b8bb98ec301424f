// SPDX-License-Identifier: MIT
#include "alidade/files/camera_save.h"

#include <array>

#include "alidade/files/atomic_file.h"
#include "alidade/files/camera_file.h"
#include "alidade/files/formats/camera_format.h"

namespace alidade {

void saveCamera(const std::string& path, const CameraRecord& record, std::string_view format) {
  const CameraFormat& chosen = cameraFormat(format);
  // Of all formats only this program's own has room for the rest of the record.
  if (&chosen == cameraFormats().front()) return writeCameraFile(path, record);
  const std::array<NamedCamera, 1> named = {
      NamedCamera{.name = {}, .camera = record.camera, .image_size = record.image_size}};
  writeFileAtomically(path, formatText(chosen, named, path));
}

}  // namespace alidade
