// SPDX-License-Identifier: MIT
#include "alidade/files/board_file.h"
#include "alidade/target/board_spec.h"
#include "fuzz.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const std::string text = fuzz::textOf(data, size);
  const fuzz::MemoryFile file(data, size);
  fuzz::read([&] { (void)parseBoardSpec(text); });
  fuzz::read([&] { (void)parseLength(text, "length"); });
  fuzz::read([&] { (void)readBoard(file.path()); });
  return 0;
}
