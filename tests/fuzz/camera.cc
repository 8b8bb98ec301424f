// SPDX-License-Identifier: MIT
// Camera files of every format. A camera that is read is written in one of them, which reads it back, or
// checked as `validate` does. Which of this is done goes by the input's length: all of it would be slow.
#include <array>

#include "alidade/files/camera_source.h"
#include "alidade/files/formats/camera_format.h"
#include "alidade/validate/camera_checks.h"
#include "fuzz.h"

namespace alidade {
namespace {

void use(const StatedCamera& stated, std::size_t choice) {
  const ImageSize image_size = stated.image_size.value_or(sizeAround(stated.camera));
  const auto formats = cameraFormats();
  choice %= 2 * formats.size();
  if (choice == formats.size()) {
    (void)judgeCamera(stated, "camera");
    return;
  }
  if (choice > formats.size() || !formats[choice]->write) return;
  const std::array<NamedCamera, 1> named = {NamedCamera{.name = stated.name,
                                                        .camera = stated.camera,
                                                        .image_size = image_size,
                                                        .camera_from_rig = stated.camera_from_rig}};
  fuzz::read([&] { (void)formatText(*formats[choice], named); });
}

}  // namespace
}  // namespace alidade

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  fuzz::read([&] {
    // With a model named, only that one is read; without, four coefficients alone are refused.
    const ReadOptions options{.image_size = {}, .model = size % 4 == 0 ? "radtan" : ""};
    const CameraSource source = parseCameras(fuzz::textOf(data, size), "camera", options);
    for (const StatedCamera& stated : source.cameras) use(stated, size);
  });
  return 0;
}
