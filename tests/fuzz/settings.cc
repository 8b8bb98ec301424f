// SPDX-License-Identifier: MIT
#include "alidade/files/settings_file.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const std::string text = fuzz::textOf(data, size);
  fuzz::read([&] { (void)parseSettings(text, "settings.yaml"); });
  return 0;
}
