// SPDX-License-Identifier: MIT
// Camera files of every format. A camera that is read is checked as `validate` does, used, and written in
// every format that has a place for it, which reads it back.
#include <array>

#include "alidade/io/camera_source.h"
#include "alidade/io/formats/camera_format.h"
#include "alidade/validate/camera_checks.h"
#include "alidade/validate/file_checks.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  fuzz::read([&] {
    const CameraSource source =
        parseCameras(fuzz::textOf(data, size), "camera", {.image_size = {}, .model = "radtan"});
    for (const StatedCamera& stated : source.cameras) {
      const ImageSize image_size = stated.image_size.value_or(sizeAround(stated.camera));
      CameraClaims claims;
      claims.camera = &stated.camera;
      claims.image_size = image_size;
      if (stated.own) claims.self_check = stated.own->self_check;
      (void)checkCamera(claims);
      (void)checkStatement({.camera = &stated.camera,
                            .image_size = stated.image_size,
                            .half_units = stated.half_units,
                            .unknown_keys = {},
                            .assumed = {}});
      const std::array<NamedCamera, 1> named = {
          NamedCamera{.name = stated.name, .camera = stated.camera, .image_size = image_size}};
      for (const CameraFormat* format : cameraFormats())
        fuzz::read([&] { (void)formatText(*format, named); });
    }
  });
  return 0;
}
