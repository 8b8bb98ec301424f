// SPDX-License-Identifier: MIT
#include "alidade/files/board_file.h"
#include "alidade/target/board_spec.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const std::string text = fuzz::textOf(data, size);
  fuzz::read([&] { (void)parseBoardSpec(text); });
  fuzz::read([&] { (void)parseLength(text, "length"); });
  fuzz::read([&] { (void)parseBoard(text, "board.yaml"); });
  return 0;
}
