// SPDX-License-Identifier: MIT
#include <cstdio>

#include "alidade/camera.h"
#include "alidade/files.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const alidade::CameraRecord record = alidade::loadCamera(argv[1]);
  const alidade::Projection projection = record.camera.project({0.1, -0.05, 1.0});
  if (projection.ok()) std::printf("%.3f %.3f\n", projection.pixel.x(), projection.pixel.y());
  return projection.ok() ? 0 : 1;
}
