// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "support/scratch_folder.h"

namespace alidade {

/// A test with a folder of its own.
class ScratchTest : public testing::Test {
 protected:
  [[nodiscard]] std::string path(std::string_view name) const { return scratch_.path(name); }

  ScratchFolder scratch_;
  std::filesystem::path folder_ = scratch_.path();
};

}  // namespace alidade
