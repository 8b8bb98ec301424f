// SPDX-License-Identifier: MIT
#include "alidade/files/corners_file.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const Board board = Checkerboard{.columns = 2, .rows = 2, .square_m = 0.025};
  const std::string text = fuzz::textOf(data, size);
  fuzz::read([&] {
    const CornersFile file = parseVnlFile(text, "corners.vnl", board, {.width = 640, .height = 480});
    (void)vnlFileText(file);
  });
  return 0;
}
