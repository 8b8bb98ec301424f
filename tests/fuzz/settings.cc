// SPDX-License-Identifier: MIT
#include "alidade/files/settings_file.h"
#include "fuzz.h"
#include "memory_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace alidade;
  const fuzz::MemoryFile file(data, size);
  fuzz::read([&] { (void)readSettingsFile(file.path()); });
  return 0;
}
