// SPDX-License-Identifier: MIT
// Files with the name of an image, through everything that comes before the pixels are used.
#include "alidade/imagery/image_file.h"

#include <cstdlib>

#include "fuzz.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  // Large images are allowed, but would take all the time.
  [[maybe_unused]] static const int kLimit = ::setenv("OPENCV_IO_MAX_IMAGE_PIXELS", "1000000", 1);
  const fuzz::MemoryFile file(data, size);
  fuzz::read([&] { (void)readGrayImage(file.path()); });
  fuzz::read([&] { (void)readImage(file.path()); });
  return 0;
}
