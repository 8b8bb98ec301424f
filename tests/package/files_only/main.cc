// SPDX-License-Identifier: MIT
// Loads a camera file and saves it again, with nothing but alidade::files.
#include "all_headers.h"

#if defined(CV_VERSION) || defined(CV_VERSION_MAJOR)
#error "a header of alidade::files includes OpenCV"
#endif
#if defined(CERES_VERSION_MAJOR) || defined(CERES_PUBLIC_CERES_H_)
#error "a header of alidade::files includes Ceres"
#endif

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::string folder = argv[1];
  std::ofstream(folder + "/given.yaml") << "alidade_camera: 1\n"
                                           "model: pinhole\n"
                                           "image_size: {width: 640, height: 480}\n"
                                           "parameters: {fx: 500, fy: 510, cx: 320, cy: 240}\n";
  const alidade::CameraRecord given = alidade::loadCamera(folder + "/given.yaml");
  alidade::saveCamera(folder + "/written.yaml", given);
  alidade::saveCamera(folder + "/ros.yaml", given, "ros");
  const alidade::CameraRecord written = alidade::loadCamera(folder + "/written.yaml");
  const bool is_same = alidade::loadCamera(folder + "/ros.yaml").image_size == given.image_size &&
                       std::ranges::equal(written.camera.parameters(), given.camera.parameters()) &&
                       written.camera.parameters()[1] == 510 && written.image_size == given.image_size;
  if (!is_same) std::fprintf(stderr, "files_only: the camera that was written is another one\n");
  return is_same ? 0 : 1;
}
