// SPDX-License-Identifier: MIT
#include "alidade/imagery/projection_file.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const std::string text = fuzz::textOf(data, size);
  fuzz::read([&] { (void)parseProjectionFile(text, "projection.yaml"); });
  return 0;
}
