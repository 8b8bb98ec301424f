// SPDX-License-Identifier: MIT
#include "alidade/imagery/image_container.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)alidade::parseImageContainer({data, size});
  return 0;
}
