// SPDX-License-Identifier: MIT
// Writes a camera file in the format of another tool into the folder given and reads it back, without
// CMake.
#include "alidade/files.h"

#include <algorithm>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::vector<double> params = {532, 533, 321, 237, -0.28, 0.06, 1e-3, -5e-4, 0};
  const auto camera = alidade::AnyCamera::make("radtan", params);
  const std::string path = std::string(argv[1]) + "/kalibr.yaml";
  alidade::saveCamera(path, alidade::bareRecord(camera, {640, 480}, "package test"), "kalibr");
  const alidade::CameraRecord record = alidade::loadCamera(path);
  return std::ranges::equal(record.camera.parameters(), params) && record.image_size.width == 640 ? 0 : 1;
}
