// SPDX-License-Identifier: MIT
#include "support/source_tree.h"

namespace alidade {

std::string sourcePath(std::string_view name) {
  return std::string(ALIDADE_SOURCE_DIR "/").append(name);
}

}  // namespace alidade
