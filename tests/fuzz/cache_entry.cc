// SPDX-License-Identifier: MIT
// What a cache of corners may hold.
#include "alidade/core/error.h"
#include "alidade/detect/detection_entry.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const Board board = Checkerboard{.columns = 2, .rows = 2, .square_m = 0.025};
  const auto outcome = parseEntry(fuzz::textOf(data, size), board);
  if (!outcome) return 0;
  for (const Corner& corner : outcome->detection.corners) {
    expect(corner.id >= 0 && corner.id < board.numCorners() && corner.pixel.allFinite(),
           "a corner of the board");
  }
  const std::string text = entryText(*outcome);
  const auto again = parseEntry(text, board);
  expect(again && entryText(*again) == text, "the same outcome when it is read again");
  return 0;
}
